// What it costs to render a stereo pair of a world of more than a million triangles: rolling ground
// of 707 x 707 heights in four materials, rocks, trees, tall grass, people; sun with shadows,
// textures, noise of the sensor. CPU time of all threads, with a breakdown, and the time to make
// the world ready.
// Usage: simulated_cameras [--json] [--turns N]
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "times.hpp"
#include "tread/geometry/stereo_rig.hpp"
#include "tread/sim/camera_view.hpp"
#include "tread/sim/hash_noise_kernel.hpp"
#include "tread/sim/image_sensor.hpp"

namespace {

using namespace tread;

// Of all threads: Embree builds with several.
double process_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Numbers from -1 to 1, one after another.
class Numbers {
 public:
  double next() { return static_cast<double>(signed_unit(hash_mix(++count_))); }
  Eigen::Vector3d direction() { return Eigen::Vector3d(next(), next(), next()).normalized(); }

 private:
  std::uint32_t count_ = 0;
};

Mesh rock_hull() {
  Mesh mesh;  // an icosahedron
  const float g = 0.5F * (1.0F + std::sqrt(5.0F)), scale = 1.0F / std::sqrt(1.0F + g * g);
  for (const float a : {-1.0F, 1.0F}) {
    for (const float b : {-g, g}) {
      mesh.vertices.push_back(scale * Eigen::Vector3f(a, b, 0.0F));
      mesh.vertices.push_back(scale * Eigen::Vector3f(0.0F, a, b));
      mesh.vertices.push_back(scale * Eigen::Vector3f(b, 0.0F, a));
    }
  }
  const auto& v = mesh.vertices;
  const float edge = 2.0F * scale * 1.01F;
  for (std::int32_t i = 0; i < 12; ++i) {
    for (std::int32_t j = i + 1; j < 12; ++j) {
      for (std::int32_t k = j + 1; k < 12; ++k) {
        const auto& [a, b, c] =
            std::tie(v[static_cast<std::size_t>(i)], v[static_cast<std::size_t>(j)],
                     v[static_cast<std::size_t>(k)]);
        if ((a - b).norm() > edge || (b - c).norm() > edge || (c - a).norm() > edge) continue;
        const bool outwards = (b - a).cross(c - a).dot(a) > 0.0F;
        mesh.triangles.push_back(outwards ? std::array{i, j, k} : std::array{i, k, j});
      }
    }
  }
  return mesh;
}

void add_leaf(Mesh& mesh, const Eigen::Vector3d& at, const Eigen::Vector3d& along,
              const Eigen::Vector3d& across) {
  const auto first = static_cast<std::int32_t>(mesh.vertices.size());
  for (const Eigen::Vector3d& corner :
       {at, Eigen::Vector3d(at + along + across), Eigen::Vector3d(at + along - across)}) {
    mesh.vertices.push_back(corner.cast<float>());
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
}

void add_ground(World& world, int side) {
  const double resolution = 0.1;
  const GridGeometry geometry{resolution, Eigen::Vector2d::Constant(-0.5 * resolution * side), side,
                              side};
  world.ground = Grid<float>(geometry);
  world.ground_surface = Grid<std::uint8_t>(geometry);
  for (const Surface surface :
       {Surface::kSoil, Surface::kGrass, Surface::kGravel, Surface::kSand}) {
    world.ground_materials.push_back(material_of(surface, Season::kSummer, 11));
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const auto p = geometry.centre({x, y}).cast<float>().eval();
      world.ground[{x, y}] = 2.2F * fbm(0.09F * p.x(), 0.09F * p.y(), 6, 0.5F, 1U);
      const float kind = fbm(0.2F * p.x(), 0.2F * p.y(), 3, 0.5F, 2U);
      world.ground_surface[{x, y}] = static_cast<std::uint8_t>(kind < -0.15F  ? 3
                                                               : kind < 0.0F  ? 0
                                                               : kind < 0.18F ? 1
                                                                              : 2);
    }
  }
}

Eigen::Vector3d some_place(const World& world, Numbers& numbers, double reach_m) {
  const Eigen::Vector2d at(reach_m * numbers.next(), reach_m * numbers.next());
  return {at.x(), at.y(), ground_height(world, at)};
}

void add_things(World& world) {
  Numbers numbers;
  world.hulls = {rock_hull()};
  for (int i = 0; i < 400; ++i) {
    Solid rock;
    rock.shape = Solid::Shape::kHull;
    rock.half_m = Eigen::Vector3d::Constant(0.22 + 0.18 * numbers.next());
    rock.T_world_solid.translation() = some_place(world, numbers, 34.0);
    rock.T_world_solid.linear() = so3_exp(3.0 * numbers.direction());
    rock.material = material_of(Surface::kRock, Season::kSummer, static_cast<std::uint32_t>(i));
    world.solids.push_back(rock);
  }
  Foliage crowns{"crowns", {}, material_of(Surface::kLeaves, Season::kSummer, 1)};
  for (int tree = 0; tree < 24; ++tree) {
    const Eigen::Vector3d foot = some_place(world, numbers, 32.0);
    Solid trunk;
    trunk.shape = Solid::Shape::kCylinder;
    trunk.half_m = {0.14, 0.14, 1.5};
    trunk.T_world_solid.translation() = foot + Eigen::Vector3d(0.0, 0.0, 1.3);
    trunk.material = material_of(Surface::kBark, Season::kSummer, static_cast<std::uint32_t>(tree));
    world.solids.push_back(trunk);
    for (int leaf = 0; leaf < 2500; ++leaf) {
      const Eigen::Vector3d at = foot + Eigen::Vector3d(0.0, 0.0, 3.4) +
                                 std::cbrt(0.5 + 0.5 * numbers.next()) * 1.2 * numbers.direction();
      add_leaf(crowns.mesh, at, 0.08 * numbers.direction(), 0.03 * numbers.direction());
    }
  }
  Foliage grass{"tall grass", {}, material_of(Surface::kGrass, Season::kSummer, 2)};
  for (int blade = 0; blade < 30000; ++blade) {
    const Eigen::Vector3d lean(0.1 * numbers.next(), 0.1 * numbers.next(), -0.35);
    add_leaf(grass.mesh, some_place(world, numbers, 20.0) - lean, lean,
             0.006 * numbers.direction());
  }
  world.foliage = {std::move(crowns), std::move(grass)};
  for (int i = 0; i < 3; ++i) {
    Person person;
    person.path_m = {{4.0 + 2.0 * i, -3.0}, {5.0 + 2.0 * i, 3.0}};
    person.clothes = material_of(Surface::kCloth, Season::kSummer, static_cast<std::uint32_t>(i));
    world.people.push_back(person);
  }
}

struct Pair {
  const Scene& scene;
  const StereoRig& rig;
  const CameraRays& rays;
  const ImageSensor& sensor;
  CameraView left, right;
  Image<std::uint8_t> images[2];

  // CPU milliseconds of both views, and of both exposures if asked for.
  double run(const Isometry3d& T_world_left, const RenderOptions& options, bool expose) {
    const double start = process_ms();
    bool done = bool(render(scene, rays, CameraShot::still(T_world_left), options, left)) &&
                bool(render(scene, rays, CameraShot::still(T_world_left * rig.T_left_right),
                            options, right));
    if (expose) {
      const Exposure exposure = sensor.meter(left);
      done = done && sensor.expose(left, exposure, {1, 0, 0}, images[0]) &&
             sensor.expose(right, exposure, {1, 0, 1}, images[1]);
    }
    return done ? process_ms() - start : std::nan("");
  }
};

std::vector<Isometry3d> some_poses(const World& world) {
  std::vector<Isometry3d> poses;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector2d at(-14.0 + 3.5 * i, 3.0 * std::sin(i));
    Isometry3d T = Isometry3d::Identity();
    T.linear() = rotation_from_yaw_pitch_roll(0.4 * i, 0.25, 0.0) * R_body_optical();
    T.translation() << at, ground_height(world, at) + 1.0;
    poses.push_back(T);
  }
  return poses;
}

// Median over turns of the mean over poses.
double median_ms(Pair& pair, const std::vector<Isometry3d>& poses, const RenderOptions& options,
                 bool expose, int turns) {
  std::vector<double> times;
  for (int turn = 0; turn < turns; ++turn) {
    double sum = 0.0;
    for (const Isometry3d& T : poses) sum += pair.run(T, options, expose);
    times.push_back(sum / static_cast<double>(poses.size()));
  }
  return bench::median(times);
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  int turns = 5;
  bench::Arguments arguments("simulated_cameras");
  arguments.flag("--json", json).number("--turns", turns, 1);
  if (const auto status = arguments.read(argc, argv)) return *status;

  World world;
  add_ground(world, 707);
  add_things(world);
  std::size_t triangles = 2U * 706U * 706U + 20U * 400U;
  for (const Foliage& foliage : world.foliage) triangles += foliage.mesh.triangles.size();
  const auto shared = std::make_shared<const World>(std::move(world));
  const double start = process_ms();
  const Result<Scene> scene = Scene::make(shared);
  const double ready_ms = process_ms() - start;
  if (!scene) {
    fmt::print(stderr, "{}\n", scene.error().message());
    return 1;
  }
  nlohmann::ordered_json result = {
      {"benchmark", "simulated_cameras"}, {"triangles", triangles}, {"world_ready_ms", ready_ms}};
  if (!json) {
    fmt::print(
        "{} triangles, ready in {:.0f} ms of CPU\n\nCPU ms a stereo pair (median of {})\n"
        "{:>10} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>12}\n",
        triangles, ready_ms, turns, "size", "rays", "light", "shadows", "sensor", "all", "ns/pixel",
        "colour extra");
  }
  const std::vector<Isometry3d> poses = some_poses(*shared);
  for (const int factor : {1, 2}) {
    const StereoRig rig = shrunk(bumblebee2(640), factor);
    const auto rays = make_camera_rays(rig.left, rig.size);
    if (!rays) return 1;
    const auto sensor = ImageSensor::make({}, *rays);
    if (!sensor) return 1;
    Pair pair{*scene, rig, *rays, *sensor, {}, {}, {}};
    const double depth = median_ms(pair, poses, {false, false, false, 1}, false, turns);
    const double bare = median_ms(pair, poses, {true, false, false, 1}, false, turns);
    const double shadows = median_ms(pair, poses, {true, false, true, 1}, false, turns);
    const double all = median_ms(pair, poses, {true, false, true, 1}, true, turns);
    const double colour = median_ms(pair, poses, {true, true, true, 1}, true, turns);
    const double ns = 1e6 * all / (2.0 * rig.size.width * rig.size.height);
    const std::string size = fmt::format("{}x{}", rig.size.width, rig.size.height);
    result["pair_ms"][size] = {{"rays", depth},
                               {"light", bare - depth},
                               {"shadows", shadows - bare},
                               {"sensor", all - shadows},
                               {"all", all},
                               {"colour_extra", colour - all}};
    if (json) continue;
    fmt::print("{:>10} {:8.1f} {:8.1f} {:8.1f} {:8.1f} {:8.1f} {:8.0f} {:12.1f}\n", size, depth,
               bare - depth, shadows - bare, all - shadows, all, ns, colour - all);
  }
  if (json) fmt::print("{}\n", result.dump(2));
  return 0;
}
