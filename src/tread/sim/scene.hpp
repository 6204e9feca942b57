// A world made ready for rays: what a camera sees, and what is where, exactly.
//
// Embree says in single precision which triangle or shape a ray meets; where, is then worked out
// in double precision from the world itself: the plane of the triangle, the face of the box, the
// quadric of the cylinder or ellipsoid. Depth is thus exact to what a float holds, anywhere in the
// world. Everything is cast at in the scene's own axes: those of the world about the middle of
// its ground, in whole metres, so that worlds far from their origin lose nothing.
//
// Cost: a million triangles are ready in under half a second; a ray some 40 ns among its like.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/sim/surface_batch.hpp"
#include "tread/sim/world.hpp"

namespace tread {

enum class HitKind : std::uint8_t { kNothing, kGround, kSolid, kFoliage, kPerson };

struct RayHit {
  HitKind kind = HitKind::kNothing;
  int index = 0;  // of World::solids, foliage or people
  double distance_m = std::numeric_limits<double>::infinity();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // outwards; of foliage: towards the ray
};

enum class RaysMeet {
  kEverything,
  kWhatBears,  // ground, solids and people: no foliage
};

class Scene {
 public:
  // The world must not change any more. Errors: those of check_world(), and too little memory.
  [[nodiscard]] static Result<Scene> make(std::shared_ptr<const World> world);
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  ~Scene();

  [[nodiscard]] const World& world() const;
  // Moves people to where they are at a time; at 0 until then. Not while others cast rays.
  void set_time(double time_s);

  // The first thing that a ray meets; `direction` need not be of unit length, the distance is then
  // still metres. Nothing for a direction of no length.
  [[nodiscard]] RayHit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                            RaysMeet meet = RaysMeet::kEverything) const;
  // Whether anything is between two points.
  [[nodiscard]] bool blocked(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                             RaysMeet meet = RaysMeet::kEverything) const;

  // For cameras. `points.count` becomes that of the rays.
  void cast(const RayBatch& rays, SurfaceBatch& points) const;
  // Sets `lit` to 1 for points that the sun shines on, else to 0.
  void light(const SurfaceBatch& points, SurfaceBatch::Row<float>& lit) const;
  [[nodiscard]] const std::vector<Material>& materials() const;
  // Towards the sun, unit length; zero without sun.
  [[nodiscard]] const Eigen::Vector3d& sun_direction() const;

 private:
  struct Parts;
  explicit Scene(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace tread
