#include "simulate_report.hpp"

#include <fmt/format.h>

#include "drawing.hpp"

namespace tread {
namespace {

constexpr Rgb kRouteColour{255, 221, 64};

std::vector<Eigen::Vector2d> in_picture(const PictureFromAbove& above,
                                        const std::vector<Eigen::Vector2d>& places) {
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector2d& p : places) pixels.push_back(above.pixel_of(p));
  return pixels;
}

}  // namespace

Image<Rgb> draw_course(const SimulateRun& run) {
  Image<Rgb> picture = run.above.image;
  draw_polyline(picture, in_picture(run.above, run.route), 2.0, kRouteColour);
  std::vector<Eigen::Vector2d> way;
  for (const StampedPose& pose : run.path) way.emplace_back(pose.pose.translation().head<2>());
  draw_polyline(picture, in_picture(run.above, way), 3.5, kPathColour);
  return picture;
}

Report simulate_report(const std::string& command_line, const SimulateRun& run) {
  Report report("Simulated course", fmt::format("{}, {}", run.course, run.robot));
  report.set_command(command_line);
  report.add_key_numbers(
      {{"simulated", fmt::format("{:.1f}", run.duration_s), "s"},
       {"way", fmt::format("{:.2f}", run.way_m), "m"},
       {"times real time", fmt::format("{:.2g}", run.duration_s / std::max(run.wall_s, 1e-9)), ""},
       {"seeds", fmt::format("{}, {}", run.world_seed, run.sensor_seed), "world, sensors"}});
  report.add_note(run.end);
  for (const Error& problem : run.problems) report.add_note(problem.message(), NoteKind::kWarning);
  for (const std::string& fault : run.faults) report.add_note("Fault: " + fault);
  report.add_section("The course", "x to the right, y upwards, from above.");
  if (run.above.image.width > 0) {
    report.add_figure(draw_course(run), {.title = "From above",
                                         .marks = {{kRouteColour, "route"}, {kPathColour, "way"}},
                                         .wide = true});
  }
  if (run.eye.width > 0) {
    report.add_figure(run.eye, {.title = "From the robot's eye",
                                .caption = "Left camera of the first head at the start, in colour "
                                           "and without the sensor's noise."});
  }
  if (!run.height.values.empty()) {
    const ValueRange range = value_range(run.height, 0.002);
    const ColourScale scale{.label = "height",
                            .unit = "m",
                            .low = range.low,
                            .high = range.high,
                            .unknown_label = "no ground"};
    report.add_figure(draw_relief(run.height, scale).image,
                      {.title = "True height", .scale = scale, .values = values_under(run.height)});
  }
  if (!run.traversable.values.empty()) {
    const ColourScale scale{.label = "the robot's middle may be there",
                            .palette = Palette::kCost,
                            .reversed = true,
                            .unknown_label = "no ground"};
    report.add_figure(draw_map(run.traversable, scale).image,
                      {.title = "Truly traversable", .scale = scale});
  }
  if (run.left.width > 0) {
    report.add_section("What the cameras saw", "A pair from the middle of the run.");
    report.add_figure(
        side_by_side(grey_picture(run.left.view()).view(), grey_picture(run.right.view()).view()),
        {.title = "Left and right image", .wide = true});
    const ValueRange range = value_range(run.depth.view(), 0.02);
    const ColourScale scale{.label = "true depth",
                            .unit = "m",
                            .reversed = true,
                            .low = range.low,
                            .high = range.high,
                            .unknown_label = "sky"};
    report.add_figure(
        colour_map(run.depth.view(), scale),
        {.title = "True depth", .scale = scale, .values = values_under(run.depth.view())});
  }
  Table table{"Samples", {"sensor", "samples", "a second"}, {}};
  for (const auto& [sensor, count] : run.samples) {
    table.rows.push_back(
        {sensor, std::to_string(count),
         fmt::format("{:.1f}", static_cast<double>(count) / std::max(run.duration_s, 1e-9))});
  }
  report.add_section("Sensors");
  report.add_table(table);
  report.add_timings(run.timings);
  return report;
}

}  // namespace tread
