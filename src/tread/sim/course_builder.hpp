// Internal to sim: a world in the making, and what the parts of a course file add to it.
#pragma once

#include <string>
#include <vector>

#include "tread/io/text_tree.hpp"
#include "tread/sim/course_fields.hpp"
#include "tread/sim/random.hpp"
#include "tread/sim/world.hpp"

namespace tread::internal {

struct CourseBuilder {
  World world;
  Season season = Season::kSummer;
  Random random{0};  // of the course; each entry takes a stream of its own by its place in the file

  [[nodiscard]] Material material(Surface surface, Random& stream) const {
    return material_of(surface, season, stream.bits());
  }
  // Discs that scattered things keep free of: start, goal, route and what stands already.
  struct Disc {
    Eigen::Vector2d middle;
    double radius_m;
  };
  std::vector<Disc> taken;
  [[nodiscard]] bool is_free(const Eigen::Vector2d& middle, double radius_m) const;
  // Distance from the way of the robot: start, route, goal.
  [[nodiscard]] double from_route(const Eigen::Vector2d& place) const;
  // The ground there; the nearest ground from outside.
  [[nodiscard]] double height(const Eigen::Vector2d& place) const;
};

// Where the ground is, for messages.
[[nodiscard]] std::string extent_text(const World& world);

// A box upright on the ground, its top `size.z` above the ground at its middle (or `lift_m` more,
// and then it does not reach down): its foot goes as far down as the ground around it.
struct BoxSpec {
  std::string name;
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0, pitch_rad = 0.0, roll_rad = 0.0;
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();
  double lift_m = 0.0;
  Material material;
};
void add_box(CourseBuilder& builder, const BoxSpec& box);

// ground: surface, height map, relief, patches. Sets world.ground and what belongs to it.
[[nodiscard]] Status read_ground(const Field& field, CourseBuilder& builder);
// One item of objects: a map with one entry, the kind.
[[nodiscard]] Status read_object(const Field& item, CourseBuilder& builder);
// The kinds of plants and stones; false if `kind` is none of them.
[[nodiscard]] Result<bool> read_growth(const std::string& kind, const Field& field,
                                       const std::string& name, Random stream,
                                       CourseBuilder& builder);
[[nodiscard]] std::vector<std::string> growth_kinds();

}  // namespace tread::internal
