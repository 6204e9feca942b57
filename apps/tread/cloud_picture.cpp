#include "cloud_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "pictures.hpp"

namespace tread {
namespace {

constexpr double kAzimuth_rad = 0.45;   // from straight ahead towards the left
constexpr double kElevation_rad = 0.6;  // downwards

struct Span {
  float low;
  float high;
};

// Between which all but the hundredth part at either end lies.
Span span_of(const std::vector<Eigen::Vector3f>& points, int axis) {
  std::vector<float> values;
  values.reserve(points.size());
  for (const Eigen::Vector3f& p : points) values.push_back(p[axis]);
  const auto at = [&values](double share) {
    const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + place, values.end());
    return values[static_cast<std::size_t>(place)];
  };
  return {at(0.01), at(0.99)};
}

}  // namespace

Image<Rgb> draw_cloud(const PointCloud& cloud, const Isometry3d& T_level_points, int width_px,
                      int height_px) {
  if (cloud.points.empty()) return {};
  // Rows: right and up in the picture, and away from the eye.
  const double ca = std::cos(kAzimuth_rad), sa = std::sin(kAzimuth_rad);
  const double ce = std::cos(kElevation_rad), se = std::sin(kElevation_rad);
  Eigen::Matrix3d R_view_level;
  R_view_level << sa, -ca, 0.0, se * ca, se * sa, ce, ce * ca, ce * sa, -se;
  const Eigen::Matrix3f R = (R_view_level * T_level_points.linear()).cast<float>();
  std::vector<Eigen::Vector3f> seen;
  seen.reserve(cloud.points.size());
  for (const Eigen::Vector3f& p : cloud.points) seen.push_back(R * p);

  constexpr float kMargin = 0.94F;
  const Span across = span_of(seen, 0), up = span_of(seen, 1);
  const auto width = static_cast<float>(width_px), height = static_cast<float>(height_px);
  const float scale = kMargin * std::min(width / std::max(across.high - across.low, 1e-3F),
                                         height / std::max(up.high - up.low, 1e-3F));
  const auto column = [&](float x) {
    return 0.5F * width + scale * (x - 0.5F * (across.low + across.high));
  };
  const auto row = [&](float y) { return 0.5F * height - scale * (y - 0.5F * (up.low + up.high)); };

  const Eigen::Vector3f z_axis = T_level_points.linear().cast<float>().row(2);
  std::vector<Rgb> by_height;
  if (cloud.colours.empty()) {
    Image<float> heights(static_cast<int>(cloud.points.size()), 1);
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      heights(static_cast<int>(i), 0) = z_axis.dot(cloud.points[i]);
    }
    const ValueRange range = value_range(heights, 0.01);
    const Image<Rgb> coloured = colour_map(
        heights, ColourScale{.palette = Palette::kHeight, .low = range.low, .high = range.high});
    by_height.assign(coloured.row(0), coloured.row(0) + coloured.width);
  }
  const std::vector<Rgb>& colours = cloud.colours.empty() ? by_height : cloud.colours;

  // As large as leaves no gaps where the points lie side by side.
  const double area = static_cast<double>(width_px) * height_px / static_cast<double>(seen.size());
  const int radius = std::clamp(static_cast<int>(std::lround(0.5 * std::sqrt(area))), 0, 4);
  Image<Rgb> picture(width_px, height_px, kUnknownColour);
  Image<float> nearest(width_px, height_px, std::numeric_limits<float>::max());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const float x = column(seen[i].x()), y = row(seen[i].y());
    if (!(x > -10.0F && y > -10.0F && x < width + 10.0F && y < height + 10.0F)) continue;
    const int u0 = static_cast<int>(std::lround(x)), v0 = static_cast<int>(std::lround(y));
    for (int v = std::max(0, v0 - radius); v <= std::min(height_px - 1, v0 + radius); ++v) {
      for (int u = std::max(0, u0 - radius); u <= std::min(width_px - 1, u0 + radius); ++u) {
        if (seen[i].z() >= nearest(u, v)) continue;
        nearest(u, v) = seen[i].z();
        picture(u, v) = colours[i];
      }
    }
  }
  return picture;
}

}  // namespace tread
