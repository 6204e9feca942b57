#include "tread/sim/world_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace tread {
namespace {

tl::unexpected<Error> bad(std::string what, std::string where, std::string remedy) {
  return fail(ErrorCode::kBadValue, std::move(what), std::move(where), std::move(remedy));
}

Status check_ground(const World& world) {
  const GridGeometry& geometry = world.ground.geometry;
  if (geometry.columns < 2 || geometry.rows < 2 || !(geometry.resolution_m > 0.0) ||
      !std::isfinite(geometry.resolution_m) || !geometry.origin.allFinite()) {
    return bad(fmt::format("{} x {} cells of {} m are no ground", geometry.columns, geometry.rows,
                           geometry.resolution_m),
               "ground", "Give it at least 2 x 2 cells of a size above 0");
  }
  if (world.ground.values.size() != geometry.size()) {
    return bad("the heights are not as many as the cells", "ground", "Give one height a cell");
  }
  if (!(world.ground_surface.geometry == geometry) ||
      world.ground_surface.values.size() != geometry.size()) {
    return bad("it has not the cells of the ground", "ground_surface",
               "Give one material index for each cell of the ground");
  }
  const auto height = std::find_if(world.ground.values.begin(), world.ground.values.end(),
                                   [](float h) { return !std::isfinite(h); });
  if (height != world.ground.values.end()) {
    const auto at = height - world.ground.values.begin();
    return bad("a height is not a number",
               fmt::format("ground, cell ({}, {})", at % geometry.columns, at / geometry.columns),
               "Fill what the height map does not know");
  }
  const auto most =
      std::max_element(world.ground_surface.values.begin(), world.ground_surface.values.end());
  if (*most >= world.ground_materials.size()) {
    return bad(fmt::format("material {} of {}", *most, world.ground_materials.size()),
               "ground_surface", "Add the material to ground_materials");
  }
  return {};
}

Status check_material(const Material& material, const std::string& where) {
  const bool sound = material.albedo.allFinite() && material.albedo.minCoeff() >= 0.0F &&
                     material.albedo.maxCoeff() <= 1.0F && material.contrast >= 0.0F &&
                     std::isfinite(material.contrast) && material.surface <= Surface::kPlain;
  if (sound) return {};
  return bad("it reflects what no surface does", where,
             "Write albedos from 0 to 1 and a contrast of at least 0");
}

Status check_mesh(const Mesh& mesh, const std::string& where) {
  const auto count = static_cast<std::int32_t>(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    for (const std::int32_t corner : triangle) {
      if (corner >= 0 && corner < count) continue;
      return bad(fmt::format("a triangle has vertex {} of {}", corner, count), where,
                 "Number the vertices from 0");
    }
  }
  if (std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                  [](const Eigen::Vector3f& v) { return v.allFinite(); })) {
    return {};
  }
  return bad("a vertex is not a number", where, "Give every vertex three finite coordinates");
}

Status check_solid(const World& world, const Solid& solid, const std::string& where) {
  if (!solid.half_m.allFinite() || solid.half_m.minCoeff() <= 0.0) {
    return bad(
        fmt::format("sides of {}, {}, {} m", solid.half_m.x(), solid.half_m.y(), solid.half_m.z()),
        where + ": half_m", "Write lengths above 0");
  }
  if (!is_rigid(solid.T_world_solid)) {
    return bad("its pose is not a rigid motion", where + ": T_world_solid",
               "Write an orthonormal right-handed rotation and finite metres");
  }
  if (solid.shape == Solid::Shape::kHull &&
      (solid.hull < 0 || static_cast<std::size_t>(solid.hull) >= world.hulls.size())) {
    return bad(fmt::format("hull {} of {}", solid.hull, world.hulls.size()), where + ": hull",
               "Number the hulls from 0");
  }
  return check_material(solid.material, where);
}

Status check_person(const Person& person, const std::string& where) {
  const bool walks = person.path_m.size() >= 2 &&
                     std::all_of(person.path_m.begin(), person.path_m.end(),
                                 [](const Eigen::Vector2d& p) { return p.allFinite(); });
  if (!walks || !std::isfinite(person.speed_m_per_s) || !std::isfinite(person.ahead_s)) {
    return bad("it has no way to walk", where, "Give at least two places and a finite speed");
  }
  if (!(person.height_m > 0.0) || !std::isfinite(person.height_m)) {
    return bad(fmt::format("a height of {} m", person.height_m), where + ": height_m",
               "Write a length above 0");
  }
  return check_material(person.clothes, where);
}

}  // namespace

Status check_world(const World& world) {
  if (Status sound = check_ground(world); !sound) return sound;
  const auto named = [](const char* list, std::size_t i, const std::string& name) {
    return fmt::format("{}[{}]{}", list, i, name.empty() ? "" : " (" + name + ")");
  };
  for (std::size_t i = 0; i < world.ground_materials.size(); ++i) {
    const Status sound =
        check_material(world.ground_materials[i], named("ground_materials", i, ""));
    if (!sound) return sound;
  }
  for (std::size_t i = 0; i < world.hulls.size(); ++i) {
    if (Status sound = check_mesh(world.hulls[i], named("hulls", i, "")); !sound) return sound;
  }
  for (std::size_t i = 0; i < world.solids.size(); ++i) {
    const Solid& solid = world.solids[i];
    if (Status sound = check_solid(world, solid, named("solids", i, solid.name)); !sound) {
      return sound;
    }
  }
  for (std::size_t i = 0; i < world.foliage.size(); ++i) {
    const Foliage& foliage = world.foliage[i];
    const std::string where = named("foliage", i, foliage.name);
    if (Status sound = check_mesh(foliage.mesh, where); !sound) return sound;
    if (Status sound = check_material(foliage.material, where); !sound) return sound;
  }
  for (std::size_t i = 0; i < world.people.size(); ++i) {
    const Person& person = world.people[i];
    if (Status sound = check_person(person, named("people", i, person.name)); !sound) return sound;
  }
  const Sun& sun = world.sun;
  if (!std::isfinite(sun.azimuth_rad) || !std::isfinite(sun.elevation_rad) ||
      !(sun.strength >= 0.0) || !(sun.sky >= 0.0) || !std::isfinite(sun.strength + sun.sky)) {
    return bad("no such light", "sun", "Write finite angles, and strengths of at least 0");
  }
  return {};
}

}  // namespace tread
