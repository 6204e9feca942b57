#include "tread/sim/course.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "tread/io/atomic_file.hpp"
#include "tread/sim/course_builder.hpp"
#include "tread/sim/relief.hpp"

namespace tread {
namespace internal {
namespace {

constexpr int kVersion = 1;
constexpr std::size_t kMostBytes = std::size_t{1} << 20;
constexpr double kMostCells = 2.5e7;
constexpr std::size_t kMostTriangles = 20'000'000;

void read_area(CourseFields& fields, CourseBuilder& builder) {
  GridGeometry& geometry = builder.world.ground.geometry;
  const Eigen::Vector2d size = fields.place("size_m");
  geometry.origin = fields.place("origin_m", -0.5 * size);
  geometry.resolution_m = fields.number("resolution_m", 0.05, 0.005, 5.0);
  if (!fields.good()) return;
  // Corners of triangles are centres of cells: one more of them than steps, half a cell outside.
  const Eigen::Vector2d cells = (size / geometry.resolution_m).array().round() + 1.0;
  if (cells.minCoeff() < 3.0) {
    fields.refuse("size_m", ErrorCode::kBadValue, "the course has no area",
                  "Write its sides along x and y in metres, at least two cells of resolution_m");
  } else if (cells.prod() > kMostCells) {
    fields.refuse("size_m", ErrorCode::kTooLarge,
                  fmt::format("{:.0f} cells are too many", cells.prod()),
                  "Make the course smaller or resolution_m larger");
  } else {
    geometry.columns = static_cast<int>(cells.x());
    geometry.rows = static_cast<int>(cells.y());
    geometry.origin.array() -= 0.5 * geometry.resolution_m;
  }
}

Status read_sun(const Field& field, World& world) {
  CourseFields fields(field);
  world.sun.azimuth_rad = fields.angle("azimuth_deg", 45.0, -360.0, 360.0);
  world.sun.elevation_rad = fields.angle("elevation_deg", 50.0, -90.0, 90.0);
  world.sun.strength = fields.number("strength", world.sun.strength, 0.0, 2.0);
  world.sun.sky = fields.number("sky", world.sun.sky, 0.0, 2.0);
  return fields.done();
}

Status read_start(const Field& field, World& world) {
  CourseFields fields(field);
  world.start.position_m = fields.place("at_m");
  world.start.yaw_rad = fields.angle("yaw_deg", 0.0, -360.0, 360.0);
  return fields.done();
}

}  // namespace

std::string extent_text(const World& world) {
  const GridGeometry& g = world.ground.geometry;
  const Eigen::Vector2d low = g.centre({0, 0}), high = g.centre({g.columns - 1, g.rows - 1});
  return fmt::format("The ground is from [{:.6g}, {:.6g}] to [{:.6g}, {:.6g}]", low.x(), low.y(),
                     high.x(), high.y());
}

namespace {

void check_places(CourseFields& fields, const World& world) {
  const auto outside = [&](const Eigen::Vector2d& p) {
    return std::isnan(ground_height(world, p));
  };
  const auto refuse = [&](const char* key) {
    fields.refuse(key, ErrorCode::kBadValue, "it is off the ground", extent_text(world));
  };
  if (outside(world.start.position_m)) refuse("start");
  for (const Eigen::Vector2d& p : world.route_m) {
    if (outside(p)) refuse("route_m");
  }
  if (outside(world.goal_m)) refuse("goal_m");
}

Status read_objects(const Field& field, CourseBuilder& builder) {
  const auto items = field.items();
  if (!items) return forward(items);
  for (const Field& item : *items) {
    if (Status s = read_object(item, builder); !s) return s;
    std::size_t triangles = 0;
    for (const Foliage& foliage : builder.world.foliage) triangles += foliage.mesh.triangles.size();
    if (triangles > kMostTriangles) {
      return item.error(ErrorCode::kTooLarge, fmt::format("{} leaves are too many", triangles),
                        "Take fewer plants, or a smaller area");
    }
  }
  return {};
}

Status read_faults(const Field& field, std::vector<Fault>& faults) {
  constexpr int kMostHeads = 2;
  const auto items = field.items();
  if (!items) return forward(items);
  for (const Field& item : *items) {
    CourseFields fields(item);
    Fault fault;
    fault.sensor = sensor_names(kMostHeads)[fields.choice("sensor", sensor_names(kMostHeads), 0)];
    const auto kind = fields.choice("kind", fault_kind_names(), 0);
    fault.kind = *fault_kind_named(fault_kind_names()[kind]);
    fault.from_s = fields.number("from_s", 0.0, 0.0, 1e6);
    fault.until_s = fields.number("until_s", std::numeric_limits<double>::infinity(), 0.0, 1e6);
    fault.amount = fields.number("amount", 0.0, -1e6, 1e6);
    if (Status s = fields.done(); !s) return s;
    if (Status s = check_faults(std::span(&fault, 1), kMostHeads); !s) {
      return item.error(s.error().code, s.error().what, s.error().remedy);
    }
    faults.push_back(std::move(fault));
  }
  return {};
}

Result<Course> read_course(const Field& root, const std::string& stem,
                           std::optional<std::uint64_t> seed) {
  CourseFields fields(root);
  const int version = fields.whole("tread_course", 0, 0, 1'000'000);
  if (fields.good() && version != kVersion) {
    fields.refuse("tread_course", version == 0 ? ErrorCode::kBadFormat : ErrorCode::kUnsupported,
                  version == 0 ? "this is not a course" : fmt::format("version {}", version),
                  fmt::format("A course has the entry 'tread_course: {}'", kVersion));
  }
  CourseBuilder builder;
  World& world = builder.world;
  world.name = fields.text("name", stem);
  world.seed = static_cast<std::uint64_t>(fields.whole("seed", 1, 0, 2'000'000'000));
  if (seed) world.seed = *seed;
  builder.random = Random(world.seed).stream(world.name);
  builder.season =
      static_cast<Season>(fields.choice("season", {"spring", "summer", "autumn", "winter"}, 1));
  read_area(fields, builder);
  const auto sun = fields.find("sun"), start = fields.find("start"), ground = fields.find("ground"),
             objects = fields.find("objects"), faults = fields.find("faults");
  world.route_m = fields.places("route_m", 0);
  if (sun && fields.good()) {
    if (Status s = read_sun(*sun, world); !s) return forward(s);
  }
  if (start && fields.good()) {
    if (Status s = read_start(*start, world); !s) return forward(s);
  }
  world.goal_m =
      fields.place("goal_m", world.route_m.empty() ? world.start.position_m : world.route_m.back());
  if (Status s = fields.done(); !s) return forward(s);
  // A course without the entry has flat soil.
  const TextNode nothing{TextNode::Kind::kMap, 0, {}, {}, {}};
  if (Status s = read_ground(ground ? *ground : Field(nothing, root.file()), builder); !s) {
    return forward(s);
  }
  if (objects) {
    if (Status s = read_objects(*objects, builder); !s) return forward(s);
  }
  check_places(fields, world);
  if (Status s = fields.done(); !s) return forward(s);
  Course course;
  if (faults) {
    if (Status s = read_faults(*faults, course.faults); !s) return forward(s);
  }
  course.world = std::make_shared<const World>(std::move(world));
  return course;
}

}  // namespace

bool CourseBuilder::is_free(const Eigen::Vector2d& middle, double radius_m) const {
  for (const Disc& disc : taken) {
    if ((disc.middle - middle).norm() < disc.radius_m + radius_m) return false;
  }
  return true;
}

double CourseBuilder::from_route(const Eigen::Vector2d& place) const {
  return nearest_on_line(way_of(world), place).distance_m;
}

double CourseBuilder::height(const Eigen::Vector2d& place) const {
  const GridGeometry& g = world.ground.geometry;
  const Eigen::Vector2d low = g.centre({0, 0}), high = g.centre({g.columns - 1, g.rows - 1});
  return ground_height(world, place.cwiseMax(low).cwiseMin(high));
}

}  // namespace internal

Result<Course> parse_course(const std::string& text, const std::filesystem::path& file,
                            std::optional<std::uint64_t> seed) {
  const auto tree = internal::parse_yaml(text, file.string());
  if (!tree) return forward(tree);
  return with_memory_checked(file.string(), "Make the course smaller", [&] {
    return internal::read_course(internal::Field(*tree, file.string()), file.stem().string(), seed);
  });
}

Result<Course> read_course(const std::filesystem::path& path, std::optional<std::uint64_t> seed) {
  const auto text = read_file(path, internal::kMostBytes);
  if (!text) return forward(text);
  return parse_course(*text, path, seed);
}

}  // namespace tread
