// tread info: what a file or folder is, and what is in it.
#include <fmt/format.h>

#include "command.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/map_files.hpp"
#include "tread/io/mesh_file.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/source.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

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
  if (!rig.mount) return;
  const double height = rig.mount->T_body_left.translation().z();
  output.values["rig"]["mount"] = {{"height_m", height}, {"assumed", rig.mount->assumed}};
  output.line(fmt::format("  mounted {:.2f} m above the ground{}", height,
                          rig.mount->assumed ? " (assumed)" : ""));
}

Status info_source(const fs::path& path, const std::string& rig, Output& output) {
  const auto source = open_stereo_source(path, {rig, ""});
  if (!source) return forward(source);
  output.values["kind"] = (*source)->kind();
  output.values["frames"] = (*source)->frame_count();
  output.values["poses"] = (*source)->has_poses();
  output.line(fmt::format("{}: {} frames, {}", (*source)->kind(), (*source)->frame_count(),
                          (*source)->has_poses() ? "with poses" : "without poses"));
  describe_rig((*source)->rig(), output);
  return {};
}

Status info_map(const fs::path& path, Output& output) {
  const auto map = load_map(path);
  if (!map) return forward(map);
  output.values["kind"] = "map";
  output.line("map in frame " + map->frame);
  for (const MapLayer& layer : map->layers) {
    const GridGeometry& g = layer.grid.geometry;
    const ValueRange range = value_range(layer.grid, 0.0);
    output.values["layers"].push_back({{"name", layer.name},
                                       {"unit", layer.unit},
                                       {"resolution_m", g.resolution_m},
                                       {"columns", g.columns},
                                       {"rows", g.rows},
                                       {"origin_m", {g.origin.x(), g.origin.y()}},
                                       {"low", range.low},
                                       {"high", range.high}});
    output.line(
        fmt::format("  {:12} {:5}x{:<5} cells of {:g} m from ({:.1f}, {:.1f}), {:g} to {:g} {}",
                    layer.name, g.columns, g.rows, g.resolution_m, g.origin.x(), g.origin.y(),
                    range.low, range.high, layer.unit));
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
  const ValueRange range = value_range(*image, 0.0);
  output.values["kind"] = kind;
  output.values["size_px"] = {image->width, image->height};
  output.values["low"] = range.low;
  output.values["high"] = range.high;
  output.line(fmt::format("{}: {}x{}, {:g} to {:g}", kind, image->width, image->height, range.low,
                          range.high));
  return {};
}

Status info_file(const fs::path& path, Output& output) {
  const std::string extension = path.extension().string();
  if (path.filename() == "map.yaml") return info_map(path, output);
  if (extension == ".pfm") return info_float_image(read_pfm(path), "float image (PFM)", output);
  if (extension == ".tif" || extension == ".tiff") {
    if (const auto grid = read_geotiff(path)) {
      const GridGeometry& g = grid->geometry;
      output.values["kind"] = "GeoTIFF grid";
      output.values["columns"] = g.columns;
      output.values["rows"] = g.rows;
      output.values["resolution_m"] = g.resolution_m;
      output.line(
          fmt::format("GeoTIFF grid: {}x{} cells of {:g} m", g.columns, g.rows, g.resolution_m));
      return {};
    }
    return info_float_image(read_tiff(path), "float image (TIFF)", output);
  }
  if (extension == ".ply") {
    const auto cloud = read_ply(path);
    if (!cloud) return forward(cloud);
    output.values["kind"] = "point cloud";
    output.values["points"] = cloud->points.size();
    output.values["coloured"] = !cloud->colours.empty();
    output.line(fmt::format("point cloud: {} points{}", cloud->points.size(),
                            cloud->colours.empty() ? "" : ", coloured"));
    return {};
  }
  if (extension == ".tum") {
    const auto trajectory = read_tum_trajectory(path);
    if (!trajectory) return forward(trajectory);
    output.values["kind"] = "trajectory";
    output.values["poses"] = trajectory->size();
    output.line(fmt::format("trajectory: {} poses", trajectory->size()));
    return {};
  }
  if (extension == ".png" || extension == ".jpg" || extension == ".jpeg" || extension == ".pgm") {
    const auto image = read_grey(path);
    if (!image) return forward(image);
    const auto colour = has_colour(path);
    output.values["kind"] = "image";
    output.values["size_px"] = {image->width, image->height};
    output.values["colour"] = colour && *colour;
    output.line(fmt::format("image: {}x{}, {}", image->width, image->height,
                            colour && *colour ? "colour" : "grey"));
    return {};
  }
  const auto rig = read_rig(path.string());
  if (!rig) return forward(rig);
  output.values["kind"] = "stereo rig";
  output.line("stereo rig " + rig->name);
  describe_rig(*rig, output);
  return {};
}

int run_info(const std::string& path, const std::string& rig, const CommonOptions& common) {
  Output output(common.json);
  output.values["path"] = path;
  std::error_code ignored;
  Status done;
  if (named_rig(path)) {
    done = info_file(path, output);
  } else if (!fs::exists(path, ignored)) {
    done = fail(ErrorCode::kNotFound, "there is no such file or folder", path, "Check the name");
  } else if (!fs::is_directory(path, ignored)) {
    done = info_file(path, output);
  } else if (fs::exists(fs::path(path) / "map.yaml", ignored)) {
    done = info_map(path, output);
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
                   "Drive, map, rig (file or known name), image, PFM, TIFF, PLY, trajectory")
      ->required();
  command->add_option("--rig", arguments->rig, "Rig of a folder that has none")->type_name("RIG");
  command->add_flag("--json", arguments->common.json, "Print one JSON object and nothing else");
  command->footer(
      "Examples:\n  tread info kitti/sequences/00\n  tread info out/map\n"
      "  tread info bumblebee2-640");
  command->callback([arguments, &status] {
    status = run_info(arguments->path, arguments->rig, arguments->common);
  });
}

}  // namespace tread
