#include "tread/sim/surface.hpp"

#include <array>

namespace tread {
namespace {

struct Entry {
  Surface surface;
  const char* name;
  std::array<float, 3> albedo;
  Footing footing;
};

// Friction of rubber and rolling resistance: usual figures of vehicle dynamics (Wong, Theory of
// Ground Vehicles, ch. 1 and 2: concrete 0.8 and 0.015, gravel 0.6 and 0.02 to 0.05, loose sand 0.1
// to 0.3 resistance).
constexpr std::array<Entry, 12> kEntries = {{
    {Surface::kSoil, "soil", {0.24F, 0.17F, 0.11F}, {0.65, 0.06, 0.06}},
    {Surface::kGravel, "gravel", {0.33F, 0.31F, 0.28F}, {0.60, 0.05, 0.10}},
    {Surface::kSand, "sand", {0.52F, 0.43F, 0.29F}, {0.50, 0.15, 0.20}},
    {Surface::kGrass, "grass", {0.16F, 0.25F, 0.07F}, {0.55, 0.07, 0.05}},
    {Surface::kConcrete, "concrete", {0.42F, 0.41F, 0.39F}, {0.80, 0.015, 0.01}},
    {Surface::kPlanks, "planks", {0.40F, 0.28F, 0.16F}, {0.70, 0.02, 0.01}},
    {Surface::kRock, "rock", {0.30F, 0.29F, 0.28F}, {0.70, 0.02, 0.01}},
    {Surface::kBark, "bark", {0.17F, 0.12F, 0.08F}, {0.60, 0.02, 0.01}},
    {Surface::kLeaves, "leaves", {0.12F, 0.22F, 0.05F}, {0.40, 0.08, 0.05}},
    {Surface::kCloth, "cloth", {0.20F, 0.22F, 0.35F}, {0.50, 0.02, 0.01}},
    {Surface::kSkin, "skin", {0.48F, 0.33F, 0.25F}, {0.50, 0.02, 0.01}},
    {Surface::kPlain, "plain", {0.45F, 0.45F, 0.45F}, {0.80, 0.015, 0.01}},
}};

const Entry& entry_of(Surface surface) {
  return kEntries[static_cast<std::size_t>(surface)];
}

// What lives changes its colour over the year.
Eigen::Vector3f tint(Surface surface, Season season, const Eigen::Vector3f& summer) {
  const bool leaves = surface == Surface::kLeaves;
  if (!leaves && surface != Surface::kGrass) return summer;
  switch (season) {
    case Season::kSpring:
      return {0.17F, 0.33F, 0.06F};
    case Season::kSummer:
      return summer;
    case Season::kAutumn:
      return leaves ? Eigen::Vector3f(0.42F, 0.20F, 0.05F) : Eigen::Vector3f(0.33F, 0.29F, 0.11F);
    case Season::kWinter:
      return leaves ? Eigen::Vector3f(0.22F, 0.18F, 0.13F) : Eigen::Vector3f(0.36F, 0.32F, 0.20F);
  }
  return summer;
}

}  // namespace

Material material_of(Surface surface, Season season, std::uint32_t seed) {
  const auto& [r, g, b] = entry_of(surface).albedo;
  return {surface, tint(surface, season, {r, g, b}), surface == Surface::kPlain ? 0.0F : 1.0F,
          seed};
}

Footing footing_of(Surface surface) {
  return entry_of(surface).footing;
}

std::string name_of(Surface surface) {
  return entry_of(surface).name;
}

std::optional<Surface> surface_named(const std::string& name) {
  for (const Entry& entry : kEntries) {
    if (name == entry.name) return entry.surface;
  }
  return std::nullopt;
}

std::vector<std::string> surface_names() {
  std::vector<std::string> names;
  for (const Entry& entry : kEntries) names.emplace_back(entry.name);
  return names;
}

}  // namespace tread
