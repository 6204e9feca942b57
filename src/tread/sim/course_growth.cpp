// What lies and grows there: rocks, trees, shrubs, tall grass. One, or many scattered over an area.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tread/sim/course_builder.hpp"
#include "tread/sim/hull.hpp"

namespace tread::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kStoneShapes = 12;

Vector3d direction(Random& random) {
  const double z = random.uniform(-1.0, 1.0), turn = kTurn * random.uniform();
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

void add_triangle(Mesh& mesh, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto first = static_cast<std::int32_t>(mesh.vertices.size());
  for (const Vector3d& v : {a, b, c}) mesh.vertices.push_back(v.cast<float>());
  mesh.triangles.push_back({first, first + 1, first + 2});
}

// A leaf: two triangles with a fold, `size` long.
void add_leaf(Mesh& mesh, const Vector3d& at, double size, Random& random) {
  const Vector3d along = size * direction(random);
  const Vector3d across = 0.35 * size * along.cross(direction(random)).normalized();
  const Vector3d fold = 0.15 * size * along.cross(across).normalized();
  add_triangle(mesh, at, at + 0.5 * along + across + fold, at + along);
  add_triangle(mesh, at, at + along, at + 0.5 * along - across + fold);
}

// What is put at one place; sizes are drawn from the ranges of the entry.
struct Spot {
  std::string name;
  Vector2d at;
  double size_m;
  Material material;
};

void add_rock(CourseBuilder& builder, const Spot& spot, Random& random) {
  World& world = builder.world;
  while (world.hulls.size() < kStoneShapes) {
    Random shape = builder.random.stream("stones").stream(world.hulls.size());
    world.hulls.push_back(stone_hull(16 + static_cast<int>(world.hulls.size()), shape.bits()));
  }
  Solid rock;
  rock.name = spot.name;
  rock.shape = Solid::Shape::kHull;
  rock.hull = static_cast<int>(random.uniform() * kStoneShapes);
  rock.half_m =
      0.5 * spot.size_m * Vector3d(1.0, random.uniform(0.65, 0.95), random.uniform(0.45, 0.8));
  rock.T_world_solid.linear() = rotation_from_yaw_pitch_roll(
      kTurn * random.uniform(), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
  // A third of it is in the ground.
  rock.T_world_solid.translation() << spot.at,
      builder.height(spot.at) + random.uniform(0.1, 0.6) * rock.half_m.z();
  rock.material = spot.material;
  world.solids.push_back(std::move(rock));
  builder.taken.push_back({spot.at, 0.5 * spot.size_m});
}

// A limb from one point to another, as a cylinder.
Solid limb(const std::string& name, const Vector3d& from, const Vector3d& to, double radius,
           const Material& material) {
  Solid solid;
  solid.name = name;
  solid.shape = Solid::Shape::kCylinder;
  solid.half_m = Vector3d(radius, radius, 0.5 * (to - from).norm());
  solid.T_world_solid.linear() =
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), to - from).toRotationMatrix();
  solid.T_world_solid.translation() = 0.5 * (from + to);
  solid.material = material;
  return solid;
}

// A trunk, boughs, and a crown of leaves in clumps about their ends; spot.size_m is its height.
void add_tree(CourseBuilder& builder, const Spot& spot, Random& random) {
  const double height = spot.size_m, radius = height * random.uniform(0.018, 0.03),
               crown = height * random.uniform(0.22, 0.32);
  const double ground = builder.height(spot.at);
  const Vector3d foot(spot.at.x(), spot.at.y(), ground - 0.3);
  const Vector3d fork =
      Vector3d(spot.at.x(), spot.at.y(), ground + random.uniform(0.4, 0.5) * height) +
      0.03 * height * direction(random);
  const Material bark = builder.material(Surface::kBark, random);
  builder.world.solids.push_back(limb(spot.name + " trunk", foot, fork, radius, bark));
  std::vector<Vector3d> ends;
  const int boughs = 5 + static_cast<int>(4.0 * random.uniform());
  for (int i = 0; i < boughs; ++i) {
    const double turn = kTurn * (i + 0.6 * random.uniform()) / boughs;
    const double up = random.uniform(0.35, 0.95), out = std::sqrt(1.0 - up * up);
    const Vector3d end = fork + crown * random.uniform(0.7, 1.2) *
                                    Vector3d(out * std::cos(turn), out * std::sin(turn), up);
    builder.world.solids.push_back(
        limb(fmt::format("{} bough {}", spot.name, i + 1), fork, end, 0.35 * radius, bark));
    ends.push_back(end);
    ends.push_back(fork + 0.6 * (end - fork));
  }
  builder.taken.push_back({spot.at, radius + 0.2});
  const double leaves = builder.season == Season::kWinter   ? 0.0
                        : builder.season == Season::kAutumn ? 0.6
                                                            : 1.0;
  Foliage foliage{spot.name + " crown", {}, spot.material};
  const int count = static_cast<int>(leaves * 1100.0);
  for (int i = 0; i < count; ++i) {
    const Vector3d& middle =
        ends[static_cast<std::size_t>(random.uniform() * static_cast<double>(ends.size()))];
    const Vector3d at = middle + 0.55 * crown * std::cbrt(random.uniform()) * direction(random);
    add_leaf(foliage.mesh, at, random.uniform(0.10, 0.18), random);
  }
  if (count > 0) builder.world.foliage.push_back(std::move(foliage));
}

// Stems nobody gets through, and leaves around; spot.size_m is its height.
void add_shrub(CourseBuilder& builder, const Spot& spot, Random& random) {
  const double height = spot.size_m, radius = height * random.uniform(0.45, 0.65);
  const double ground = builder.height(spot.at);
  Solid core;
  core.name = spot.name;
  core.shape = Solid::Shape::kEllipsoid;
  core.half_m = Vector3d(0.75 * radius, 0.75 * radius, 0.5 * height);
  core.T_world_solid.translation() << spot.at, ground + 0.42 * height;
  core.material = spot.material;
  // Between the leaves it is dark.
  core.material.albedo *= 0.35F;
  builder.world.solids.push_back(std::move(core));
  builder.taken.push_back({spot.at, radius});
  Foliage foliage{spot.name + " leaves", {}, spot.material};
  const bool bare = builder.season == Season::kWinter;
  const int count = static_cast<int>((bare ? 120.0 : 600.0) * std::max(height, 0.3));
  for (int i = 0; i < count; ++i) {
    Vector3d out = direction(random);
    out.z() = std::abs(out.z()) * 1.3 - 0.3;
    const double share = random.uniform(0.75, 1.05);
    const Vector3d at(spot.at.x() + share * radius * out.x(),
                      spot.at.y() + share * radius * out.y(),
                      ground + 0.45 * height + share * 0.55 * height * out.z());
    if (at.z() > ground) add_leaf(foliage.mesh, at, random.uniform(0.03, 0.08), random);
  }
  builder.world.foliage.push_back(std::move(foliage));
}

// A tuft: blades that bend outwards. To a camera it is as high as its blades, to a wheel nothing.
void add_tuft(CourseBuilder& builder, Mesh& mesh, const Vector2d& at, double height,
              Random& random) {
  const double ground = builder.height(at);
  const int blades = 5 + static_cast<int>(5.0 * random.uniform());
  for (int i = 0; i < blades; ++i) {
    const double turn = kTurn * random.uniform(), lean = random.uniform(0.05, 0.45);
    const Vector3d out(std::cos(turn), std::sin(turn), 0.0), side(-out.y(), out.x(), 0.0);
    const double length = height * random.uniform(0.6, 1.0), width = random.uniform(0.002, 0.004);
    const Vector3d foot = Vector3d(at.x(), at.y(), ground) + 0.02 * out * random.uniform();
    const Vector3d middle = foot + length * (0.35 * lean * out + Vector3d(0, 0, 0.55));
    const Vector3d tip = foot + length * (lean * out + Vector3d(0, 0, 1.0 - 0.3 * lean));
    add_triangle(mesh, foot - width * side, foot + width * side, middle + width * side);
    add_triangle(mesh, foot - width * side, middle + width * side, middle - width * side);
    add_triangle(mesh, middle - width * side, middle + width * side, tip);
  }
}

struct Area {
  Vector2d low, high;
  [[nodiscard]] Vector2d draw(Random& random) const {
    const double x = random.uniform(), y = random.uniform();
    return low + (high - low).cwiseProduct(Vector2d(x, y));
  }
};

Area read_area(CourseFields& fields, const World& world) {
  const GridGeometry& g = world.ground.geometry;
  Area area{g.centre({0, 0}), g.centre({g.columns - 1, g.rows - 1})};
  const auto entry = fields.find("in_m");
  if (!entry) return area;
  const auto corners = fields.places("in_m", 2);
  if (!fields.good()) return area;
  if (corners.size() != 2) {
    fields.refuse("in_m", ErrorCode::kBadFormat, "an area has two corners",
                  "Write [[x, y], [x, y]]");
    return area;
  }
  area.low = corners[0].cwiseMin(corners[1]).cwiseMax(area.low);
  area.high = corners[0].cwiseMax(corners[1]).cwiseMin(area.high);
  if (((area.high - area.low).array() <= 0.0).any()) {
    fields.refuse("in_m", ErrorCode::kBadValue, "the area is empty or off the ground",
                  "Write two corners of an area on the course");
  }
  return area;
}

struct Growth {
  const char* one;
  const char* many;
  Surface surface;
  double smallest_m, largest_m;  // by default
  double clear_m;                // from the way of the robot, by default
  void (*add)(CourseBuilder&, const Spot&, Random&);
};

constexpr std::array<Growth, 3> kGrowth = {{
    {"rock", "rocks", Surface::kRock, 0.1, 0.4, 0.6, add_rock},
    {"tree", "trees", Surface::kLeaves, 4.0, 7.0, 1.5, add_tree},
    {"shrub", "shrubs", Surface::kLeaves, 0.5, 1.2, 1.0, add_shrub},
}};

// Sizes as [smallest, largest]. Small ones are common and large ones rare, as stones are.
struct Sizes {
  double smallest, largest;
  [[nodiscard]] double draw(Random& random) const {
    const double u = random.uniform();
    return smallest + (largest - smallest) * u * u;
  }
};

Sizes read_sizes(CourseFields& fields, const Growth& growth) {
  Sizes sizes{growth.smallest_m, growth.largest_m};
  if (const auto entry = fields.find("size_m")) {
    const auto pair = fields.place("size_m");
    sizes = {pair.x(), pair.y()};
    if (fields.good() &&
        !(sizes.smallest > 0.0 && sizes.smallest <= sizes.largest && sizes.largest <= 100.0)) {
      fields.refuse("size_m", ErrorCode::kBadValue, "not a range of sizes",
                    "Write [smallest, largest] in metres");
    }
  }
  return sizes;
}

void read_one(const Growth& growth, CourseFields& fields, const std::string& name, Random& random,
              CourseBuilder& builder) {
  const Vector2d at = fields.place("at_m");
  const double size =
      fields.number("size_m", 0.5 * (growth.smallest_m + growth.largest_m), 0.01, 100.0);
  const Material material = builder.material(fields.surface("surface", growth.surface), random);
  if (std::isnan(ground_height(builder.world, at))) {
    fields.refuse("at_m", ErrorCode::kBadValue, "it is off the ground", extent_text(builder.world));
  }
  if (fields.good()) growth.add(builder, {name, at, size, material}, random);
}

void read_many(const Growth& growth, CourseFields& fields, const std::string& name, Random& random,
               CourseBuilder& builder) {
  constexpr int kTries = 30;
  const int count = fields.whole("count", 20, 0, 20'000);
  const Sizes sizes = read_sizes(fields, growth);
  const double clear = fields.number("clear_m", growth.clear_m, 0.0, 1e3);
  const Area area = read_area(fields, builder.world);
  const Surface surface = fields.surface("surface", growth.surface);
  constexpr int kMostTrees = 5000;  // each is some 2000 leaves
  if (growth.add == add_tree && count > kMostTrees) {
    fields.refuse("count", ErrorCode::kTooLarge, fmt::format("{} trees are too many", count),
                  fmt::format("At most {}", kMostTrees));
  }
  if (!fields.good()) return;
  for (int i = 0; i < count; ++i) {
    Random stream = random.stream(static_cast<std::uint64_t>(i));
    const double size = sizes.draw(stream);
    const Material material = builder.material(surface, stream);
    // Where there is no room left there is one less.
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const Vector2d at = area.draw(stream);
      const double radius = growth.add == add_tree ? 0.5 : 0.5 * size;
      if (builder.from_route(at) < clear + radius || !builder.is_free(at, radius)) continue;
      growth.add(builder, {fmt::format("{}[{}]", name, i), at, size, material}, stream);
      break;
    }
  }
}

void read_grass(CourseFields& fields, const std::string& name, Random& random,
                CourseBuilder& builder) {
  const Area area = read_area(fields, builder.world);
  const double height = fields.number("height_m", 0.4, 0.02, 3.0),
               density = fields.number("tufts_per_m2", 60.0, 0.1, 1e4);
  const Material material = builder.material(fields.surface("surface", Surface::kGrass), random);
  if (!fields.good()) return;
  const double tufts = density * (area.high - area.low).prod();
  if (tufts > 4e5) {
    fields.refuse("tufts_per_m2", ErrorCode::kTooLarge,
                  fmt::format("{:.0f} tufts are too many", tufts),
                  "Take a smaller area (in_m) or fewer tufts");
    return;
  }
  Foliage foliage{name, {}, material};
  for (int i = 0; i < static_cast<int>(tufts); ++i) {
    const Vector2d at = area.draw(random);
    if (builder.is_free(at, 0.0)) {
      add_tuft(builder, foliage.mesh, at, height * random.uniform(0.5, 1.1), random);
    }
  }
  builder.world.foliage.push_back(std::move(foliage));
}

}  // namespace

std::vector<std::string> growth_kinds() {
  std::vector<std::string> names{"grass"};
  for (const Growth& growth : kGrowth) {
    names.emplace_back(growth.one);
    names.emplace_back(growth.many);
  }
  return names;
}

Result<bool> read_growth(const std::string& kind, const Field& field, const std::string& name,
                         Random stream, CourseBuilder& builder) {
  CourseFields fields(field);
  const auto read = [&]() -> bool {
    if (kind == "grass") {
      read_grass(fields, name, stream, builder);
      return true;
    }
    for (const Growth& growth : kGrowth) {
      if (kind != growth.one && kind != growth.many) continue;
      (kind == growth.one ? read_one : read_many)(growth, fields, name, stream, builder);
      return true;
    }
    return false;
  };
  if (!read()) return false;
  if (Status s = fields.done(); !s) return forward(s);
  return true;
}

}  // namespace tread::internal
