#include "tread/sim/world_mjcf.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

namespace tread {
namespace {

constexpr double kBaseM = 1.0;         // of ground below its lowest place
constexpr double kLeastRangeM = 0.01;  // MuJoCo wants a field of some height

// People go their way whatever stands in it. Were they hard, they would roll the robot over: so
// they push it with some hundred newtons and, if it stays, pass through.
constexpr const char* kSoft = R"(priority="2" condim="1" solref="0.5 1")";

using Text = fmt::memory_buffer;

template <class... Arguments>
void put(Text& text, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Arguments>(arguments)...);
}

void put_pose(Text& text, const Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  const Eigen::Vector3d& p = T.translation();
  put(text, R"( pos="{} {} {}" quat="{} {} {} {}")", p.x(), p.y(), p.z(), q.w(), q.x(), q.y(),
      q.z());
}

void put_shape(Text& text, const Solid& solid, const std::string& name) {
  const Eigen::Vector3d& h = solid.half_m;
  switch (solid.shape) {
    case Solid::Shape::kBox:
      put(text, R"( type="box" size="{} {} {}")", h.x(), h.y(), h.z());
      break;
    case Solid::Shape::kCylinder:
      put(text, R"( type="cylinder" size="{} {}")", h.x(), h.z());
      break;
    case Solid::Shape::kEllipsoid:
      put(text, R"( type="ellipsoid" size="{} {} {}")", h.x(), h.y(), h.z());
      break;
    case Solid::Shape::kHull:
      put(text, R"( type="mesh" mesh="{}")", name);
      break;
  }
}

void put_hull(Text& text, const World& world, const Solid& solid, const std::string& name) {
  put(text, R"(<mesh name="{}" vertex=")", name);
  for (const Eigen::Vector3f& v : world.hulls[static_cast<std::size_t>(solid.hull)].vertices) {
    const Eigen::Vector3d p = v.cast<double>().cwiseProduct(solid.half_m);
    put(text, "{} {} {} ", p.x(), p.y(), p.z());
  }
  put(text, "\"/>\n");
}

Error bad(std::string what, std::string where, std::string remedy) {
  return {ErrorCode::kBadValue, std::move(what), std::move(where), std::move(remedy)};
}

Status check_ground(const World& world) {
  const GridGeometry& cells = world.ground.geometry;
  const auto wrong = [](std::string what, std::string remedy) {
    return tl::unexpected<Error>(bad(std::move(what), "ground", std::move(remedy)));
  };
  if (cells.columns < 2 || cells.rows < 2 || world.ground.values.size() != cells.size()) {
    return wrong(fmt::format("{} x {} cells span no triangle", cells.columns, cells.rows),
                 "Give the ground at least 2 x 2 cells");
  }
  if (!(cells.resolution_m > 0.0) || !std::isfinite(cells.resolution_m) ||
      !cells.origin.allFinite()) {
    return wrong("its cells have no size or place", "Write a resolution above 0");
  }
  if (!std::all_of(world.ground.values.begin(), world.ground.values.end(),
                   [](float h) { return std::isfinite(h); })) {
    return wrong("a height is not finite", "Fill holes of the height map");
  }
  if (!(world.ground_surface.geometry == cells) ||
      world.ground_surface.values.size() != cells.size()) {
    return wrong("surfaces and heights have different cells", "Give both the same geometry");
  }
  for (const std::uint8_t index : world.ground_surface.values) {
    if (index >= world.ground_materials.size()) {
      return wrong(fmt::format("a cell is of material {}, but there are {}", index,
                               world.ground_materials.size()),
                   "Add the material");
    }
  }
  return {};
}

// MuJoCo's hull finder writes a page to the standard error where there is none.
bool has_volume(const std::vector<Eigen::Vector3f>& vertices) {
  constexpr double kFlat = 1e-4;  // of its longest side
  Eigen::MatrixX3d points(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    points.row(static_cast<Eigen::Index>(i)) = vertices[i].cast<double>();
  }
  if (vertices.size() < 4 || !points.allFinite()) return false;
  const Eigen::RowVector3d middle = points.colwise().mean();
  const Eigen::Vector3d sizes = (points.rowwise() - middle).jacobiSvd().singularValues();
  return sizes.z() > kFlat * sizes.x();
}

Status check_solid(const World& world, const Solid& solid) {
  const auto wrong = [&](std::string what, std::string remedy) {
    return tl::unexpected<Error>(bad(std::move(what), solid.name, std::move(remedy)));
  };
  if (!solid.half_m.allFinite() || !(solid.half_m.minCoeff() > 0.0)) {
    return wrong("it has no size", "Make every side longer than 0");
  }
  if (solid.half_m.maxCoeff() > 1e5) return wrong("it is larger than any world", "Use metres");
  if (!is_rigid(solid.T_world_solid, 1e-6)) {
    return wrong("its pose is not a rotation and a place", "Check its angles and position");
  }
  if (solid.shape == Solid::Shape::kCylinder &&
      std::abs(solid.half_m.x() - solid.half_m.y()) > 1e-9 * solid.half_m.x()) {
    return wrong("cylinders are round, but its two radii differ", "Write the same radius twice");
  }
  if (solid.shape != Solid::Shape::kHull) return {};
  if (solid.hull < 0 || static_cast<std::size_t>(solid.hull) >= world.hulls.size()) {
    return wrong(fmt::format("there is no hull {}", solid.hull), "Use one of the world's hulls");
  }
  const auto& vertices = world.hulls[static_cast<std::size_t>(solid.hull)].vertices;
  if (!has_volume(vertices)) {
    return wrong(fmt::format("its hull {} has no volume", solid.hull),
                 "Give hulls four corners or more");
  }
  return {};
}

Status check_person(const Person& person) {
  const bool line = person.path_m.size() >= 2 &&
                    std::all_of(person.path_m.begin(), person.path_m.end(),
                                [](const Eigen::Vector2d& p) { return p.allFinite(); });
  const bool size = person.height_m > 0.0 && std::isfinite(person.height_m);
  if (line && size && std::isfinite(person.speed_m_per_s) && std::isfinite(person.ahead_s)) {
    return {};
  }
  return tl::unexpected<Error>(bad(size ? "it has no way to walk" : "it has no height", person.name,
                                   "Give people a height and a path of two places or more"));
}

void put_ground(Text& text, const World& world) {
  const GroundField field = ground_field(world);
  const GridGeometry& cells = world.ground.geometry;
  const double half_x = 0.5 * cells.resolution_m * (field.columns - 1),
               half_y = 0.5 * cells.resolution_m * (field.rows - 1);
  put(text,
      "<asset><hfield name=\"ground\" nrow=\"{}\" ncol=\"{}\" size=\"{} {} {} {}\"/></asset>\n",
      field.rows, field.columns, half_x, half_y, field.range_m, kBaseM);
  const Eigen::Vector2d middle =
      0.5 * (cells.centre({0, 0}) + cells.centre({cells.columns - 1, cells.rows - 1}));
  Isometry3d T_world_field = Isometry3d::Identity();
  T_world_field.translation() << middle, field.low_m;
  T_world_field.linear() << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  put(text, "<worldbody><geom name=\"ground\" type=\"hfield\" hfield=\"ground\"");
  put_pose(text, T_world_field);
  put(text, " friction=\"{}\"/></worldbody>\n",
      friction_attribute(footing_of(world.ground_materials.front().surface)));
}

void put_solid(Text& text, const Solid& solid, int number) {
  const std::string name = fmt::format("solid_{}", number);
  put(text, "<geom name=\"{}\"", name);
  put_shape(text, solid, name);
  put_pose(text, solid.T_world_solid);
  put(text, " friction=\"{}\"/>\n", friction_attribute(footing_of(solid.material.surface)));
}

// MuJoCo compares the robot with every geom of a body that it may touch, so solids that lie
// together make a body each: halved along the longer side until few are left.
void split(const World& world, std::span<int> solids, std::vector<std::span<const int>>& patches) {
  constexpr std::size_t kFew = 16;
  if (solids.size() <= kFew) {
    if (!solids.empty()) patches.push_back(solids);
    return;
  }
  const auto place = [&](int i) -> Eigen::Vector2d {
    return world.solids[static_cast<std::size_t>(i)].T_world_solid.translation().head<2>();
  };
  Eigen::AlignedBox2d box;
  for (const int i : solids) box.extend(place(i));
  const int axis = box.sizes().x() >= box.sizes().y() ? 0 : 1;
  std::sort(solids.begin(), solids.end(), [&](int a, int b) {
    return std::pair(place(a)(axis), a) < std::pair(place(b)(axis), b);
  });
  split(world, solids.first(solids.size() / 2), patches);
  split(world, solids.subspan(solids.size() / 2), patches);
}

void put_solids(Text& text, const World& world) {
  put(text, "<asset>\n");
  for (std::size_t i = 0; i < world.solids.size(); ++i) {
    if (world.solids[i].shape == Solid::Shape::kHull) {
      put_hull(text, world, world.solids[i], fmt::format("solid_{}", i));
    }
  }
  put(text, "</asset>\n<worldbody>\n");
  std::vector<int> all(world.solids.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<std::span<const int>> patches;
  split(world, all, patches);
  for (const std::span<const int> patch : patches) {
    put(text, "<body>\n");
    for (const int i : patch) put_solid(text, world.solids[static_cast<std::size_t>(i)], i);
    put(text, "</body>\n");
  }
  put(text, "</worldbody>\n");
}

void put_people(Text& text, const World& world) {
  put(text, "<worldbody>\n");
  for (std::size_t i = 0; i < world.people.size(); ++i) {
    const std::vector<Solid> parts = person_parts(world.people[i]);
    const std::vector<Isometry3d> poses = person_pose(world, world.people[i], 0.0);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      put(text, "<body name=\"person_{}_{}\" mocap=\"true\"", i, k);
      put_pose(text, poses[k]);
      put(text, "><geom name=\"person_{}_{}\"", i, k);
      put_shape(text, parts[k], "");
      put(text, " {}/></body>\n", kSoft);
    }
  }
  put(text, "</worldbody>\n");
}

}  // namespace

Status check_for_physics(const World& world) {
  if (Status ground = check_ground(world); !ground) return ground;
  for (const Solid& solid : world.solids) {
    if (Status good = check_solid(world, solid); !good) return good;
  }
  for (const Person& person : world.people) {
    if (Status good = check_person(person); !good) return good;
  }
  return {};
}

std::string world_mjcf(const World& world, const RobotMjcf& robot) {
  Text text;
  put(text, "<mujoco model=\"tread\">\n{}\n", robot.settings);
  put(text, "<asset>{}</asset>\n<worldbody>{}</worldbody>\n", robot.assets, robot.bodies);
  put_ground(text, world);
  put_solids(text, world);
  put_people(text, world);
  put(text, "</mujoco>\n");
  return fmt::to_string(text);
}

GroundField ground_field(const World& world) {
  const GridGeometry& cells = world.ground.geometry;
  const auto [low, high] =
      std::minmax_element(world.ground.values.begin(), world.ground.values.end());
  GroundField field;
  field.rows = cells.columns;
  field.columns = cells.rows;
  field.low_m = static_cast<double>(*low);
  field.range_m = std::max(static_cast<double>(*high) - field.low_m, kLeastRangeM);
  field.data.reserve(cells.size());
  for (int x = cells.columns - 1; x >= 0; --x) {
    for (int y = 0; y < cells.rows; ++y) {
      const double above = static_cast<double>(world.ground[{x, y}]) - field.low_m;
      field.data.push_back(static_cast<float>(above / field.range_m));
    }
  }
  return field;
}

std::string friction_attribute(const Footing& footing) {
  return fmt::format("{} 0.005 0.0001", footing.friction);
}

}  // namespace tread
