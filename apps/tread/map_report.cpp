#include "map_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cloud_picture.hpp"
#include "command.hpp"
#include "tread/pipeline/odometry_source.hpp"
#include "tread/stereo/edge_image.hpp"

namespace tread {
namespace {

template <class T>
Image<T> copy_of(ImageView<const T> view) {
  Image<T> copy(view.width, view.height);
  for (int y = 0; y < view.height; ++y)
    std::copy(view.row(y), view.row(y) + view.width, copy.row(y));
  return copy;
}

ColourScale height_scale(const Grid<float>& height, const std::string& label) {
  const ValueRange range = value_range(height, 0.01);
  return {.label = label,
          .unit = "m",
          .palette = Palette::kHeight,
          .low = range.low,
          .high = range.high};
}

// Up to the squared response of a step of 20 cm, beyond which all is an obstacle.
ColourScale derivative_scale() {
  return {.label = "squared derivative",
          .unit = "m2",
          .palette = Palette::kCost,
          .low = 0.0F,
          .high = 0.64F,
          .unknown_label = "not explored"};
}

// Around the middle grey, which is no edge, to the whole range of greys.
Image<std::uint8_t> stretched(Image<std::uint8_t> edges) {
  int largest = 1;
  for (int y = 0; y < edges.height; ++y) {
    for (int x = 0; x < edges.width; ++x) largest = std::max(largest, std::abs(edges(x, y) - 128));
  }
  for (int y = 0; y < edges.height; ++y) {
    for (int x = 0; x < edges.width; ++x) {
      edges(x, y) = static_cast<std::uint8_t>(128 + (edges(x, y) - 128) * 127 / largest);
    }
  }
  return edges;
}

std::string robot_place(const GridGeometry& shown) {
  const std::string levelled = "Levelled: pitch and roll taken out, yaw left in. The robot ";
  const double left_m = shown.origin.x();
  if (left_m < 0.0) return levelled + "is at (0, 0) and looks to the right.";
  return levelled +
         fmt::format("is {:.1f} m beyond the left border and looks to the right.", left_m);
}

void add_frame_section(const RoverMapper& mapper, const FrameSample& sample, Report& report) {
  report.add_section("One frame on its way",
                     fmt::format("Frame {}: from the pair to the local derivative. Only the local "
                                 "map, consistent in itself, is derived.",
                                 sample.name));
  const bool wide = sample.depth.width > 1000;
  report.add_figure(sample.left, {.title = "Left image", .wide = wide});
  report.add_figure(grey_picture(sample.right), {.title = "Right image", .wide = wide});
  report.add_figure(grey_picture(stretched(sample.edges)),
                    {.title = "Edge image",
                     .caption = "Of the left image, contrast stretched: what is matched.",
                     .wide = wide});
  const ValueRange d = value_range(sample.disparity_px, 0.002);
  const ColourScale disparity{.label = "disparity",
                              .unit = "px",
                              .palette = Palette::kDisparity,
                              .low = d.low,
                              .high = d.high,
                              .unknown_label = "no match"};
  report.add_figure(colour_map(sample.disparity_px, disparity),
                    {.title = "Disparity",
                     .scale = disparity,
                     .values = values_under(sample.disparity_px),
                     .wide = wide});
  const ValueRange z = value_range(sample.depth, 0.005);
  const ColourScale depth{.label = "depth",
                          .unit = "m",
                          .palette = Palette::kDisparity,
                          .reversed = true,
                          .low = z.low,
                          .high = z.high,
                          .unknown_label = "unknown or beyond the range"};
  report.add_figure(colour_map(sample.depth, depth),
                    {.title = "Depth",
                     .caption = fmt::format("Kept between {:.1f} and {:.1f} m.",
                                            mapper.options().depth.min_depth_m,
                                            mapper.options().depth.max_depth_m),
                     .scale = depth,
                     .values = values_under(sample.depth),
                     .wide = wide});
  const Image<Rgb> cloud =
      draw_cloud(sample.cloud, sample.T_level_points, wide ? 1200 : 640, wide ? 560 : 480);
  if (!cloud.empty()) {
    report.add_figure(
        cloud, {.title = "Point cloud",
                .caption = fmt::format("{} points, seen from behind the camera and above it.",
                                       sample.cloud.points.size()),
                .wide = wide});
  }
  const ColourScale height = height_scale(sample.height, "height");
  const Grid<float> known = crop_to_known(sample.height);
  MapPicture local = draw_relief(known, height, 500);
  draw_scale_bar(local);
  report.add_figure(local.image, {.title = "Local height map",
                                  .caption = robot_place(known.geometry),
                                  .scale = height,
                                  .values = values_under(known, "local")});
  // The same cells as the heights, so that both pictures show the same place.
  Grid<float> derived(known.geometry, std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < derived.geometry.rows; ++y) {
    for (int x = 0; x < derived.geometry.columns; ++x) {
      const Cell cell = sample.derivative.geometry.cell_at(derived.geometry.centre({x, y}));
      if (sample.derivative.geometry.contains(cell)) derived[{x, y}] = sample.derivative[cell];
    }
  }
  MapPicture derivative = draw_map(derived, derivative_scale(), 500);
  draw_scale_bar(derivative);
  report.add_figure(derivative.image,
                    {.title = "Local derivative",
                     .caption = "Squared Sobel response, only where all nine cells are known.",
                     .scale = derivative_scale(),
                     .values = values_under(derived, "local")});
}

std::vector<Quantity> quantities(const StereoSource& source, const RoverMapper& mapper) {
  const RectifiedRig& rig = mapper.rig();
  std::vector<Quantity> list = {
      {"focal length", fmt::format("{:.1f} px", rig.fx_px)},
      {"baseline", fmt::format("{:.3f} m", rig.baseline_m)},
      {"range", fmt::format("{:.1f} m", mapper.options().depth.max_depth_m), false,
       mapper.options().extend_range
           ? "depth.max_depth_m, or where a quarter pixel is one cell if that is farther"
           : ""}};
  const std::optional<CameraMount>& mount = source.rig().mount;
  const double height = mount ? mount->T_body_left.translation().z() : 0.0;
  const double pitch =
      mount ? std::asin(std::clamp(-(mount->T_body_left.linear() * Eigen::Vector3d::UnitZ()).z(),
                                   -1.0, 1.0))
            : 0.0;
  const bool assumed = !mount || mount->assumed;
  list.push_back({"camera height", fmt::format("{:.2f} m", height), assumed,
                  mount ? "" : "the rig has no mount"});
  const double down = std::round(pitch * 572.9578) / 10.0 + 0.0;  // no -0.0
  list.push_back({"camera pitch", fmt::format("{:.1f} degrees down", down), assumed});
  if (is_placed_by_odometry(source)) {
    list.push_back({"pose", "visual odometry", false, "from the first pair on; it drifts"});
  } else if (!source.has_poses()) {
    list.push_back({"pose", "the robot stands at the origin", true, "one pair without poses"});
  }
  return list;
}

// The left image as it was matched, in colour where the frame has colours that need no more than
// shrinking.
Image<Rgb> matched_colours(const StereoFrame& frame, const RoverFrame& mapped,
                           const RoverMapper& mapper) {
  const int shrink = mapper.options().shrink;
  const Image<Rgb>& colour = frame.left_colour;
  if (colour.empty() || !mapper.takes_rectified_images()) return grey_picture(mapped.left);
  Image<Rgb> small(mapped.left.width, mapped.left.height);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) small(x, y) = colour(x * shrink, y * shrink);
  }
  return small;
}

}  // namespace

FrameSample sample_of(const StereoFrame& frame, const RoverFrame& mapped,
                      const RoverMapper& mapper) {
  FrameSample sample;
  sample.name = frame.name;
  sample.left = frame.left_colour.empty() ? grey_picture(frame.left) : frame.left_colour;
  sample.right = frame.right;
  sample.disparity_px.resize(mapped.disparity.width, mapped.disparity.height);
  for (int y = 0; y < mapped.disparity.height; ++y) {
    for (int x = 0; x < mapped.disparity.width; ++x) {
      const Disparity d = mapped.disparity(x, y);
      sample.disparity_px(x, y) =
          d == kNoMatch ? std::numeric_limits<float>::quiet_NaN() : disparity_px(d);
    }
  }
  edge_image(mapped.left, mapper.options().stereo.edges, sample.edges);
  sample.depth = copy_of(mapped.depth);
  depth_cloud(mapped.depth, mapper.rig(), mapper.options().stereo.sad.reference,
              matched_colours(frame, mapped, mapper), sample.cloud);
  sample.T_level_points = mapped.T_level_points;
  sample.height = *mapped.height;
  sample.derivative = *mapped.derivative;
  return sample;
}

std::vector<MapFigure> map_figures(const MapRun& run, const PlannerOptions& options) {
  const Grid<float>& height = run.layers.find("height")->grid;
  const Grid<float>& derivative = run.layers.find("derivative")->grid;
  const Grid<float>& explored = run.layers.find("explored")->grid;
  const Grid<float>& cost = run.layers.find("cost")->grid;
  std::vector<MapFigure> figures;
  if (height.values.empty() || cost.values.empty()) return figures;
  const ColourScale heights = height_scale(height, "height");
  figures.push_back({"height", "Terrain",
                     "Last measured heights; the line is the way of the camera. For display only: "
                     "frames that disagree a little lie side by side.",
                     draw_relief(height, heights), heights, values_under(height)});
  draw_trajectory(figures.back().picture, run.trajectory);
  figures.push_back({"derivative", "Derivative",
                     "Low-passed over all frames: obstacles stand out, errors of single frames do "
                     "not.",
                     draw_map(derivative, derivative_scale()), derivative_scale(),
                     values_under(derivative)});
  const ColourScale mask{.label = "explored", .palette = Palette::kGrey, .low = 0.0F, .high = 1.0F};
  figures.push_back({"explored", "Explored", "White where a derivative has been measured.",
                     draw_map(explored, mask), mask, values_under(explored)});
  const ColourScale costs = cost_scale(options);
  figures.push_back({"cost", "Cost and plan",
                     "Mean cost over the robot's square, and the waypoints to the goal.",
                     draw_map(cost, costs), costs, values_under(cost)});
  draw_plan(figures.back().picture, run.plan, run.start, run.goal);
  for (MapFigure& figure : figures) draw_scale_bar(figure.picture);
  return figures;
}

Report map_report(const std::string& command_line, const StereoSource& source,
                  const RoverMapper& mapper, const PlannerOptions& options, const MapRun& run) {
  const double cell = mapper.ground().resolution_m();
  const double frames = static_cast<double>(run.trajectory.size());
  Report report("Ground map",
                fmt::format("{}, {}", source.kind(), frames_text(run.trajectory.size())));
  report.set_command(command_line);
  report.add_key_numbers(
      {{"explored", number_text(run.explored_cells * cell * cell), "m2"},
       {"per frame", fmt::format("{:.1f}", run.frame_ms / frames), "ms"},
       {"path",
        run.plan.status == PlanStatus::kFound ? fmt::format("{:.1f}", run.plan.length_m) : "none",
        run.plan.status == PlanStatus::kFound ? "m" : ""}});
  if (run.nothing) report.add_note(run.nothing->message(), NoteKind::kWarning);
  constexpr std::size_t kShown = 20;
  for (std::size_t i = 0; i < std::min(kShown, run.problems.size()); ++i) {
    report.add_note(run.problems[i].message(), NoteKind::kWarning);
  }
  if (run.problems.size() > kShown) {
    report.add_note(fmt::format("{} more frames could not be used.", run.problems.size() - kShown),
                    NoteKind::kWarning);
  }
  report.add_quantities("What it stands on", quantities(source, mapper));
  add_frame_section(mapper, run.sample, report);
  const bool first_is_ahead =
      source.kind().starts_with("KITTI") || !source.has_poses() || is_placed_by_odometry(source);
  report.add_section("The ground, all frames together",
                     first_is_ahead ? "x points ahead of the first pose, y to its left, z up."
                                    : "x, y and z as in the poses, z up.");
  for (const MapFigure& figure : map_figures(run, options)) {
    Figure shown{.title = figure.title,
                 .caption = figure.caption,
                 .scale = figure.scale,
                 .values = figure.values,
                 .wide = figure.picture.image.width > 2 * figure.picture.image.height};
    if (figure.name == "cost") {
      shown.marks = {{kPathColour, "plan"}, {kStartColour, "start"}, {kGoalColour, "goal"}};
    }
    report.add_figure(figure.picture.image, shown);
  }
  report.add_section(
      "The plan", run.ends_chosen ? "From the first pose to a goal ahead of the last one, beyond "
                                    "the map (none was given)."
                                  : "");
  report.add_note(summary_of(run.plan),
                  run.plan.status == PlanStatus::kFound ? NoteKind::kInfo : NoteKind::kWarning);
  Table waypoints{"Waypoints", {"", "x (m)", "y (m)"}, {}};
  for (std::size_t i = 0; i < run.plan.waypoints.size(); ++i) {
    waypoints.rows.push_back({std::to_string(i), fmt::format("{:.2f}", run.plan.waypoints[i].x()),
                              fmt::format("{:.2f}", run.plan.waypoints[i].y())});
  }
  if (!waypoints.rows.empty()) report.add_table(waypoints);
  report.add_timings(run.timings);
  return report;
}

}  // namespace tread
