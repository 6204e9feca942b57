// From the points of one 640x480 depth image to the updated cost map, stage by stage, on one core;
// and how the times grow with the map. Everything is made here: a robot that looks down on rolling
// ground with a few boxes, driving.
// Usage: terrain [--json]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "times.hpp"
#include "tread/geometry/stereo_rig.hpp"
#include "tread/stereo/depth.hpp"
#include "tread/terrain/cost_map.hpp"
#include "tread/terrain/local_map.hpp"

namespace {

using namespace tread;

double ground_height(double x, double y) {
  const double hills = 0.15 * std::sin(0.9 * x) * std::cos(0.7 * y);
  const bool box =
      std::fmod(std::abs(x) + 0.3, 3.1) < 0.6 && std::fmod(std::abs(y) + 0.8, 2.3) < 0.5;
  return hills + (box ? 0.4 : 0.0);
}

// The depth image of a camera in the world, by marching along each ray.
Image<float> render_depth(const RectifiedRig& rig, const Isometry3d& T_world_camera, double far_m) {
  Image<float> depth(rig.size.width, rig.size.height, std::nanf(""));
  for (int v = 0; v < rig.size.height; ++v) {
    for (int u = 0; u < rig.size.width; ++u) {
      const Eigen::Vector3d ray = T_world_camera.linear() * rig.point(u, v, 1.0);
      const Eigen::Vector3d& eye = T_world_camera.translation();
      for (double z = 0.5; z < far_m; z += 0.02) {
        const Eigen::Vector3d p = eye + z * ray;
        if (p.z() > ground_height(p.x(), p.y())) continue;
        depth(u, v) = static_cast<float>(z);
        break;
      }
    }
  }
  return depth;
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  bench::Arguments arguments("terrain");
  arguments.flag("--json", json);
  if (const auto status = arguments.read(argc, argv)) return *status;
  const RectifiedRig rig = *rectified_rig(bumblebee2(640));
  const CameraMount mount = level_mount(1.0, 0.35, true);

  // Some depth images along the way, used over and over at ever new poses.
  constexpr int kImages = 8;
  constexpr double kStep = 0.05;  // 1 m/s at 20 Hz
  std::vector<Image<float>> images;
  for (int i = 0; i < kImages; ++i) {
    Isometry3d T_world_body = Isometry3d::Identity();
    T_world_body.translation().x() = 5 * kStep * i;
    images.push_back(render_depth(rig, T_world_body * mount.T_body_left, 6.0));
  }

  const CostOptions cost_options;
  GlobalMap ground;
  CostMap cost(cost_options, ground.resolution_m());
  const LocalMapOptions local_options;
  const GridGeometry local_grid =
      local_cells(view_from_above(rig, mount.T_body_left, 6.0), local_options.resolution_m);
  LocalMapBuilder builder;
  Grid<float> known;
  Grid<float> derivative;
  PointCloud cloud;
  std::map<std::string, std::vector<double>> stages;
  nlohmann::ordered_json growth = nlohmann::ordered_json::array();
  std::vector<double> totals;
  std::size_t points = 0;
  constexpr int kFrames = 4000;
  if (!json)
    fmt::print("growth with the map (median of 200 frames)\n{:>10} {:>12} {:>10}\n", "driven m",
               "known cells", "ms");
  for (int frame = 0; frame < kFrames; ++frame) {
    depth_cloud(images[static_cast<std::size_t>(frame % kImages)], rig, Reference::kLeft, {},
                cloud);
    points = cloud.points.size();
    // A winding way, so that the map grows in both directions.
    const double s = kStep * frame;
    const double yaw = 0.6 * std::sin(0.05 * s);
    const LevelPose pose{{s, 20.0 * std::sin(0.03 * s), 0.0}, yaw};
    Timings timings;
    const Context context{1, &timings};
    const double start_ms = bench::cpu_ms();
    ground.heights_below(local_grid, pose, known, context);
    const Grid<float>& height = builder.build(cloud.points, mount.T_body_left, local_grid,
                                              local_options, {&known}, context);
    sobel_squared(height, derivative, context);
    if (!ground.integrate(height, derivative, pose, {}, context)) return 1;
    cost.update(ground, ground.take_changes(), context);
    totals.push_back(bench::cpu_ms() - start_ms);
    for (const auto& [name, entry] : timings.entries()) stages[name].push_back(entry.total_ms);
    if ((frame + 1) % 500 == 0) {
      const double ms = bench::median({totals.end() - 200, totals.end()});
      const double cells = static_cast<double>(ground.cells().tile_count()) *
                           TiledGrid<GroundCell>::kTileCells * TiledGrid<GroundCell>::kTileCells;
      growth.push_back({{"driven_m", s}, {"cells_in_tiles", cells}, {"ms", ms}});
      if (!json) fmt::print("{:10.0f} {:12.0f} {:10.3f}\n", s, cells, ms);
    }
  }
  nlohmann::ordered_json result = {{"benchmark", "terrain"}, {"points", points}};
  if (!json)
    fmt::print("\nstages, {} points of one 640x480 depth image, one core (median of {})\n", points,
               kFrames);
  for (const auto& [name, values] : stages) {
    const double ms = bench::median(values);
    result["stages_ms"][name] = ms;
    if (!json) fmt::print("{:22} {:8.3f} ms\n", name, ms);
  }
  result["total_ms"] = bench::median(totals);
  result["growth"] = growth;
  if (json) {
    fmt::print("{}\n", result.dump(2));
  } else {
    fmt::print("{:22} {:8.3f} ms\n", "total", bench::median(totals));
  }
  return 0;
}
