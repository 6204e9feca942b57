// What the ground and the things on it are made of: how it looks and how it holds a wheel.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tread {

enum class Surface : std::uint8_t {
  kSoil,
  kGravel,
  kSand,
  kGrass,
  kConcrete,
  kPlanks,
  kRock,
  kBark,
  kLeaves,
  kCloth,
  kSkin,
  kPlain,  // no texture at all: what stereo fails on
};

enum class Season { kSpring, kSummer, kAutumn, kWinter };

// The look of one thing. The texture is a function of the place on it and of the seed.
struct Material {
  Surface surface = Surface::kSoil;
  Eigen::Vector3f albedo{0.3F, 0.3F, 0.3F};  // mean, linear red, green, blue, 0 to 1
  float contrast = 1.0F;                     // of the texture: 0 none, 1 what the surface has
  std::uint32_t seed = 0;                    // another seed, other grains
};

// How a surface bears a robot.
struct Footing {
  double friction = 0.8;             // sliding friction coefficient against rubber
  double rolling_resistance = 0.02;  // resisting force / load of a wheel
  double slip = 0.0;                 // slip ratio of a wheel that pulls half of what it could
};

[[nodiscard]] Material material_of(Surface surface, Season season, std::uint32_t seed);
[[nodiscard]] Footing footing_of(Surface surface);

// "gravel"; and back.
[[nodiscard]] std::string name_of(Surface surface);
[[nodiscard]] std::optional<Surface> surface_named(const std::string& name);
[[nodiscard]] std::vector<std::string> surface_names();

}  // namespace tread
