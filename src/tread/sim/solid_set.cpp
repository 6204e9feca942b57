#include "tread/sim/solid_set.hpp"

#include <cmath>
#include <utility>

namespace tread {
namespace {

constexpr std::uint32_t kBoxId = 0, kHullId = 1, kRoundId = 2;

// The corners of a box by the bits of their number: 1 for the upper side along x, 2 y, 4 z. Faces
// in the order -x +x -y +y -z +z.
constexpr std::array<std::array<std::uint32_t, 4>, 6> kBoxFaces = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

}  // namespace

void SolidSet::add(const Solid& solid, const Isometry3d& T_scene_solid) {
  const int index = count();
  placed_.push_back({solid.shape, T_scene_solid, solid.half_m, solid.hull});
  switch (solid.shape) {
    case Solid::Shape::kBox:
      boxes_.push_back(index);
      break;
    case Solid::Shape::kCylinder:
    case Solid::Shape::kEllipsoid:
      rounds_.push_back(index);
      break;
    case Solid::Shape::kHull: {
      const auto triangles = (*hulls_)[static_cast<std::size_t>(solid.hull)].triangles.size();
      for (int i = 0; i < static_cast<int>(triangles); ++i) hull_parts_.push_back({index, i});
      break;
    }
  }
}

void SolidSet::move(int solid, const Isometry3d& T_scene_solid) {
  placed_[static_cast<std::size_t>(solid)].T_scene_solid = T_scene_solid;
}

RoundShape SolidSet::round(int solid) const {
  const Placed& placed = placed_[static_cast<std::size_t>(solid)];
  return {placed.shape == Solid::Shape::kCylinder, placed.T_scene_solid.linear(),
          placed.T_scene_solid.translation(), placed.half_m};
}

std::array<Eigen::Vector3d, 3> SolidSet::corners(const HullPart& part) const {
  const Placed& placed = placed_[static_cast<std::size_t>(part.solid)];
  const Mesh& hull = (*hulls_)[static_cast<std::size_t>(placed.hull)];
  std::array<Eigen::Vector3d, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int32_t vertex = hull.triangles[static_cast<std::size_t>(part.triangle)][i];
    corners[i] =
        hull.vertices[static_cast<std::size_t>(vertex)].cast<double>().cwiseProduct(placed.half_m);
  }
  return corners;
}

void SolidSet::give_to(RayTracer& tracer, RayTracer::Layer layer, std::uint32_t first_id,
                       std::uint32_t mask) const {
  RayTracer::Vertices vertices;
  std::vector<std::array<std::uint32_t, 4>> quads;
  for (const int index : boxes_) {
    const Placed& box = placed_[static_cast<std::size_t>(index)];
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d side((corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0,
                                 (corner & 4) != 0 ? 1.0 : -1.0);
      vertices.push_back((box.T_scene_solid * side.cwiseProduct(box.half_m)).cast<float>());
    }
    for (const auto& face : kBoxFaces) {
      quads.push_back({first + face[0], first + face[1], first + face[2], first + face[3]});
    }
  }
  tracer.add_quads(layer, first_id + kBoxId, mask, vertices, quads);

  vertices.clear();
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (const HullPart& part : hull_parts_) {
    const Isometry3d& T = placed_[static_cast<std::size_t>(part.solid)].T_scene_solid;
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (const Eigen::Vector3d& corner : corners(part)) {
      vertices.push_back((T * corner).cast<float>());
    }
    triangles.push_back({first, first + 1, first + 2});
  }
  tracer.add_triangles(layer, first_id + kHullId, mask, vertices, triangles);

  std::vector<RoundShape> shapes;
  for (const int index : rounds_) shapes.push_back(round(index));
  tracer.add_rounds(layer, first_id + kRoundId, mask, std::move(shapes));
}

std::optional<SolidHit> SolidSet::meet_face(const Placed& placed, const Eigen::Vector3d& a,
                                            const Eigen::Vector3d& normal,
                                            const Eigen::Vector3d& origin,
                                            const Eigen::Vector3d& direction) const {
  const Eigen::Matrix3d R_solid_scene = placed.T_scene_solid.linear().transpose();
  const Eigen::Vector3d o = R_solid_scene * (origin - placed.T_scene_solid.translation()),
                        d = R_solid_scene * direction;
  const double towards = normal.dot(d);
  if (std::abs(towards) < 1e-12) return std::nullopt;
  const double t = normal.dot(a - o) / towards;
  return SolidHit{0, t, o + t * d, normal};
}

std::optional<SolidHit> SolidSet::hit(std::uint32_t id_from_first, std::uint32_t part,
                                      const Eigen::Vector3d& origin,
                                      const Eigen::Vector3d& direction) const {
  std::optional<SolidHit> result;
  int index = 0;
  if (id_from_first == kBoxId) {
    index = boxes_[part / 6];
    const Placed& box = placed_[static_cast<std::size_t>(index)];
    const Eigen::Vector3d normal =
        (part % 2 == 0 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(part % 6 / 2);
    result = meet_face(box, normal.cwiseProduct(box.half_m), normal, origin, direction);
  } else if (id_from_first == kHullId) {
    const HullPart& hull_part = hull_parts_[part];
    index = hull_part.solid;
    const auto corner = corners(hull_part);
    const Eigen::Vector3d normal =
        (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
    result =
        meet_face(placed_[static_cast<std::size_t>(index)], corner[0], normal, origin, direction);
  } else {
    index = rounds_[part];
    const auto met = intersect(round(index), origin, direction, 0.0);
    if (met) {
      const Isometry3d& T = placed_[static_cast<std::size_t>(index)].T_scene_solid;
      result =
          SolidHit{0, met->distance,
                   T.linear().transpose() * (origin + met->distance * direction - T.translation()),
                   T.linear().transpose() * met->normal};
    }
  }
  if (result) result->solid = index;
  return result;
}

}  // namespace tread
