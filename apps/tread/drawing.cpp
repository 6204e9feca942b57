// Lines, discs and rings are drawn from the distance of a pixel to the shape: inside by half a
// pixel it is covered, outside by half a pixel it is not. Cost: the pixels of the box around each
// piece of line. Text is OpenCV's stroke font.
#include "drawing.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace tread {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;

struct Box {
  int left, top, right, bottom;  // right and bottom not included
};

// The pixels within `reach` of the box of two points, cut to the picture. Cut as doubles first: a
// point may lie further away than whole numbers reach.
Box box_around(ImageView<Rgb> picture, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
               double reach) {
  const Eigen::Vector2d size(picture.width, picture.height);
  const Eigen::Vector2d low =
      (a.cwiseMin(b).array() - reach).floor().matrix().cwiseMax(0.0).cwiseMin(size);
  const Eigen::Vector2d high =
      (a.cwiseMax(b).array() + reach + 1.0).ceil().matrix().cwiseMax(0.0).cwiseMin(size);
  return {static_cast<int>(low.x()), static_cast<int>(low.y()), static_cast<int>(high.x()),
          static_cast<int>(high.y())};
}

double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                           const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

double coverage(double distance_outside) {
  return std::clamp(0.5 - distance_outside, 0.0, 1.0);
}

// The picture as OpenCV sees it, sharing its pixels. The channels stay red, green, blue.
cv::Mat borrow(ImageView<Rgb> picture) {
  return {picture.height, picture.width, CV_8UC3, picture.data,
          static_cast<std::size_t>(picture.stride) * sizeof(Rgb)};
}

double font_scale(int height_px) {
  return cv::getFontScaleFromHeight(kFont, height_px, 1);
}

}  // namespace

void blend(ImageView<Rgb> picture, int x, int y, Rgb colour, double opacity) {
  if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return;
  Rgb& pixel = picture(x, y);
  const auto mix = [opacity](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(std::lround(std::lerp(from, to, opacity)));
  };
  pixel = {mix(pixel.r, colour.r), mix(pixel.g, colour.g), mix(pixel.b, colour.b)};
}

void draw_polyline(ImageView<Rgb> picture, std::span<const Eigen::Vector2d> points, double width_px,
                   Rgb colour) {
  const double radius = 0.5 * width_px;
  const std::size_t pieces = points.size() == 1 ? 1 : std::max<std::size_t>(points.size(), 1) - 1;
  for (std::size_t i = 0; i < pieces; ++i) {
    const Eigen::Vector2d& a = points[i];
    const Eigen::Vector2d& b = points[std::min(i + 1, points.size() - 1)];
    if (!a.allFinite() || !b.allFinite()) continue;
    const Box box = box_around(picture, a, b, radius + 1.0);
    for (int y = box.top; y < box.bottom; ++y) {
      for (int x = box.left; x < box.right; ++x) {
        const double opacity = coverage(distance_to_segment({x, y}, a, b) - radius);
        if (opacity > 0.0) blend(picture, x, y, colour, opacity);
      }
    }
  }
}

void draw_disc(ImageView<Rgb> picture, const Eigen::Vector2d& centre, double radius_px,
               Rgb colour) {
  draw_polyline(picture, {&centre, 1}, 2.0 * radius_px, colour);
}

void draw_ring(ImageView<Rgb> picture, const Eigen::Vector2d& centre, double radius_px,
               double width_px, Rgb colour) {
  if (!centre.allFinite()) return;
  const Box box = box_around(picture, centre, centre, radius_px + width_px);
  for (int y = box.top; y < box.bottom; ++y) {
    for (int x = box.left; x < box.right; ++x) {
      const double from_circle = std::abs((Eigen::Vector2d(x, y) - centre).norm() - radius_px);
      const double opacity = coverage(from_circle - 0.5 * width_px);
      if (opacity > 0.0) blend(picture, x, y, colour, opacity);
    }
  }
}

void fill_rectangle(ImageView<Rgb> picture, int x, int y, int width, int height, Rgb colour,
                    double opacity) {
  for (int row = std::max(y, 0); row < std::min(y + height, picture.height); ++row) {
    for (int column = std::max(x, 0); column < std::min(x + width, picture.width); ++column) {
      blend(picture, column, row, colour, opacity);
    }
  }
}

TextSize text_size(const std::string& text, int height_px) {
  int below = 0;
  const cv::Size size = cv::getTextSize(text, kFont, font_scale(height_px), 1, &below);
  return {size.width, size.height};
}

void draw_text(ImageView<Rgb> picture, int x, int y, const std::string& text, int height_px,
               Rgb colour) {
  if (picture.empty()) return;
  cv::Mat canvas = borrow(picture);
  cv::putText(canvas, text, {x, y}, kFont, font_scale(height_px),
              cv::Scalar(colour.r, colour.g, colour.b), 1, cv::LINE_AA);
}

}  // namespace tread
