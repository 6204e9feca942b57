// tread depth: a pair of images to disparity, depth and a point cloud.
#include <fmt/format.h>

#include <algorithm>
#include <array>
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
  bool auto_num_disparities = true;
};

constexpr const char* kNumDisparities = "stereo.sad.num_disparities";

OptionSet describe(DepthSettings& settings) {
  OptionSet set;
  set.add_group("stereo", describe(settings.stereo));
  set.add_group("depth", describe(settings.depth));
  set.add("shrink", settings.shrink, "match images shrunk by this factor", 1, 16);
  set.add_automatic("auto_num_disparities", settings.auto_num_disparities,
                    "widen the search to what the pair needs; off where num_disparities is given "
                    "alone",
                    kNumDisparities);
  return set;
}

struct DepthArguments {
  std::string left, right, rig, profile = "general", method = "sad", command_line;
  std::optional<int> num_disparities;
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
  std::optional<Error> problem;  // why there is no result
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

OptionSet profile_settings(const DepthArguments& arguments, DepthSettings& settings) {
  if (arguments.profile == "paper-q")
    settings = {paper_q_stereo_options(), DepthOptions{}, 1, false};
  return describe(settings);
}

Status choose_settings(const DepthArguments& arguments, OptionSet& options) {
  if (Status applied = apply_settings(arguments.common, options); !applied) return applied;
  if (!arguments.num_disparities) return {};
  const std::string setting = std::string(kNumDisparities) + "=";
  for (const std::string& other : arguments.common.settings) {
    if (!other.starts_with(setting)) continue;
    return fail(ErrorCode::kBadArgument, "it is also given by --set " + other, "--num-disparities",
                "Give one of them");
  }
  Status set = options.set(kNumDisparities, std::to_string(*arguments.num_disparities));
  if (set) options.settle();
  return set;
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
  range = std::min(run.left.width, std::max(range, *needed));
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

// What hinders, if nothing was matched or none of it lies within the kept depths.
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
  if (has_depth(run)) {
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
  constexpr std::array<const char*, 3> kAlways = {"disparity.pfm", "disparity.png", "report.html"};
  constexpr std::array<const char*, 2> kSometimes = {"depth.tif", "cloud.ply"};
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
  if (s && has_depth(run)) {
    s = add("depth.tif", [&](const fs::path& path) { return write_tiff(path, run.depth); });
    if (s) s = add("cloud.ply", [&](const fs::path& path) { return write_ply(path, run.cloud); });
  }
  if (s) s = add("report.html", [&](const fs::path& path) { return report.write(path); });
  if (!s) return s;
  remove_earlier(set, kAlways, kSometimes);
  return output.commit(set);
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
  command
      ->add_option("--method", arguments->method, "Matcher; sad (block matching) is the only one")
      ->type_name("NAME")
      ->check(CLI::IsMember({"sad"}).description(""))
      ->capture_default_str();
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
      "depth.tif (m, NaN = unknown) and cloud.ply. Files of an earlier run there are replaced.");
  command->callback([arguments, &status] { status = run_depth(*arguments); });
}

}  // namespace tread
