// Pictures of measured values: images and maps in colour, shaded relief, paths on maps, and colour
// bars with numbers. The report and the PNG files of the commands are made of these.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palette.hpp"
#include "tread/core/grid.hpp"
#include "tread/core/image.hpp"
#include "tread/geometry/trajectory.hpp"

namespace tread {

inline constexpr Rgb kUnknownColour{98, 105, 117};
inline constexpr Rgb kLethalColour{255, 255, 255};
inline constexpr Rgb kPathColour{0, 224, 255};
inline constexpr Rgb kTrajectoryColour{255, 255, 255};
inline constexpr Rgb kWaypointColour{255, 255, 255};
inline constexpr Rgb kStartColour{46, 204, 113};
inline constexpr Rgb kGoalColour{255, 61, 113};

// How values become colours, and what the legend beside the picture says.
struct ColourScale {
  std::string label = {};  // "height"
  std::string unit = {};   // "m"; empty for plain numbers
  Palette palette = Palette::kHeight;
  bool reversed = false;         // the first colour is that of `high`: depth, so that near is warm
  float low = 0.0F;              // and below
  float high = 1.0F;             // and above
  Rgb unknown = kUnknownColour;  // NaN, and infinite unless that is lethal
  std::string unknown_label = "unknown";
  std::optional<float> lethal_from = {};  // values of this size and above get a colour of their own
  Rgb lethal = kLethalColour;
};
[[nodiscard]] Rgb colour_of(const ColourScale& scale, float value);
// The colour at a share of the way from low to high.
[[nodiscard]] Rgb colour_at(const ColourScale& scale, double share);

// The range of the finite values without the given share of outliers at each end; 0 to 1 if there
// are none. Never empty: high > low.
struct ValueRange {
  float low = 0.0F;
  float high = 1.0F;
};
[[nodiscard]] ValueRange value_range(ImageView<const float> values, double outlier_share = 0.01);
[[nodiscard]] ValueRange value_range(const Grid<float>& values, double outlier_share = 0.01);

// One pixel a value.
[[nodiscard]] Image<Rgb> colour_map(ImageView<const float> values, const ColourScale& scale);
[[nodiscard]] Image<Rgb> colour_map(ImageView<const float> values, float low, float high,
                                    Palette palette, Rgb unknown = kUnknownColour);
[[nodiscard]] Image<Rgb> grey_picture(ImageView<const std::uint8_t> grey);
[[nodiscard]] Image<Rgb> enlarge(ImageView<const Rgb> picture, int factor);
// Two pictures of one height next to each other (left and right image).
[[nodiscard]] Image<Rgb> side_by_side(ImageView<const Rgb> left, ImageView<const Rgb> right,
                                      int gap_px = 8);

// The part of a map where anything is known, with a margin; the whole map if nothing is.
[[nodiscard]] Grid<float> crop_to_known(const Grid<float>& values, int margin_cells = 2);
// Cells joined factor by factor, the mean of what is known in each.
[[nodiscard]] Grid<float> shrink(const Grid<float>& values, int factor);

// A map as a picture: y up, x to the right, each cell a square of pixels.
struct MapPicture {
  Image<Rgb> image;
  Eigen::Vector2d lower_left = Eigen::Vector2d::Zero();  // metres, corner of the picture
  double pixels_per_m = 1.0;

  // Where a point of the map's frame is in the picture; may be outside.
  [[nodiscard]] Eigen::Vector2d pixel_of(const Eigen::Vector2d& p) const {
    return {(p.x() - lower_left.x()) * pixels_per_m - 0.5,
            image.height - (p.y() - lower_left.y()) * pixels_per_m - 0.5};
  }
};
// The longer side gets about `wanted_px` pixels: small maps are enlarged by a whole factor, large
// ones are shrunk.
[[nodiscard]] MapPicture draw_map(const Grid<float>& values, const ColourScale& scale,
                                  int wanted_px = 900);
// The same for heights, with light from the upper left, heights drawn `exaggeration` times as high.
[[nodiscard]] MapPicture draw_relief(const Grid<float>& height, const ColourScale& scale,
                                     int wanted_px = 900, double exaggeration = 1.0);

// Points in metres in the frame of the map.
void draw_path(MapPicture& map, std::span<const Eigen::Vector2d> path, Rgb colour = kPathColour,
               double width_px = 4.0);
void draw_waypoints(MapPicture& map, std::span<const Eigen::Vector2d> waypoints);
void draw_start(MapPicture& map, const Eigen::Vector2d& start);
// A goal beyond the picture is shown by an arrow where the way to it, straight from `from` (the
// middle of the picture if that is not given or outside), leaves the picture.
void draw_goal(MapPicture& map, const Eigen::Vector2d& goal,
               const std::optional<Eigen::Vector2d>& from = std::nullopt);
// The way of a camera over the ground; the last pose has a wedge in its direction of view. Poses
// are T_world_camera; `forward` is the viewing direction in camera axes.
void draw_trajectory(MapPicture& map, const Trajectory& trajectory,
                     const Eigen::Vector3d& forward = Eigen::Vector3d::UnitZ());
// A bar of 1, 2 or 5 times a power of ten metres in the lower left corner.
void draw_scale_bar(MapPicture& map);

// The picture with a colour bar and numbers at its right, for PNG files that stand alone.
[[nodiscard]] Image<Rgb> with_colour_bar(ImageView<const Rgb> picture, const ColourScale& scale);

// "12.3 m", three or four digits, never an exponent between 0.001 and 100000.
[[nodiscard]] std::string number_text(double value, const std::string& unit = "");
// Round numbers within [low, high], about `count` of them.
[[nodiscard]] std::vector<double> round_ticks(double low, double high, int count);

}  // namespace tread
