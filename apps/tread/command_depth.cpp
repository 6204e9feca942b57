// tread depth: a pair of images to disparity, depth and a point cloud.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "command.hpp"
#include "report.hpp"
#include "tread/core/shrink.hpp"
#include "tread/geometry/rectification.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/mesh_file.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/stereo/depth.hpp"
#include "tread/stereo/disparity_range.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

struct DepthSettings {
  StereoOptions stereo;
  DepthOptions depth{0.0, 1e4};
  int shrink = 1;
};

OptionSet describe(DepthSettings& settings) {
  OptionSet set;
  set.add_group("stereo", describe(settings.stereo));
  set.add_group("depth", describe(settings.depth));
  set.add("shrink", settings.shrink, "match images shrunk by this factor", 1, 16);
  return set;
}

struct DepthArguments {
  std::string left, right, rig, profile = "general", method = "sad", command_line;
  int num_disparities = 0;
  CommonOptions common;
};

struct DepthRun {
  ImageSize full_size;  // before shrinking
  Image<Rgb> colour_left, colour_right;
  Image<std::uint8_t> left, right;
  std::optional<RectifiedRig> rig;  // empty without --rig: disparity only
  DepthSettings settings;
  Image<Disparity> disparity;
  Image<float> disparity_px;  // NaN where there is no match
  Image<float> depth;
  PointCloud cloud;
  Timings timings;
};

Status read_images(const DepthArguments& arguments, DepthRun& run) {
  auto left = read_colour(arguments.left);
  if (!left) return forward(left);
  auto right = read_colour(arguments.right);
  if (!right) return forward(right);
  auto grey_left = read_grey(arguments.left);
  if (!grey_left) return forward(grey_left);
  auto grey_right = read_grey(arguments.right);
  if (!grey_right) return forward(grey_right);
  run.colour_left = std::move(*left);
  run.colour_right = std::move(*right);
  run.left = std::move(*grey_left);
  run.right = std::move(*grey_right);
  run.full_size = {run.left.width, run.left.height};
  if (same_size(run.left, run.right)) return {};
  return fail(ErrorCode::kBadFormat,
              fmt::format("it is {}x{}, the left image {}x{}", run.right.width, run.right.height,
                          run.left.width, run.left.height),
              arguments.right, "Give the two images of one pair");
}

Status rectify(const DepthArguments& arguments, const Context& context, DepthRun& run) {
  if (arguments.rig.empty()) return {};
  const auto full_rig = read_rig(arguments.rig, run.full_size);
  if (!full_rig) return forward(full_rig);
  if (full_rig->size != run.full_size) {
    return fail(ErrorCode::kBadFormat,
                fmt::format("it is for images of {}x{}, these are {}x{}", full_rig->size.width,
                            full_rig->size.height, run.full_size.width, run.full_size.height),
                arguments.rig, "Give the rig of these images");
  }
  const StereoRig rig = shrunk(*full_rig, run.settings.shrink);
  if (rig.rectified) {
    const auto rectified = rectified_rig(rig);
    if (!rectified) return forward(rectified);
    run.rig = *rectified;
    return {};
  }
  const auto rectification = make_rectification(rig);
  if (!rectification) return forward(rectification);
  run.rig = rectification->rig;
  for (auto [image, table] :
       {std::pair{&run.left, &rectification->left}, std::pair{&run.right, &rectification->right}}) {
    Image<std::uint8_t> rectified(image->width, image->height);
    remap(*image, *table, rectified, context);
    *image = std::move(rectified);
  }
  for (auto [image, table] : {std::pair{&run.colour_left, &rectification->left},
                              std::pair{&run.colour_right, &rectification->right}}) {
    Image<Rgb> rectified(image->width, image->height);
    remap(*image, *table, rectified, context);
    *image = std::move(rectified);
  }
  return {};
}

Status choose_settings(const DepthArguments& arguments, DepthRun& run) {
  if (arguments.profile == "paper-q") run.settings = {paper_q_stereo_options(), DepthOptions{}, 1};
  return apply_settings(arguments.common, describe(run.settings));
}

void shrink_images(DepthRun& run) {
  for (Image<std::uint8_t>* image : {&run.left, &run.right}) {
    Image<std::uint8_t> small;
    shrink(*image, run.settings.shrink, small);
    *image = std::move(small);
  }
  for (Image<Rgb>* image : {&run.colour_left, &run.colour_right}) {
    Image<Rgb> small;
    shrink(*image, run.settings.shrink, small);
    *image = std::move(small);
  }
}

Status choose_range(const DepthArguments& arguments, const Context& context, DepthRun& run) {
  if (arguments.num_disparities > 0) {
    run.settings.stereo.sad.num_disparities = arguments.num_disparities;
  } else if (arguments.profile == "general") {
    const auto needed = estimate_num_disparities(run.left, run.right, run.settings.stereo, context);
    if (!needed) return forward(needed);
    run.settings.stereo.sad.num_disparities = *needed;
  }
  return {};
}

Status compute(const Context& context, DepthRun& run) {
  StereoMatcher matcher;
  const auto disparity = matcher.match(run.left, run.right, run.settings.stereo, context);
  if (!disparity) return forward(disparity);
  run.disparity.resize(disparity->width, disparity->height);
  run.disparity_px.resize(disparity->width, disparity->height);
  for (int y = 0; y < disparity->height; ++y) {
    for (int x = 0; x < disparity->width; ++x) {
      const Disparity d = (*disparity)(x, y);
      run.disparity(x, y) = d;
      run.disparity_px(x, y) =
          d == kNoMatch ? std::numeric_limits<float>::quiet_NaN() : tread::disparity_px(d);
    }
  }
  if (!run.rig) return {};
  const Reference reference = run.settings.stereo.sad.reference;
  depth_image(run.disparity, *run.rig, run.settings.depth, run.depth, context);
  depth_cloud(run.depth, *run.rig, reference,
              reference == Reference::kLeft ? run.colour_left : run.colour_right, run.cloud,
              context);
  return {};
}

ColourScale disparity_scale(const DepthRun& run) {
  const ValueRange range = value_range(run.disparity_px, 0.002);
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
  if (run.rig) {
    report.add_figure(
        colour_map(run.depth, depth_scale(run)),
        {.title = "Depth", .scale = depth_scale(run), .values = values_under(run.depth)});
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

Status write_results(const DepthArguments& arguments, const DepthRun& run, Output& output) {
  const fs::path folder = arguments.common.output;
  if (Status made = make_output_folder(folder); !made) return made;
  Image<float> pfm = run.disparity_px;  // PFM's word for unknown is infinity
  for (int y = 0; y < pfm.height; ++y) {
    std::replace_if(
        pfm.row(y), pfm.row(y) + pfm.width, [](float v) { return std::isnan(v); },
        std::numeric_limits<float>::infinity());
  }
  const auto keep = [&](const Status& status, const char* name) {
    if (status) output.wrote(folder / name);
    return status;
  };
  if (Status s = keep(write_pfm(folder / "disparity.pfm", pfm), "disparity.pfm"); !s) return s;
  const ColourScale scale = disparity_scale(run);
  if (Status s = keep(write_png(folder / "disparity.png",
                                with_colour_bar(colour_map(run.disparity_px, scale), scale)),
                      "disparity.png");
      !s) {
    return s;
  }
  if (run.rig) {
    if (Status s = keep(write_tiff(folder / "depth.tif", run.depth), "depth.tif"); !s) return s;
    if (Status s = keep(write_ply(folder / "cloud.ply", run.cloud), "cloud.ply"); !s) return s;
  }
  return keep(make_report(arguments, run).write(folder / "report.html"), "report.html");
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
  const ValueRange d = value_range(run.disparity_px, 0.01);
  output.values["disparity_px"] = {{"low", d.low}, {"high", d.high}};
  if (run.rig) {
    const ValueRange z = value_range(run.depth, 0.01);
    output.values["depth_m"] = {{"near", z.low}, {"far", z.high}};
    output.values["points"] = run.cloud.points.size();
    output.line(
        fmt::format("depth {:.2f} to {:.2f} m, {} points; a quarter pixel is {} at {:.2f} m", z.low,
                    z.high, run.cloud.points.size(),
                    number_text(1000.0 * depth_sigma_m(*run.rig, z.high), "mm"), z.high));
  } else {
    output.line("no rig given (--rig): disparity only, the images taken as rectified");
  }
  output.values["timings"] = json_of(run.timings);
}

int run_depth(const DepthArguments& arguments) {
  DepthRun run;
  const Context context{arguments.common.threads, &run.timings};
  Output output(arguments.common.json);
  output.values["command"] = "depth";
  if (Status s = choose_settings(arguments, run); !s) return print_error(s.error());
  if (Status s = read_images(arguments, run); !s) return print_error(s.error());
  if (run.settings.shrink > 1) shrink_images(run);
  if (Status s = rectify(arguments, context, run); !s) return print_error(s.error());
  if (Status s = choose_range(arguments, context, run); !s) return print_error(s.error());
  run.timings.clear();
  if (Status s = compute(context, run); !s) return print_error(s.error());
  summarise(run, output);
  if (!arguments.common.output.empty()) {
    if (Status s = write_results(arguments, run, output); !s) return print_error(s.error());
    output.line("wrote " + arguments.common.output + ": disparity.pfm, disparity.png" +
                (run.rig ? ", depth.tif, cloud.ply" : "") + ", report.html");
  }
  output.print_json();
  return 0;
}

}  // namespace

void add_depth_command(CLI::App& app, int& status, const std::string& command_line) {
  CLI::App* command = app.add_subcommand("depth", "Disparity, depth and point cloud of a pair");
  auto arguments = std::make_shared<DepthArguments>();
  arguments->command_line = command_line;
  command->add_option("LEFT", arguments->left, "Left image (PNG, JPEG, PGM)")->required();
  command->add_option("RIGHT", arguments->right, "Right image")->required();
  command
      ->add_option("--rig", arguments->rig,
                   "Calibration: our YAML, OpenCV, KITTI, EuRoC, Kalibr, ROS, or a known name")
      ->type_name("RIG");
  command->add_option("--method", arguments->method, "Matcher")
      ->check(CLI::IsMember({"sad"}))
      ->capture_default_str();
  command
      ->add_option("--num-disparities", arguments->num_disparities,
                   "Disparities to search; found from the images if not given")
      ->check(CLI::Range(1, kMaxDisparity));
  command
      ->add_option("--profile", arguments->profile,
                   "general, or paper-q: right reference, 10 to 74 px, 0.8 to 4 m")
      ->check(CLI::IsMember({"general", "paper-q"}))
      ->capture_default_str();
  add_common_options(*command, arguments->common);
  add_setting_options(*command, arguments->common);
  command->footer(
      "Example:\n  tread depth left.png right.png --rig rig.yaml -o out\n"
      "Writes disparity.pfm (px, inf = no match), disparity.png, depth.tif (m, NaN =\n"
      "unknown), cloud.ply and report.html.");
  command->callback([arguments, &status] { status = run_depth(*arguments); });
}

}  // namespace tread
