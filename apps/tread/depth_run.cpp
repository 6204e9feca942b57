// Results of `tread depth`.
#include "depth_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cloud_picture.hpp"
#include "report.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/mesh_file.hpp"
#include "tread/io/raster_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

bool has_match(const DepthRun& run) {
  return disparity_density(run.disparity) > 0.0;
}
bool has_depth(const DepthRun& run) {
  return !run.cloud.points.empty();
}

bool same_picture(const DepthRun& run) {
  for (int y = 0; y < run.left.height; ++y) {
    if (!std::equal(run.left.row(y), run.left.row(y) + run.left.width, run.right.row(y))) {
      return false;
    }
  }
  return true;
}

ColourScale disparity_scale(const DepthRun& run) {
  ValueRange range = value_range(run.disparity_px, 0.002);
  if (!has_match(run)) {  // the range that was searched, for there is no other
    range.low = static_cast<float>(run.settings.stereo.sad.min_disparity_px);
    range.high = range.low + static_cast<float>(run.settings.stereo.sad.num_disparities);
  }
  return {.label = "disparity",
          .unit = "px",
          .palette = Palette::kDisparity,
          .low = range.low,
          .high = range.high,
          .unknown_label = "no match"};
}

ColourScale depth_scale(const DepthRun& run) {
  const ValueRange range = value_range(run.depth, 0.01);
  return {.label = "depth",
          .unit = "m",
          .palette = Palette::kDisparity,
          .reversed = true,
          .low = range.low,
          .high = range.high};
}

Report make_report(const DepthArguments& arguments, const DepthRun& run) {
  Report report("Depth", fmt::format("{} and {}", fs::path(arguments.left).filename().string(),
                                     fs::path(arguments.right).filename().string()));
  report.set_command(arguments.command_line);
  std::vector<KeyNumber> numbers = {
      {"image", fmt::format("{} x {}", run.left.width, run.left.height), "px"},
      {"matched", fmt::format("{:.1f}", 100.0 * disparity_density(run.disparity)), "%"},
      {"disparities searched", std::to_string(run.settings.stereo.sad.num_disparities), "px"}};
  if (run.rig) numbers.push_back({"points", std::to_string(run.cloud.points.size()), ""});
  report.add_key_numbers(numbers);
  if (run.problem) report.add_note(run.problem->message(), NoteKind::kWarning);
  report.add_section("The pair", run.rig ? "Rectified: a point is on the same row in both images."
                                         : "Taken as rectified: no rig was given.");
  report.add_figure(run.colour_left, {.title = "Left"});
  report.add_figure(run.colour_right, {.title = "Right"});
  report.add_section("Disparity and depth",
                     "Pixels without a match are unknown, not guessed. Point at a picture to read "
                     "its values.");
  report.add_figure(colour_map(run.disparity_px, disparity_scale(run)),
                    {.title = "Disparity",
                     .scale = disparity_scale(run),
                     .values = values_under(run.disparity_px)});
  if (!run.confidence.empty()) {
    const ColourScale sure{.label = "confidence",
                           .palette = Palette::kHeight,
                           .low = 0.5F,
                           .high = 1.0F,
                           .unknown_label = "no match"};
    report.add_figure(colour_map(run.confidence, sure),
                      {.title = "How sure each match is",
                       .caption = "The share of such matches that are within a pixel of the truth.",
                       .scale = sure,
                       .values = values_under(run.confidence)});
  }
  if (has_depth(run)) {
    report.add_figure(
        colour_map(run.depth, depth_scale(run)),
        {.title = "Depth", .scale = depth_scale(run), .values = values_under(run.depth)});
    const bool wide = run.depth.width > 1000;
    report.add_figure(
        draw_cloud(run.cloud, run.T_level_points, wide ? 1200 : 640, wide ? 560 : 480),
        {.title = "Point cloud",
         .caption = fmt::format("{} points, seen from behind the camera and above it.",
                                run.cloud.points.size())});
    Table table{"How finely depth is known", {"depth", "step of a quarter pixel"}, {}};
    const ValueRange range = value_range(run.depth, 0.01);
    for (int i = 0; i < 4; ++i) {
      const double z = range.low + (range.high - range.low) * static_cast<float>(i) / 3.0F;
      table.rows.push_back(
          {number_text(z, "m"), number_text(1000.0 * depth_sigma_m(*run.rig, z), "mm")});
    }
    report.add_table(table);
  }
  report.add_timings(run.timings);
  return report;
}

void summarise_depth(const DepthRun& run, Output& output) {
  if (!run.rig) {
    output.line("no rig given (--rig): disparity only, the images taken as rectified");
    return;
  }
  output.values["points"] = run.cloud.points.size();
  if (!has_depth(run)) return;
  const ValueRange z = value_range(run.depth, 0.01);
  output.values["depth_m"] = {{"near", z.low}, {"far", z.high}};
  output.line(fmt::format("depth {:.2f} to {:.2f} m, {} points; a quarter pixel is {} at {:.2f} m",
                          z.low, z.high, run.cloud.points.size(),
                          number_text(1000.0 * depth_sigma_m(*run.rig, z.high), "mm"), z.high));
}

}  // namespace

std::optional<Error> find_problem(const DepthArguments& arguments, const DepthRun& run) {
  const SadOptions& sad = run.settings.stereo.sad;
  if (!has_match(run) && same_picture(run)) {
    return Error{ErrorCode::kBadValue, "no pixel was matched: the two pictures are the same",
                 arguments.left + " and " + arguments.right,
                 "Give the left and the right image of a stereo camera"};
  }
  if (!has_match(run)) {
    return Error{
        ErrorCode::kBadValue,
        fmt::format("no pixel was matched, searching {} to {} px", sad.min_disparity_px,
                    sad.min_disparity_px + sad.num_disparities - 1),
        arguments.left + " and " + arguments.right,
        fmt::format("Check that they are the left and the right image of one moment, in this "
                    "order{}, and that they show texture; nearer things need more "
                    "--num-disparities",
                    run.rig ? "" : " and rectified (else give --rig)")};
  }
  if (!run.rig || has_depth(run)) return std::nullopt;
  return Error{ErrorCode::kBadValue,
               fmt::format("what was matched lies nowhere within {:g} to {:g} m",
                           run.settings.depth.min_depth_m, run.settings.depth.max_depth_m),
               "depth", "Set depth.min_depth_m and depth.max_depth_m, or check the rig"};
}

Status write_results(const DepthArguments& arguments, const DepthRun& run, Output& output) {
  constexpr std::array<const char*, 3> kAlways = {"disparity.pfm", "disparity.png", "report.html"};
  constexpr std::array<const char*, 4> kSometimes = {"depth.tif", "cloud.ply", "confidence.tif",
                                                     "sigma.tif"};
  FileSet set(*arguments.common.output);
  Image<float> pfm = run.disparity_px;  // PFM's word for unknown is infinity
  for (int y = 0; y < pfm.height; ++y) {
    std::replace_if(
        pfm.row(y), pfm.row(y) + pfm.width, [](float v) { return std::isnan(v); },
        std::numeric_limits<float>::infinity());
  }
  const ColourScale scale = disparity_scale(run);
  const Image<Rgb> picture = with_colour_bar(colour_map(run.disparity_px, scale), scale);
  const Report report = make_report(arguments, run);
  const auto add = [&](const char* name, const auto& write) { return add_file(set, name, write); };
  Status s = add("disparity.pfm", [&](const fs::path& path) { return write_pfm(path, pfm); });
  if (s) s = add("disparity.png", [&](const fs::path& path) { return write_png(path, picture); });
  if (s && !run.confidence.empty()) {
    s = add("confidence.tif", [&](const fs::path& p) { return write_tiff(p, run.confidence); });
    if (s) s = add("sigma.tif", [&](const fs::path& p) { return write_tiff(p, run.sigma_px); });
  }
  if (s && has_depth(run)) {
    s = add("depth.tif", [&](const fs::path& path) { return write_tiff(path, run.depth); });
    if (s) s = add("cloud.ply", [&](const fs::path& path) { return write_ply(path, run.cloud); });
  }
  if (s) s = add("report.html", [&](const fs::path& path) { return report.write(path); });
  if (!s) return s;
  remove_earlier(set, kAlways, kSometimes);
  return output.commit(set);
}

void summarise(const DepthRun& run, Output& output) {
  const double density = disparity_density(run.disparity);
  const int range = run.settings.stereo.sad.num_disparities;
  double total_ms = 0.0;
  for (const auto& [path, entry] : run.timings.entries()) total_ms += entry.total_ms;
  output.values["size_px"] = {run.left.width, run.left.height};
  output.values["num_disparities"] = range;
  output.values["density"] = density;
  output.line(fmt::format("{}x{} px, {} disparities: {:.1f} % matched in {:.0f} ms", run.left.width,
                          run.left.height, range, 100.0 * density, total_ms));
  if (has_match(run)) {
    const ValueRange d = value_range(run.disparity_px, 0.01);
    output.values["disparity_px"] = {{"low", d.low}, {"high", d.high}};
    constexpr double kFew = 0.1;
    if (density < kFew) {
      output.line(
          "few pixels matched: are the images in order (left, right), of one moment and "
          "rectified?");
    }
    summarise_depth(run, output);
  }
  output.values["timings"] = json_of(run.timings);
}

}  // namespace tread
