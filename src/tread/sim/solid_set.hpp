// Solids as rays meet them: given to a RayTracer, and told apart again by what it found.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tread/sim/ray_tracer.hpp"
#include "tread/sim/world.hpp"

namespace tread {

struct SolidHit {
  int solid = 0;           // the how manieth that was added
  double distance = 0.0;   // in lengths of the direction
  Eigen::Vector3d point;   // axes of the solid
  Eigen::Vector3d normal;  // likewise, unit length, outwards
};

class SolidSet {
 public:
  // `hulls` as of the world; they must outlive this.
  explicit SolidSet(const std::vector<Mesh>* hulls) : hulls_(hulls) {}

  void add(const Solid& solid, const Isometry3d& T_scene_solid);
  void move(int solid, const Isometry3d& T_scene_solid);
  // Hands all shapes to a layer of the tracer, under three ids from the first on.
  void give_to(RayTracer& tracer, RayTracer::Layer layer, std::uint32_t first_id,
               std::uint32_t mask) const;
  static constexpr std::uint32_t kIds = 3;

  // Where a ray, in scene axes, meets what the tracer found. Empty where the two disagree, as
  // happens at the very edge of a thing.
  [[nodiscard]] std::optional<SolidHit> hit(std::uint32_t id_from_first, std::uint32_t part,
                                            const Eigen::Vector3d& origin,
                                            const Eigen::Vector3d& direction) const;
  [[nodiscard]] const Isometry3d& pose(int solid) const {
    return placed_[static_cast<std::size_t>(solid)].T_scene_solid;
  }
  [[nodiscard]] int count() const { return static_cast<int>(placed_.size()); }

 private:
  struct Placed {
    Solid::Shape shape;
    Isometry3d T_scene_solid;
    Eigen::Vector3d half_m;
    int hull;
  };
  struct HullPart {
    int solid;
    int triangle;
  };
  [[nodiscard]] std::optional<SolidHit> meet_face(const Placed& placed, const Eigen::Vector3d& a,
                                                  const Eigen::Vector3d& normal,
                                                  const Eigen::Vector3d& origin,
                                                  const Eigen::Vector3d& direction) const;
  [[nodiscard]] std::array<Eigen::Vector3d, 3> corners(const HullPart& part) const;
  [[nodiscard]] RoundShape round(int solid) const;

  const std::vector<Mesh>* hulls_;
  std::vector<Placed> placed_;
  std::vector<int> boxes_, rounds_;  // which of them, in the order of the tracer's parts
  std::vector<HullPart> hull_parts_;
};

}  // namespace tread
