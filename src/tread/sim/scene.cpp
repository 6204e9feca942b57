#include "tread/sim/scene.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "tread/sim/ground_kernel.hpp"
#include "tread/sim/ground_surface.hpp"
#include "tread/sim/ray_tracer.hpp"
#include "tread/sim/solid_set.hpp"
#include "tread/sim/texture.hpp"
#include "tread/sim/world_check.hpp"

namespace tread {
namespace {

// Ids of the shapes in the tracer; solids and people take several.
constexpr std::uint32_t kGroundId = 0, kFoliageId = 1, kSolidId = 2,
                        kPersonId = kSolidId + SolidSet::kIds;
constexpr std::uint32_t kBears = 1, kFoliage = 2;  // masks
constexpr float kFarthest = 1e6F;                  // m

std::uint32_t mask_of(RaysMeet meet) {
  return meet == RaysMeet::kWhatBears ? kBears : kBears | kFoliage;
}

// What a ray met, in scene axes.
struct Spot {
  HitKind kind = HitKind::kNothing;
  int index = 0;  // of the world's list; of people: which part of all
  double distance = 0.0;
  // Axes of the solid; else of the scene.
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // likewise, unit length, of the flat triangle
};

}  // namespace

struct Scene::Parts {
  std::shared_ptr<const World> world;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // of the scene, in the world
  Eigen::Vector3d sun = Eigen::Vector3d::Zero();
  RayTracer tracer;
  GroundSurface ground;
  SolidSet solids;
  SolidSet people;
  std::vector<int> part_person;          // whose part it is
  std::vector<int> foliage_of_triangle;  // of all foliage, one mesh after the other
  std::vector<int> first_triangle;       // of each foliage
  std::vector<Material> materials;       // ground, solids, foliage, parts of people
  int solid_material = 0, foliage_material = 0, person_material = 0;  // the first of each

  explicit Parts(std::shared_ptr<const World> of)
      : world(std::move(of)), solids(&world->hulls), people(&world->hulls) {}

  [[nodiscard]] Status build();
  void add_foliage();
  void add_people();
  void place_people(double time_s);
  [[nodiscard]] Spot spot(std::uint32_t id, std::uint32_t part, double rough,
                          const Eigen::Vector3d& o, const Eigen::Vector3d& d) const;
  [[nodiscard]] Spot foliage_spot(std::uint32_t part, const Eigen::Vector3d& o,
                                  const Eigen::Vector3d& d) const;
  void load(const RayBatch& rays, int first, RayBlock& block) const;
  void finish(const RayBatch& rays, int first, RayBlock& block, SurfaceBatch& points) const;
  void fill(const Spot& spot, const Eigen::Vector3d& o, const Eigen::Vector3d& d, float spread,
            SurfaceBatch& points, std::size_t i) const;
};

Status Scene::Parts::build() {
  const GridGeometry& cells = world->ground.geometry;
  const Eigen::Vector2d middle =
      cells.origin + 0.5 * cells.resolution_m * Eigen::Vector2d(cells.columns, cells.rows);
  centre << middle.array().round(), 0.0;
  if (world->sun.elevation_rad > 0.0 && world->sun.strength > 0.0) {
    const double up = world->sun.elevation_rad, around = world->sun.azimuth_rad;
    sun << std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up);
  }
  ground = GroundSurface(*world, centre.head<2>());
  ground.give_to(tracer, RayTracer::kStill, kGroundId, kBears);
  materials = world->ground_materials;
  solid_material = static_cast<int>(materials.size());
  for (const Solid& solid : world->solids) {
    solids.add(solid, Eigen::Translation3d(-centre) * solid.T_world_solid);
    materials.push_back(solid.material);
  }
  solids.give_to(tracer, RayTracer::kStill, kSolidId, kBears);
  add_foliage();
  add_people();
  return tracer.commit(RayTracer::kStill);
}

void Scene::Parts::add_foliage() {
  foliage_material = static_cast<int>(materials.size());
  RayTracer::Vertices vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::size_t i = 0; i < world->foliage.size(); ++i) {
    const Mesh& mesh = world->foliage[i].mesh;
    const auto first = static_cast<std::uint32_t>(vertices.size());
    first_triangle.push_back(static_cast<int>(triangles.size()));
    for (const Eigen::Vector3f& v : mesh.vertices) {
      vertices.push_back((v.cast<double>() - centre).cast<float>());
    }
    for (const auto& [a, b, c] : mesh.triangles) {
      triangles.push_back({first + static_cast<std::uint32_t>(a),
                           first + static_cast<std::uint32_t>(b),
                           first + static_cast<std::uint32_t>(c)});
      foliage_of_triangle.push_back(static_cast<int>(i));
    }
    materials.push_back(world->foliage[i].material);
  }
  tracer.add_triangles(RayTracer::kStill, kFoliageId, kFoliage, vertices, triangles);
}

void Scene::Parts::add_people() {
  person_material = static_cast<int>(materials.size());
  for (std::size_t i = 0; i < world->people.size(); ++i) {
    for (const Solid& part : person_parts(world->people[i])) {
      people.add(part, part.T_world_solid);
      part_person.push_back(static_cast<int>(i));
      materials.push_back(part.material);
    }
  }
}

void Scene::Parts::place_people(double time_s) {
  if (people.count() == 0) return;
  int part = 0;
  for (const Person& person : world->people) {
    for (const Isometry3d& T_world_part : person_pose(*world, person, time_s)) {
      people.move(part++, Eigen::Translation3d(-centre) * T_world_part);
    }
  }
  tracer.clear(RayTracer::kMoving);
  people.give_to(tracer, RayTracer::kMoving, kPersonId, kBears);
}

Spot Scene::Parts::foliage_spot(std::uint32_t part, const Eigen::Vector3d& o,
                                const Eigen::Vector3d& d) const {
  Spot spot;
  spot.kind = HitKind::kFoliage;
  spot.index = foliage_of_triangle[part];
  const auto at = static_cast<std::size_t>(spot.index);
  const Mesh& mesh = world->foliage[at].mesh;
  const auto& triangle =
      mesh.triangles[static_cast<std::size_t>(static_cast<int>(part) - first_triangle[at])];
  const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
    return mesh.vertices[static_cast<std::size_t>(triangle[i])].cast<double>() - centre;
  };
  const Eigen::Vector3d a = corner(0);
  spot.normal = (corner(1) - a).cross(corner(2) - a).normalized();
  const double towards = spot.normal.dot(d);
  spot.distance = spot.normal.dot(a - o) / towards;
  if (towards > 0.0) spot.normal = -spot.normal;
  return spot;
}

// `rough` is the distance as the tracer has it, and what is kept where nothing better can be said.
Spot Scene::Parts::spot(std::uint32_t id, std::uint32_t part, double rough,
                        const Eigen::Vector3d& o, const Eigen::Vector3d& d) const {
  Spot spot;
  if (id == RayBlock::kMissed) return spot;
  if (id == kGroundId) {
    const GroundSurface::Hit hit = ground.hit(part, o, d, rough);
    spot = {HitKind::kGround, 0, hit.distance, spot.point, hit.normal};
  } else if (id == kFoliageId) {
    spot = foliage_spot(part, o, d);
  } else {
    const bool person = id >= kPersonId;
    const SolidSet& set = person ? people : solids;
    const auto hit = set.hit(id - (person ? kPersonId : kSolidId), part, o, d);
    // The edge of a thing, where the ray just misses what the tracer met: as if it were not there.
    if (!hit) return spot;
    spot = {person ? HitKind::kPerson : HitKind::kSolid, hit->solid, hit->distance, hit->point,
            hit->normal};
  }
  if (!(std::abs(spot.distance - rough) < 1e-3 + 1e-3 * rough)) spot.distance = rough;
  if (id == kGroundId || id == kFoliageId) spot.point = o + spot.distance * d;
  return spot;
}

void Scene::Parts::fill(const Spot& spot, const Eigen::Vector3d& o, const Eigen::Vector3d& d,
                        float spread, SurfaceBatch& points, std::size_t i) const {
  Eigen::Vector3d flat = spot.normal;
  TexturePlace at{spot.point, sun};
  switch (spot.kind) {
    case HitKind::kNothing:
    case HitKind::kGround:
      return;
    case HitKind::kFoliage:
      points.material[i] = foliage_material + spot.index;
      break;
    case HitKind::kSolid:
    case HitKind::kPerson: {
      const bool person = spot.kind == HitKind::kPerson;
      const Isometry3d& T = (person ? people : solids).pose(spot.index);
      points.material[i] = (person ? person_material : solid_material) + spot.index;
      const Material& material = materials[static_cast<std::size_t>(points.material[i])];
      const Eigen::Vector3d sides =
          person ? Eigen::Vector3d::Ones()
                 : world->solids[static_cast<std::size_t>(spot.index)].half_m;
      at = texture_place(material.surface, sides, spot.point, spot.normal,
                         T.linear().transpose() * sun);
      flat = T.linear() * spot.normal;
      break;
    }
  }
  const Eigen::Vector3d point = o + spot.distance * d;
  const double facing = -flat.dot(d);
  points.distance_m[i] = spot.distance;
  points.u[i] = static_cast<float>(at.place.x());
  points.v[i] = static_cast<float>(at.place.y());
  points.w[i] = static_cast<float>(at.place.z());
  points.sun_u[i] = static_cast<float>(at.sun.x());
  points.sun_v[i] = static_cast<float>(at.sun.y());
  points.sun_w[i] = static_cast<float>(at.sun.z());
  points.footprint_m[i] = spread * static_cast<float>(spot.distance) /
                          std::sqrt(std::max(static_cast<float>(std::abs(facing)), kGrazing));
  points.normal_x[i] = static_cast<float>(flat.x());
  points.normal_y[i] = static_cast<float>(flat.y());
  points.normal_z[i] = static_cast<float>(flat.z());
  // Off the surface, on the side it is seen from, by more than single precision may be wrong.
  // Leaves are lit from either side.
  const bool leaf = spot.kind == HitKind::kFoliage;
  const bool turned = leaf ? flat.dot(sun) < 0.0 : facing < 0.0;
  const double off = (static_cast<double>(kOffM) + static_cast<double>(kOffShare) * point.norm()) *
                     (turned ? -1.0 : 1.0);
  for (int axis = 0; axis < 3; ++axis) {
    points.from[static_cast<std::size_t>(axis)][i] =
        static_cast<float>(point(axis) + off * flat(axis));
  }
  points.clear_m[i] = 0.0F;
  points.through[i] = leaf ? 0.5F : 0.0F;
}

void Scene::Parts::load(const RayBatch& rays, int first, RayBlock& block) const {
  const auto from = static_cast<std::size_t>(first);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double middle = centre(static_cast<Eigen::Index>(axis));
    for (std::size_t i = 0; i < RayBlock::kRays; ++i) {
      block.origin[axis][i] = static_cast<float>(rays.origin[axis][from + i] - middle);
      block.direction[axis][i] = static_cast<float>(rays.direction[axis][from + i]);
    }
  }
  for (std::size_t i = 0; i < RayBlock::kRays; ++i) {
    block.on[i] = rays.spread_rad[from + i] >= 0.0F ? -1 : 0;
  }
  block.nearest.fill(0.0F);
  block.distance.fill(kFarthest);
}

// What a block of rays met: ground all at once, all else one by one.
void Scene::Parts::finish(const RayBatch& rays, int first, RayBlock& block,
                          SurfaceBatch& points) const {
  int on_ground = 0;
  for (std::size_t i = 0; i < RayBlock::kRays; ++i) {
    if (block.on[i] == 0) block.id[i] = RayBlock::kMissed;
    on_ground += block.id[i] == kGroundId ? 1 : 0;
  }
  if (on_ground > 0) {
    RayBlock::Row<std::uint32_t> square;
    for (std::size_t i = 0; i < RayBlock::kRays; ++i) {
      square[i] = block.id[i] == kGroundId ? block.part[i] : 0U;
    }
    meet_ground(ground.view(), rays, centre, sun, first, square.data(), block.distance.data(),
                points);
  }
  if (on_ground == RayBlock::kRays) return;
  for (std::size_t i = 0; i < RayBlock::kRays; ++i) {
    if (block.id[i] == kGroundId) continue;
    const std::size_t at = static_cast<std::size_t>(first) + i;
    points.distance_m[at] = std::numeric_limits<double>::quiet_NaN();
    points.material[at] = -1;
    points.normal_x[at] = points.normal_y[at] = points.normal_z[at] = 0.0F;
    points.through[at] = 0.0F;
    if (block.id[i] == RayBlock::kMissed) continue;
    const Eigen::Vector3d o =
        Eigen::Vector3d(rays.origin[0][at], rays.origin[1][at], rays.origin[2][at]) - centre;
    const Eigen::Vector3d d(rays.direction[0][at], rays.direction[1][at], rays.direction[2][at]);
    const double rough = static_cast<double>(block.distance[i]);
    fill(spot(block.id[i], block.part[i], rough, o, d), o, d, rays.spread_rad[at], points, at);
  }
}

Scene::Scene(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;
Scene::~Scene() = default;

Result<Scene> Scene::make(std::shared_ptr<const World> world) {
  if (world == nullptr) {
    return fail(ErrorCode::kBadArgument, "there is no world", "world", "Make one first");
  }
  if (Status sound = check_world(*world); !sound) return forward(sound);
  return with_memory_checked("world", "Make the ground smaller or coarser", [&]() -> Result<Scene> {
    auto parts = std::make_unique<Parts>(std::move(world));
    if (Status built = parts->build(); !built) return forward(built);
    parts->place_people(0.0);
    if (Status built = parts->tracer.commit(RayTracer::kMoving); !built) return forward(built);
    return Scene(std::move(parts));
  });
}

const World& Scene::world() const {
  return *parts_->world;
}
const std::vector<Material>& Scene::materials() const {
  return parts_->materials;
}
const Eigen::Vector3d& Scene::sun_direction() const {
  return parts_->sun;
}

void Scene::set_time(double time_s) {
  parts_->place_people(time_s);
  // As many shapes as before: the memory that make() had is enough.
  (void)parts_->tracer.commit(RayTracer::kMoving);
}

RayHit Scene::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                   RaysMeet meet) const {
  const double length = direction.norm();
  if (!(length > 0.0) || !std::isfinite(length) || !origin.allFinite()) return {};
  const Eigen::Vector3d o = origin - parts_->centre, d = direction / length;
  RayBlock block{};
  for (int axis = 0; axis < 3; ++axis) {
    block.origin[axis][0] = static_cast<float>(o(axis));
    block.direction[axis][0] = static_cast<float>(d(axis));
  }
  block.distance[0] = kFarthest;
  block.on[0] = -1;
  parts_->tracer.cast(block, mask_of(meet));
  const Spot spot =
      parts_->spot(block.id[0], block.part[0], static_cast<double>(block.distance[0]), o, d);
  RayHit hit{spot.kind, spot.index, spot.distance, spot.normal};
  if (spot.kind == HitKind::kNothing) return {};
  if (spot.kind == HitKind::kSolid)
    hit.normal = parts_->solids.pose(spot.index).linear() * spot.normal;
  if (spot.kind == HitKind::kPerson) {
    hit.normal = parts_->people.pose(spot.index).linear() * spot.normal;
    hit.index = parts_->part_person[static_cast<std::size_t>(spot.index)];
  }
  return hit;
}

bool Scene::blocked(const Eigen::Vector3d& from, const Eigen::Vector3d& to, RaysMeet meet) const {
  const double length = (to - from).norm();
  if (!(length > 0.0)) return false;
  const RayHit hit = cast(from, to - from, meet);
  return hit.distance_m < length;
}

void Scene::cast(const RayBatch& rays, SurfaceBatch& points) const {
  points.count = rays.count;
  for (int first = 0; first < rays.count; first += RayBlock::kRays) {
    RayBlock block;
    parts_->load(rays, first, block);
    parts_->tracer.cast(block, kBears | kFoliage);
    parts_->finish(rays, first, block, points);
  }
}

void Scene::light(const SurfaceBatch& points, SurfaceBatch::Row<float>& lit) const {
  const Eigen::Vector3f sun = parts_->sun.cast<float>();
  for (int first = 0; first < points.count; first += RayBlock::kRays) {
    RayBlock block;
    bool any = false;
    for (std::size_t i = 0; i < RayBlock::kRays; ++i) {
      const std::size_t at = static_cast<std::size_t>(first) + i;
      lit[at] = 0.0F;
      // What is turned away from the sun needs no shadow to be dark.
      const float facing = points.normal_x[at] * sun.x() + points.normal_y[at] * sun.y() +
                           points.normal_z[at] * sun.z();
      const bool seen = points.material[at] >= 0 && (facing > 0.0F || points.through[at] > 0.0F) &&
                        !sun.isZero(0.0F);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        block.origin[axis][i] = seen ? points.from[axis][at] : 0.0F;
        block.direction[axis][i] = sun(static_cast<Eigen::Index>(axis));
      }
      block.nearest[i] = seen ? points.clear_m[at] : 0.0F;
      block.distance[i] = kFarthest;
      block.on[i] = seen ? -1 : 0;
      any = any || seen;
    }
    if (!any) continue;
    parts_->tracer.test(block, kBears | kFoliage);
    for (std::size_t i = 0; i < RayBlock::kRays; ++i) {
      if (block.on[i] != 0 && block.id[i] == RayBlock::kMissed) {
        lit[static_cast<std::size_t>(first) + i] = 1.0F;
      }
    }
  }
}

}  // namespace tread
