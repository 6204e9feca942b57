// What is drawn upon maps: paths, places, the scale bar, and the colour bar beside them. Every mark
// is drawn twice, a wider dark one below, so that it stands out on any ground.
#include <algorithm>
#include <cmath>
#include <vector>

#include "drawing.hpp"
#include "pictures.hpp"

namespace tread {
namespace {

constexpr Rgb kShadow{16, 19, 26};
constexpr Rgb kWhite{255, 255, 255};
constexpr double kHalo = 3.0;  // pixels by which the dark line is wider

std::vector<Eigen::Vector2d> pixels_of(const MapPicture& map,
                                       std::span<const Eigen::Vector2d> points) {
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector2d& p : points) pixels.push_back(map.pixel_of(p));
  return pixels;
}

void draw_line(MapPicture& map, std::span<const Eigen::Vector2d> pixels, double width, Rgb colour) {
  draw_polyline(map.image, pixels, width + kHalo, kShadow);
  draw_polyline(map.image, pixels, width, colour);
}

// An arrow head with its point at `tip`.
void draw_arrow_head(MapPicture& map, const Eigen::Vector2d& tip, const Eigen::Vector2d& direction,
                     double size, Rgb colour) {
  const Eigen::Vector2d along = direction.normalized(), across(-along.y(), along.x());
  const Eigen::Vector2d pixels[] = {tip - size * (along - 0.7 * across), tip,
                                    tip - size * (along + 0.7 * across)};
  draw_line(map, pixels, 4.0, colour);
}

// A ground-plane direction of the frame as a unit vector of the picture; zero if it is vertical.
Eigen::Vector2d picture_direction(const Eigen::Vector3d& direction) {
  const Eigen::Vector2d flat(direction.x(), -direction.y());
  return flat.norm() < 1e-6 ? Eigen::Vector2d(0.0, 0.0) : Eigen::Vector2d(flat.normalized());
}

// Where the way from a point of the picture to one outside comes near the border.
Eigen::Vector2d last_inside(const Eigen::Vector2d& start, const Eigen::Vector2d& target,
                            const Eigen::Vector2d& size) {
  constexpr double kMargin = 6.0;
  double share = 1.0;
  for (int axis = 0; axis < 2; ++axis) {
    const double border = target[axis] < start[axis] ? kMargin : size[axis] - 1.0 - kMargin;
    const double way = target[axis] - start[axis];
    if (way != 0.0) share = std::clamp((border - start[axis]) / way, 0.0, share);
  }
  return start + share * (target - start);
}

double largest_round(double limit) {
  const double power = std::pow(10.0, std::floor(std::log10(limit)));
  const double lead = limit / power;
  return power * (lead >= 5.0 ? 5.0 : lead >= 2.0 ? 2.0 : 1.0);
}

}  // namespace

void draw_path(MapPicture& map, std::span<const Eigen::Vector2d> path, Rgb colour,
               double width_px) {
  draw_line(map, pixels_of(map, path), width_px, colour);
}

void draw_waypoints(MapPicture& map, std::span<const Eigen::Vector2d> waypoints) {
  for (const Eigen::Vector2d& pixel : pixels_of(map, waypoints)) {
    draw_disc(map.image, pixel, 6.5, kShadow);
    draw_disc(map.image, pixel, 5.0, kWaypointColour);
  }
}

void draw_start(MapPicture& map, const Eigen::Vector2d& start) {
  const Eigen::Vector2d pixel = map.pixel_of(start);
  draw_disc(map.image, pixel, 11.5, kShadow);
  draw_disc(map.image, pixel, 10.0, kWhite);
  draw_disc(map.image, pixel, 7.0, kStartColour);
}

void draw_goal(MapPicture& map, const Eigen::Vector2d& goal,
               const std::optional<Eigen::Vector2d>& from) {
  const Eigen::Vector2d pixel = map.pixel_of(goal);
  const Eigen::Vector2d size(map.image.width, map.image.height);
  const auto inside = [&](const Eigen::Vector2d& p) {
    return (p.array() >= 0.0).all() && (p.array() < size.array()).all();
  };
  if (!inside(pixel)) {
    Eigen::Vector2d start = from ? map.pixel_of(*from) : pixel;
    if (!inside(start)) start = 0.5 * size;
    draw_arrow_head(map, last_inside(start, pixel, size), pixel - start, 13.0, kGoalColour);
    return;
  }
  draw_disc(map.image, pixel, 13.5, kShadow);
  draw_disc(map.image, pixel, 12.0, kWhite);
  draw_ring(map.image, pixel, 8.0, 3.0, kGoalColour);
  draw_disc(map.image, pixel, 3.5, kGoalColour);
}

void draw_trajectory(MapPicture& map, const Trajectory& trajectory,
                     const Eigen::Vector3d& forward) {
  if (trajectory.empty()) return;
  std::vector<Eigen::Vector2d> pixels;
  for (const StampedPose& pose : trajectory) {
    pixels.push_back(map.pixel_of(pose.pose.translation().head<2>()));
  }
  const Eigen::Vector2d view = picture_direction(trajectory.back().pose.linear() * forward);
  const Eigen::Vector2d across(-view.y(), view.x());
  const Eigen::Vector2d wedge[] = {pixels.back() + 26.0 * view + 15.0 * across, pixels.back(),
                                   pixels.back() + 26.0 * view - 15.0 * across};
  if (view.norm() > 0.5) draw_line(map, wedge, 2.5, kTrajectoryColour);
  draw_line(map, pixels, 3.0, kTrajectoryColour);
  draw_disc(map.image, pixels.back(), 6.5, kShadow);
  draw_disc(map.image, pixels.back(), 5.0, kTrajectoryColour);
}

void draw_scale_bar(MapPicture& map) {
  constexpr int kLetters = 16, kMargin = 12, kPadding = 9;
  const double room_m = 0.3 * map.image.width / map.pixels_per_m;
  if (!(room_m > 0.0)) return;
  const double length_m = largest_round(room_m);
  const int length = static_cast<int>(std::lround(length_m * map.pixels_per_m));
  const std::string text =
      length_m < 1.0 ? number_text(100.0 * length_m, "cm") : number_text(length_m, "m");
  const TextSize size = text_size(text, kLetters);
  const int width = std::max(length, size.width) + 2 * kPadding;
  const int height = size.height + 8 + 5 + 2 * kPadding;
  const int left = kMargin, top = map.image.height - kMargin - height;
  fill_rectangle(map.image, left, top, width, height, kShadow, 0.72);
  draw_text(map.image, left + (width - size.width) / 2, top + kPadding + size.height, text,
            kLetters, kWhite);
  const int bar_left = left + (width - length) / 2, bar_top = top + kPadding + size.height + 8;
  fill_rectangle(map.image, bar_left, bar_top, length, 3, kWhite);
  fill_rectangle(map.image, bar_left, bar_top - 3, 2, 6, kWhite);
  fill_rectangle(map.image, bar_left + length - 2, bar_top - 3, 2, 6, kWhite);
}

namespace {

// The panel beside the picture: title, bar with numbers, and swatches of the colours off the scale.
struct BarLayout {
  int letters, left, top, bar_width, bar_height;
};

void draw_bar(Image<Rgb>& picture, const ColourScale& scale, const BarLayout& at) {
  for (int i = 0; i < at.bar_height; ++i) {
    const double share = 1.0 - static_cast<double>(i) / std::max(1, at.bar_height - 1);
    fill_rectangle(picture, at.left, at.top + i, at.bar_width, 1, colour_at(scale, share));
  }
  const double span = static_cast<double>(scale.high) - scale.low;
  for (const double tick :
       round_ticks(scale.low, scale.high, std::clamp(at.bar_height / 60, 2, 6))) {
    const double share = (tick - scale.low) / span;
    const int y = at.top + static_cast<int>(std::lround((1.0 - share) * (at.bar_height - 1)));
    fill_rectangle(picture, at.left + at.bar_width, y, 5, 1, kShadow);
    draw_text(picture, at.left + at.bar_width + 9, y + at.letters / 2 - 1, number_text(tick),
              at.letters, kShadow);
  }
}

void draw_swatch(Image<Rgb>& picture, int left, int top, int letters, Rgb colour,
                 const std::string& text) {
  fill_rectangle(picture, left, top, letters, letters, kShadow);
  fill_rectangle(picture, left + 1, top + 1, letters - 2, letters - 2, colour);
  draw_text(picture, left + letters + 7, top + letters - 2, text, letters, kShadow);
}

}  // namespace

Image<Rgb> with_colour_bar(ImageView<const Rgb> picture, const ColourScale& scale) {
  constexpr int kLetters = 13, kGap = 14, kLine = 20, kBarWidth = 18;
  const std::string title =
      scale.unit.empty() ? scale.label : scale.label + " [" + scale.unit + "]";
  const std::string lethal =
      scale.lethal_from ? "lethal, from " + number_text(*scale.lethal_from) : "";
  int panel = kBarWidth + 70;
  for (const std::string& text : {title, scale.unknown_label, lethal}) {
    panel = std::max(panel, text_size(text, kLetters).width + kLetters + 7);
  }
  const int swatches = (scale.unknown_label.empty() ? 0 : 1) + (scale.lethal_from ? 1 : 0);
  const int height = std::max(picture.height, 160 + kLine * swatches);
  Image<Rgb> out(picture.width + 2 * kGap + panel, height, kWhite);
  for (int y = 0; y < picture.height; ++y) {
    std::copy(picture.row(y), picture.row(y) + picture.width, out.row(y));
  }
  const int left = picture.width + kGap;
  draw_text(out, left, kGap + kLetters - 2, title, kLetters, kShadow);
  const int top = kGap + kLetters + 14;
  draw_bar(out, scale, {kLetters, left, top, kBarWidth, height - top - kGap - kLine * swatches});
  int y = height - kGap - kLine * swatches + 8;
  if (!scale.unknown_label.empty()) {
    draw_swatch(out, left, y, kLetters, scale.unknown, scale.unknown_label);
    y += kLine;
  }
  if (scale.lethal_from) draw_swatch(out, left, y, kLetters, scale.lethal, lethal);
  return out;
}

}  // namespace tread
