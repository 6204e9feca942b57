#include "slam_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cloud_picture.hpp"
#include "drawing.hpp"

namespace tread {
namespace {

constexpr std::array kStatuses{TrackStatus::kFirst, TrackStatus::kTracked, TrackStatus::kHeld,
                               TrackStatus::kUnobservable, TrackStatus::kLost};

Rgb colour_of_status(TrackStatus status) {
  switch (status) {
    case TrackStatus::kFirst:
    case TrackStatus::kTracked:
      return {46, 160, 90};
    case TrackStatus::kHeld:
      return {60, 130, 220};
    case TrackStatus::kUnobservable:
      return {240, 170, 40};
    case TrackStatus::kLost:
      return {220, 60, 60};
  }
  return {};
}

// Largest standard deviation of the translation.
double sigma_m(const SlamState& state) {
  return std::sqrt(std::max(0.0, state.covariance.diagonal().head<3>().maxCoeff()));
}
double matched_share(const SlamState& state) {
  const Alignment& a = state.alignment;
  return a.measured > 0 ? static_cast<double>(a.matched) / static_cast<double>(a.measured) : 0.0;
}

// Time goes to the right; above a band of what each frame said of itself, a curve of how sure its
// motion is, on a logarithmic scale from 0.1 mm to 1 m.
Image<Rgb> draw_timeline(const SlamRun& run) {
  constexpr int kWidth = 1000, kBand = 26, kCurve = 150;
  Image<Rgb> picture(kWidth, kCurve + kBand, Rgb{246, 247, 249});
  const auto count = static_cast<double>(std::max<std::size_t>(run.states.size(), 1));
  const auto height_of = [](double metres) {
    const double share = (std::log10(std::clamp(metres, 1e-4, 1.0)) + 4.0) / 4.0;
    return (1.0 - share) * (kCurve - 12) + 6.0;
  };
  for (const double metres : {1e-3, 1e-2, 1e-1}) {
    const std::array<Eigen::Vector2d, 2> line{Eigen::Vector2d(0.0, height_of(metres)),
                                              Eigen::Vector2d(kWidth, height_of(metres))};
    draw_polyline(picture, line, 1.0, {205, 209, 216});
    draw_text(picture, 6, static_cast<int>(height_of(metres)) - 4, number_text(metres, "m"), 11,
              {110, 116, 126});
  }
  std::vector<Eigen::Vector2d> curve;
  for (std::size_t i = 0; i < run.states.size(); ++i) {
    const double x0 = kWidth * static_cast<double>(i) / count,
                 x1 = kWidth * static_cast<double>(i + 1) / count;
    const int first = static_cast<int>(x0), last = std::max(first + 1, static_cast<int>(x1));
    fill_rectangle(picture, first, kCurve, last - first, kBand,
                   colour_of_status(run.states[i].status));
    if (run.states[i].status == TrackStatus::kFirst) continue;
    curve.emplace_back(0.5 * (x0 + x1), height_of(sigma_m(run.states[i])));
  }
  draw_polyline(picture, curve, 2.0, {40, 60, 110});
  return picture;
}

// Runs of frames that were not tracked, the longest first.
Table weak_intervals(const SlamRun& run) {
  struct Interval {
    std::size_t first, last;
    TrackStatus status;
  };
  std::vector<Interval> weak;
  for (std::size_t i = 0; i < run.states.size(); ++i) {
    const TrackStatus status = run.states[i].status;
    if (status == TrackStatus::kFirst || status == TrackStatus::kTracked) continue;
    if (!weak.empty() && weak.back().last + 1 == i && weak.back().status == status) {
      weak.back().last = i;
    } else {
      weak.push_back({i, i, status});
    }
  }
  std::stable_sort(weak.begin(), weak.end(), [](const Interval& a, const Interval& b) {
    return a.last - a.first > b.last - b.first;
  });
  Table table{"Where tracking was weak", {"from", "to", "frames", "it said"}, {}};
  for (std::size_t i = 0; i < std::min<std::size_t>(weak.size(), 12); ++i) {
    const auto time = [&](std::size_t frame) {
      return fmt::format("{:.2f} s", 1e-9 * static_cast<double>(run.states[frame].stamp_ns -
                                                                run.states[0].stamp_ns));
    };
    table.rows.push_back({time(weak[i].first), time(weak[i].last),
                          std::to_string(weak[i].last - weak[i].first + 1),
                          name_of(weak[i].status)});
  }
  return table;
}

}  // namespace

std::size_t count_of(const SlamRun& run, TrackStatus status) {
  return static_cast<std::size_t>(
      std::count_if(run.states.begin(), run.states.end(),
                    [status](const SlamState& s) { return s.status == status; }));
}

std::string tracking_csv(const SlamRun& run) {
  const bool has_odometry = run.odometry.size() == run.states.size();
  std::string text =
      "time_s,status,matched,depth_rms_sigma,grey_rms,unknown_directions,worst_m,"
      "sigma_x_m,sigma_y_m,sigma_z_m,sigma_roll_rad,sigma_pitch_rad,sigma_yaw_rad,keyframe";
  text += has_odometry ? ",odometry,points,inliers,rms_px,inertial\n" : "\n";
  for (std::size_t i = 0; i < run.states.size(); ++i) {
    const SlamState& s = run.states[i];
    const Vector6d sigma = s.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    text += fmt::format(
        "{:.9f},{},{:.4f},{:.3f},{:.2f},{},{:.6f},{:.6g},{:.6g},{:.6g},{:.6g},"
        "{:.6g},{:.6g},{}",
        1e-9 * static_cast<double>(s.stamp_ns), name_of(s.status), matched_share(s),
        s.alignment.depth_rms, s.alignment.grey_rms, s.alignment.observability.unknown.cols(),
        s.alignment.observability.worst_m, sigma(0), sigma(1), sigma(2), sigma(3), sigma(4),
        sigma(5), s.keyframe ? 1 : 0);
    if (has_odometry) {
      const OdometryState& o = run.odometry[i];
      text += fmt::format(",{},{},{},{:.3f},{}", name_of(o.status), o.followed, o.inliers, o.rms_px,
                          o.inertial ? 1 : 0);
    }
    text += '\n';
  }
  return text;
}

MapPicture draw_way(const SlamRun& run, ColourScale& scale) {
  Eigen::Vector2f low = Eigen::Vector2f::Constant(std::numeric_limits<float>::max());
  Eigen::Vector2f high = -low;
  const auto take = [&](const Eigen::Vector2f& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  for (const Eigen::Vector3f& p : run.mesh.vertices) take(p.head<2>());
  for (const StampedPose& p : run.trajectory) take(p.pose.translation().head<2>().cast<float>());
  if (!(low.x() <= high.x())) return {};
  const Eigen::Vector2f extent = (high - low).cwiseMax(0.2F);
  const double cell = std::max(0.005, static_cast<double>(extent.maxCoeff()) / 400.0);
  GridGeometry geometry;
  geometry.resolution_m = cell;
  geometry.origin = low.cast<double>() - Eigen::Vector2d::Constant(2.0 * cell);
  geometry.columns = static_cast<int>(extent.x() / cell) + 5;
  geometry.rows = static_cast<int>(extent.y() / cell) + 5;
  Grid<float> top(geometry, std::numeric_limits<float>::quiet_NaN());
  for (const Eigen::Vector3f& p : run.mesh.vertices) {
    const Eigen::Vector2d at = (p.head<2>().cast<double>() - geometry.origin) / cell;
    float& z = top[Cell{static_cast<int>(at.x()), static_cast<int>(at.y())}];
    if (!(z >= p.z())) z = p.z();
  }
  const ValueRange range = value_range(top, 0.01);
  scale = {.label = "highest surface",
           .unit = "m",
           .palette = Palette::kHeight,
           .low = range.low,
           .high = range.high,
           .unknown_label = "nothing seen"};
  MapPicture picture = draw_map(top, scale);
  draw_trajectory(picture, run.trajectory);
  draw_scale_bar(picture);
  return picture;
}

Report slam_report(const std::string& command_line, const SlamOptions& options,
                   const SlamRun& run) {
  Report report("Camera path and surface", fmt::format("{}: {} frames", run.kind, run.frames));
  report.set_command(command_line);
  const auto frames = static_cast<double>(std::max<std::size_t>(run.states.size(), 1));
  const std::size_t placed = count_of(run, TrackStatus::kFirst) +
                             count_of(run, TrackStatus::kTracked) +
                             count_of(run, TrackStatus::kHeld);
  std::vector<KeyNumber> numbers = {
      {"placed", fmt::format("{} of {}", placed, run.frames), "frames"},
      {"path", fmt::format("{:.2f}", run.path_m), "m"},
      {"tracking and mapping", fmt::format("{:.1f}", run.track_ms / frames), "ms a frame"},
      {"surface", fmt::format("{:.0f}", 1e-3 * static_cast<double>(run.mesh.triangles.size())),
       "thousand triangles"}};
  if (run.absolute) {
    numbers.push_back(
        {"error to the reference", fmt::format("{:.1f}", 1e3 * run.absolute->rmse_m), "mm rms"});
  }
  report.add_key_numbers(numbers);
  for (const Error& problem : run.problems) report.add_note(problem.message(), NoteKind::kWarning);

  report.add_section("Path and surface",
                     "From above. x is where the first camera looked, z is up if it was level.");
  ColourScale scale;
  const MapPicture way = draw_way(run, scale);
  if (!way.image.empty()) {
    report.add_figure(way.image, {.title = "The way from above",
                                  .caption = "Over the highest surface in each cell.",
                                  .scale = scale,
                                  .marks = {{kTrajectoryColour, "camera"}}});
  }
  PointCloud vertices{run.mesh.vertices, run.mesh.colours};
  const Image<Rgb> surface = draw_cloud(vertices, Isometry3d::Identity(), 900, 640);
  if (!surface.empty()) {
    report.add_figure(surface, {.title = "Surface",
                                .caption = fmt::format("The vertices of the mesh, voxels of {}.",
                                                       number_text(options.volume.voxel_m, "m"))});
  }
  report.add_section(
      "How sure it was",
      "Each frame's motion, its least certain direction: one standard deviation. A "
      "frame whose depth and image leave a direction open says so and is not fused.");
  std::vector<LegendMark> marks = {{{40, 60, 110}, "standard deviation"}};
  for (const TrackStatus status : kStatuses) {
    if (status == TrackStatus::kFirst || count_of(run, status) == 0) continue;
    marks.push_back(
        {colour_of_status(status), fmt::format("{}: {}", name_of(status), count_of(run, status))});
  }
  report.add_figure(draw_timeline(run), {.title = "Over time", .marks = marks, .wide = true});
  const Table weak = weak_intervals(run);
  if (weak.rows.empty()) {
    report.add_note("No frame was lost or left a direction open.");
  } else {
    report.add_table(weak);
  }
  if (run.absolute) {
    Table errors{
        "Against the reference poses", {"", "rms", "median", "largest", "rotation, rms"}, {}};
    const auto row = [&](const std::string& name, const TrajectoryError& e) {
      errors.rows.push_back({name, number_text(e.rmse_m, "m"), number_text(e.median_m, "m"),
                             number_text(e.largest_m, "m")});
    };
    row("absolute, moved as a whole to fit", *run.absolute);
    if (run.relative) row("over one second", *run.relative);
    report.add_table(errors);
  }
  if (!run.sample.depth.empty()) {
    report.add_section("One frame", fmt::format("Frame {}.", run.sample.name));
    if (!run.sample.grey.empty()) {
      report.add_figure(grey_picture(run.sample.grey), {.title = "Image"});
    }
    const ValueRange z = value_range(run.sample.depth, 0.005);
    const ColourScale depth{.label = "depth",
                            .unit = "m",
                            .palette = Palette::kDisparity,
                            .reversed = true,
                            .low = z.low,
                            .high = z.high};
    report.add_figure(colour_map(run.sample.depth, depth),
                      {.title = "Depth", .scale = depth, .values = values_under(run.sample.depth)});
  }
  report.add_section("Times and memory");
  report.add_key_numbers(
      {{"processor time", fmt::format("{:.1f}", run.cpu_ms / frames), "ms a frame, with reading"},
       {"voxels", fmt::format("{:.0f}", static_cast<double>(run.volume_bytes) / 1048576.0), "MiB"},
       {"largest memory", fmt::format("{:.0f}", run.peak_memory_mb), "MiB"}});
  report.add_timings(run.timings);
  return report;
}

}  // namespace tread
