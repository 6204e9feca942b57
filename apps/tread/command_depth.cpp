// tread depth: a pair of images to disparity, depth and a point cloud.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>

#include "command.hpp"
#include "depth_run.hpp"
#include "tread/core/shrink.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/stereo/disparity_range.hpp"
#include "tread/stereo/uncertainty.hpp"

namespace tread {
namespace {

constexpr const char* kNumDisparities = "stereo.sad.num_disparities";

OptionSet describe(DepthSettings& settings) {
  OptionSet set;
  set.add_group("images", describe(settings.images));
  set.add_group("stereo", describe(settings.stereo));
  set.add_group("depth", describe(settings.depth));
  set.add("shrink", settings.shrink, "match images shrunk by this factor", 1, 16);
  set.add_automatic("auto_num_disparities", settings.auto_num_disparities,
                    "widen the search to what the pair needs; off where num_disparities is given "
                    "alone",
                    kNumDisparities);
  return set;
}

Status read_images(const DepthArguments& arguments, DepthRun& run) {
  const auto read = [&](const std::string& path, Image<std::uint8_t>& grey,
                        Image<Rgb>& colour) -> Status {
    auto both = read_grey_and_colour(path, run.settings.images);
    if (!both) return forward(both);
    grey = std::move(both->grey);
    colour = both->colour.empty() ? grey_picture(grey) : std::move(both->colour);
    return {};
  };
  if (Status ok = read(arguments.left, run.left, run.colour_left); !ok) return ok;
  if (Status ok = read(arguments.right, run.right, run.colour_right); !ok) return ok;
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
  if (rig.mount) run.T_level_points = rig.mount->T_body_left;
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

OptionSet profile_settings(const DepthArguments& arguments, DepthSettings& settings) {
  if (arguments.profile == "paper-q")
    settings = {paper_q_stereo_options(), DepthOptions{}, 1, false, {}};
  return describe(settings);
}

Status choose_settings(const DepthArguments& arguments, OptionSet& options) {
  std::vector<Shorthand> shorthands;
  if (arguments.num_disparities) {
    shorthands.push_back(
        {"--num-disparities", kNumDisparities, std::to_string(*arguments.num_disparities)});
  }
  return apply_settings(arguments.common, options, std::move(shorthands));
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

Status choose_range(const Context& context, DepthRun& run) {
  if (!run.settings.auto_num_disparities) return {};
  const auto needed = estimate_num_disparities(run.left, run.right, run.settings.stereo, context);
  if (!needed) return forward(needed);
  int& range = run.settings.stereo.sad.num_disparities;
  range =
      std::min(run.left.width - run.settings.stereo.sad.min_disparity_px, std::max(range, *needed));
  return {};
}

void rate_matches(ImageView<const std::uint8_t> residual, DepthRun& run) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  run.confidence = run.sigma_px = Image<float>(residual.width, residual.height, kUnknown);
  for (int y = 0; y < residual.height; ++y) {
    for (int x = 0; x < residual.width; ++x) {
      if (run.disparity(x, y) == kNoMatch) continue;
      const MatchUncertainty sure = match_uncertainty(run.settings.stereo.method, residual(x, y));
      run.confidence(x, y) = sure.confidence;
      run.sigma_px(x, y) = sure.sigma_px;
    }
  }
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
  if (run.settings.stereo.rate) rate_matches(matcher.residual(), run);
  if (!run.rig) return {};
  const Reference reference = run.settings.stereo.sad.reference;
  depth_image(run.disparity, *run.rig, run.settings.depth, run.depth, context);
  depth_cloud(run.depth, *run.rig, reference,
              reference == Reference::kLeft ? run.colour_left : run.colour_right, run.cloud,
              context);
  return {};
}

int run_depth(const DepthArguments& arguments) {
  DepthRun run;
  const Context context{arguments.common.threads, &run.timings};
  Output output(arguments.common.json);
  output.values["command"] = "depth";
  OptionSet options = profile_settings(arguments, run.settings);
  if (Status s = choose_settings(arguments, options); !s) return print_error(s.error());
  if (arguments.common.print_config) {
    print_config("depth", options);
    return 0;
  }
  if (Status s = read_images(arguments, run); !s) return print_error(s.error());
  if (run.settings.shrink > 1) shrink_images(run);
  if (Status s = rectify(arguments, context, run); !s) return print_error(s.error());
  if (Status s = prepare_output(arguments.common); !s) return print_error(s.error());
  if (Status s = choose_range(context, run); !s) return print_error(s.error());
  run.timings.clear();
  if (Status s = compute(context, run); !s) return print_error(s.error());
  run.problem = find_problem(arguments, run);
  summarise(run, output);
  if (arguments.common.output) {
    if (Status s = write_results(arguments, run, output); !s) return print_error(s.error());
  }
  if (run.problem) output.values["problems"].push_back(run.problem->message());
  output.print_json();
  return run.problem ? print_error(*run.problem) : 0;
}

}  // namespace

void add_depth_command(CLI::App& app, int& status, const std::string& command_line) {
  CLI::App* command = app.add_subcommand("depth", "Disparity, depth and point cloud of a pair");
  auto arguments = std::make_shared<DepthArguments>();
  arguments->command_line = command_line;
  command->add_option("LEFT", arguments->left, "Left image: PNG, JPEG, PGM or PPM")
      ->type_name("")
      ->required();
  command->add_option("RIGHT", arguments->right, "Right image of the same moment and size")
      ->type_name("")
      ->required();
  command
      ->add_option("--rig", arguments->rig,
                   "Calibration of the two cameras: a file of ours, OpenCV, KITTI, EuRoC, Kalibr "
                   "or ROS, or a known name (bumblebee2-640, bumblebee2-1024). Without it: "
                   "disparity only, and the images must be rectified")
      ->type_name("RIG");
  add_method_option(*command, arguments->common);
  command
      ->add_option("--num-disparities", arguments->num_disparities,
                   "How many disparities to search, px; found from the images if not given")
      ->type_name("N")
      ->check(CLI::Range(1, kMaxDisparity).description(""));
  command
      ->add_option("--profile", arguments->profile,
                   "Where the options start from: general, or paper-q (the settings of paper Q: "
                   "right reference, 10 to 74 px, 0.8 to 4 m)")
      ->type_name("NAME")
      ->check(CLI::IsMember({"general", "paper-q"}).description(""))
      ->capture_default_str();
  add_common_options(*command, arguments->common);
  add_setting_options(*command, arguments->common);
  command->footer(
      "Examples:\n"
      "  tread depth left.png right.png --rig rig.yaml -o out\n"
      "  tread depth left.png right.png --rig rig.yaml --set depth.max_depth_m=20 -o out\n"
      "  tread depth --print-config > options.yaml\n"
      "Writes disparity.pfm (px, inf = no match), disparity.png, report.html; with a rig also\n"
      "depth.tif (m, NaN = unknown) and cloud.ply; with --set stereo.rate=true confidence.tif\n"
      "(0 to 1) and sigma.tif (px). Files of an earlier run there are replaced.");
  command->callback([arguments, &status] { status = run_depth(*arguments); });
}

}  // namespace tread
