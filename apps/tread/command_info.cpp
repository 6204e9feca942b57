// tread info: what a file or folder is, and what is in it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>

#include "command.hpp"
#include "info_text.hpp"
#include "tread/core/problems.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/map_files.hpp"
#include "tread/io/mesh_file.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/io/recording_files.hpp"
#include "tread/io/rgbd_source.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/source.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

void describe_imu(const Imu& imu, Output& output) {
  output.values["rig"]["imu"] = {{"rate_hz", imu.rate_hz},
                                 {"gyro_noise", imu.gyro_noise},
                                 {"accel_noise", imu.accel_noise},
                                 {"gyro_walk", imu.gyro_walk},
                                 {"accel_walk", imu.accel_walk}};
  output.line(fmt::format(
      "  IMU: {:g} Hz, noise {:.2g} rad/s/sqrt(Hz) and {:.2g} m/s^2/sqrt(Hz), random walk {:.2g} "
      "rad/s^2/sqrt(Hz) and {:.2g} m/s^3/sqrt(Hz)",
      imu.rate_hz, imu.gyro_noise, imu.accel_noise, imu.gyro_walk, imu.accel_walk));
}

void describe_rig(const StereoRig& rig, Output& output) {
  const PinholeCamera left = pinhole_of(rig.left);
  const double baseline = rig.T_left_right.translation().norm();
  output.values["rig"] = {{"size_px", {rig.size.width, rig.size.height}},
                          {"fx_px", left.fx},
                          {"fy_px", left.fy},
                          {"cx_px", left.cx},
                          {"cy_px", left.cy},
                          {"baseline_m", baseline},
                          {"rectified", rig.rectified}};
  output.line(fmt::format("rig: {}x{} px, f {:.1f} px, baseline {:.4f} m, {}", rig.size.width,
                          rig.size.height, left.fx, baseline,
                          rig.rectified ? "rectified" : "to be rectified"));
  for (double z : {1.0, 2.0, 5.0, 10.0}) {
    const double step = 0.25 * z * z / (baseline * left.fx);
    output.values["rig"]["quarter_pixel_m"][fmt::format("{:g}", z)] = step;
    output.line(fmt::format("  a quarter pixel at {:g} m is {:.1f} mm", z, 1000.0 * step));
  }
  if (rig.imu) describe_imu(*rig.imu, output);
  if (!rig.mount) return;
  const double height = rig.mount->T_body_left.translation().z();
  output.values["rig"]["mount"] = {{"height_m", height}, {"assumed", rig.mount->assumed}};
  output.line(fmt::format("  mounted {:.2f} m above the ground{}", height,
                          rig.mount->assumed ? " (assumed)" : ""));
}

Status info_rgbd(const fs::path& path, Output& output) {
  const auto source = open_rgbd_source(path);
  if (!source) return forward(source);
  const RgbdCamera& camera = (*source)->camera();
  output.values["kind"] = (*source)->kind();
  output.values["frames"] = (*source)->frame_count();
  output.values["poses"] = (*source)->has_poses();
  output.values["camera"] = {{"size_px", {camera.size.width, camera.size.height}},
                             {"fx_px", camera.pinhole.fx},
                             {"fy_px", camera.pinhole.fy},
                             {"cx_px", camera.pinhole.cx},
                             {"cy_px", camera.pinhole.cy}};
  output.line(fmt::format("{}: {}, {}", (*source)->kind(),
                          frames_text(static_cast<std::size_t>((*source)->frame_count())),
                          (*source)->has_poses() ? "with reference poses" : "without poses"));
  output.line(fmt::format("depth camera: {}x{} px, f {:.1f} px", camera.size.width,
                          camera.size.height, camera.pinhole.fx));
  for (const Error& problem : distinct_problems((*source)->problems())) {
    output.values["problems"].push_back(problem.message());
    output.line("  " + problem.message());
  }
  return {};
}

// What a recording of this program says of itself.
Status describe_recording(const fs::path& folder, Output& output) {
  if (!is_recording(folder)) return {};
  const auto info = read_recording_info(folder);
  if (!info) return forward(info);
  output.values["recording"] = {{"description", info->description}, {"heads", info->heads}};
  std::string list;
  for (const auto& [name, count] : info->samples) {
    output.values["recording"]["samples"][name] = count;
    list += fmt::format("{}{} {}", list.empty() ? "" : ", ", name, count);
  }
  output.line(fmt::format("recording: {}", info->description));
  output.line(fmt::format("  samples: {}", list));
  return {};
}

Status info_source(const fs::path& path, const std::string& rig, Output& output) {
  if (looks_like_rgbd(path)) return info_rgbd(path, output);
  const auto source = open_stereo_source(path, {rig, ""});
  if (!source) return forward(source);
  output.values["kind"] = (*source)->kind();
  output.values["frames"] = (*source)->frame_count();
  output.values["poses"] = (*source)->has_poses();
  output.values["imu"] = (*source)->has_imu();
  output.line(fmt::format("{}: {}, {}{}", (*source)->kind(),
                          frames_text(static_cast<std::size_t>((*source)->frame_count())),
                          (*source)->has_poses() ? "with poses" : "without poses",
                          (*source)->has_imu() ? ", with samples of an IMU" : ""));
  if (Status done = describe_recording(path, output); !done) return done;
  describe_rig((*source)->rig(), output);
  for (const Error& problem : distinct_problems((*source)->problems())) {
    output.values["problems"].push_back(problem.message());
    output.line("  problem: " + problem.message());
  }
  return {};
}

// Smallest and largest of the finite values; nothing if there are none.
std::optional<ValueRange> known_range(std::span<const float> values) {
  std::optional<ValueRange> range;
  for (const float v : values) {
    if (!std::isfinite(v)) continue;
    if (!range) range = ValueRange{v, v};
    range->low = std::min(range->low, v);
    range->high = std::max(range->high, v);
  }
  return range;
}

std::string range_text(const std::optional<ValueRange>& range, const std::string& unit) {
  if (!range) return "nothing known";
  return fmt::format("{:g} to {:g}{}{}", range->low, range->high, unit.empty() ? "" : " ", unit);
}

void put_range(const std::optional<ValueRange>& range, nlohmann::ordered_json& json) {
  if (!range) return;
  json["low"] = range->low;
  json["high"] = range->high;
}

Status info_map(const fs::path& path, Output& output) {
  const auto map = load_map(path);
  if (!map) return forward(map);
  output.values["kind"] = "map";
  output.line("map in frame " + map->frame);
  for (const MapLayer& layer : map->layers) {
    const GridGeometry& g = layer.grid.geometry;
    const auto range = known_range(layer.grid.values);
    // Layers without unit have the unit 1 in the file.
    const std::string unit = layer.unit == "1" ? "" : layer.unit;
    output.values["layers"].push_back({{"name", layer.name},
                                       {"unit", unit},
                                       {"resolution_m", g.resolution_m},
                                       {"columns", g.columns},
                                       {"rows", g.rows},
                                       {"origin_m", {g.origin.x(), g.origin.y()}}});
    put_range(range, output.values["layers"].back());
    output.line(fmt::format("  {:14} {:5}x{:<5} cells of {:g} m from ({:.1f}, {:.1f}), {}",
                            layer.name, g.columns, g.rows, g.resolution_m, g.origin.x(),
                            g.origin.y(), range_text(range, unit)));
  }
  for (const auto& [name, value] : map->numbers) {
    output.values["numbers"][name] = value;
    output.line(fmt::format("  {} = {:g}", name, value));
  }
  return {};
}

Status info_float_image(const Result<Image<float>>& image, const std::string& kind,
                        Output& output) {
  if (!image) return forward(image);
  std::vector<float> values;
  for (int y = 0; y < image->height; ++y) {
    values.insert(values.end(), image->row(y), image->row(y) + image->width);
  }
  const auto range = known_range(values);
  output.values["size_px"] = {image->width, image->height};
  put_range(range, output.values);
  say_kind(kind, fmt::format("{}x{}, {}", image->width, image->height, range_text(range, "")),
           output);
  return {};
}

Status info_tiff(const fs::path& path, Output& output) {
  const auto grid = read_geotiff(path);
  if (!grid) return info_float_image(read_tiff(path), "float image (TIFF)", output);
  const GridGeometry& g = grid->geometry;
  const auto range = known_range(grid->values);
  output.values["columns"] = g.columns;
  output.values["rows"] = g.rows;
  output.values["resolution_m"] = g.resolution_m;
  output.values["origin_m"] = {g.origin.x(), g.origin.y()};
  put_range(range, output.values);
  say_kind("GeoTIFF grid",
           fmt::format("{}x{} cells of {:g} m from ({:.1f}, {:.1f}), {}", g.columns, g.rows,
                       g.resolution_m, g.origin.x(), g.origin.y(), range_text(range, "")),
           output);
  return {};
}

Status info_cloud(const fs::path& path, Output& output) {
  const auto cloud = read_ply(path);
  if (!cloud) return forward(cloud);
  output.values["points"] = cloud->points.size();
  output.values["coloured"] = !cloud->colours.empty();
  say_kind(
      "point cloud",
      fmt::format("{} points{}", cloud->points.size(), cloud->colours.empty() ? "" : ", coloured"),
      output);
  return {};
}

Status info_image(const fs::path& path, Output& output) {
  const auto image = read_grey_and_colour(path);
  if (!image) return forward(image);
  const bool colour = !image->colour.empty();
  output.values["size_px"] = {image->grey.width, image->grey.height};
  output.values["colour"] = colour;
  say_kind(
      "image",
      fmt::format("{}x{}, {}", image->grey.width, image->grey.height, colour ? "colour" : "grey"),
      output);
  return {};
}

Status info_rig(const std::string& path, Output& output) {
  const auto rig = read_rig(path);
  if (!rig) return forward(rig);
  say_kind("stereo rig", rig->name, output);
  describe_rig(*rig, output);
  return {};
}

Status info_file(const fs::path& path, Output& output) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto is = [&](std::initializer_list<const char*> known) {
    return std::find(known.begin(), known.end(), extension) != known.end();
  };
  if (path.filename() == "map.yaml") return info_map(path, output);
  if (is({".pfm"})) return info_float_image(read_pfm(path), "float image (PFM)", output);
  if (is({".tif", ".tiff"})) return info_tiff(path, output);
  if (is({".ply"})) return info_cloud(path, output);
  if (is({".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".pnm"})) return info_image(path, output);
  if (const auto told = info_text(path, output)) return *told;
  const Status rig = info_rig(path.string(), output);
  const bool rig_format = is({".yaml", ".yml", ".xml"}) || path.stem() == "calib";
  if (rig || rig_format) return rig;
  return fail(ErrorCode::kUnsupported, "this is no file that tread knows", path.string(),
              "It knows drives (folders), maps, rigs, images, PFM, TIFF, PLY, trajectories, times "
              "and path.csv: docs/file-formats.md");
}

// A folder that a command has written, by a file that only this command writes; nothing if it is
// none.
std::optional<std::string> results_in(const fs::path& folder) {
  constexpr std::array<std::pair<const char*, const char*>, 3> kSigns = {
      {{"disparity.pfm", "results of 'tread depth'"},
       {"plan.png", "results of 'tread plan'"},
       {"trajectory.tum", "results of 'tread map' without a map, as nothing was mapped"}}};
  std::error_code ignored;
  for (const auto& [sign, kind] : kSigns) {
    if (fs::exists(folder / sign, ignored)) return kind;
  }
  return std::nullopt;
}

void info_results(const fs::path& folder, const std::string& kind, Output& output) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    names.push_back(at->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  output.values["files"] = names;
  say_kind(kind, fmt::format("{}", fmt::join(names, ", ")), output);
}

int run_info(const std::string& path, const std::string& rig, const CommonOptions& common) {
  Output output(common.json);
  output.values["path"] = path;
  std::error_code ignored;
  Status done;
  if (named_rig(path)) {
    done = info_rig(path, output);
  } else if (!fs::exists(path, ignored)) {
    done = fail(ErrorCode::kNotFound, "there is no such file or folder", path, "Check the name");
  } else if (!fs::is_directory(path, ignored)) {
    done = info_file(path, output);
  } else if (fs::exists(fs::path(path) / "map.yaml", ignored)) {
    done = info_map(path, output);
  } else if (const auto results = results_in(path)) {
    info_results(path, *results, output);
  } else {
    done = info_source(path, rig, output);
  }
  if (!done) return print_error(done.error());
  output.print_json();
  return 0;
}

}  // namespace

void add_info_command(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("info", "What a file or folder is");
  struct Arguments {
    std::string path, rig;
    CommonOptions common;
  };
  auto arguments = std::make_shared<Arguments>();
  command
      ->add_option("PATH", arguments->path,
                   "A drive or a map (folders), or a file: rig (or a known name), image, PFM, "
                   "TIFF, PLY, trajectory, times, path.csv, map for Nav2")
      ->type_name("")
      ->required();
  command->add_option("--rig", arguments->rig, "Calibration of a drive that brings none")
      ->type_name("RIG");
  command->add_flag("--json", arguments->common.json, "Print one JSON object and nothing else");
  command->footer(
      "Examples:\n  tread info kitti/sequences/00\n  tread info out/map\n"
      "  tread info bumblebee2-640");
  command->callback([arguments, &status] {
    status = run_info(arguments->path, arguments->rig, arguments->common);
  });
}

}  // namespace tread
