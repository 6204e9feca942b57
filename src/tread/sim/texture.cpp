#include "tread/sim/texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "tread/sim/texture_kernel.hpp"

namespace tread {
namespace {

bool is_flat(Surface surface) {
  using enum Surface;
  return surface == kSoil || surface == kGravel || surface == kSand || surface == kGrass ||
         surface == kPlanks;
}

}  // namespace

TexturePlace texture_place(Surface surface, const Eigen::Vector3d& sides_m,
                           const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                           const Eigen::Vector3d& sun) {
  if (!is_flat(surface)) return {point, sun};
  std::array<int, 3> axes = {0, 1, 2};
  int across = 0;  // the axis that the side is across
  normal.cwiseAbs().maxCoeff(&across);
  if (surface == Surface::kPlanks) {
    // Along the boards, along their width, through them.
    std::stable_sort(axes.begin(), axes.end(),
                     [&](int a, int b) { return sides_m(a) > sides_m(b); });
    if (across == axes[1]) std::swap(axes[1], axes[2]);
    if (across == axes[0]) std::rotate(axes.begin(), axes.begin() + 1, axes.end());
  } else {
    std::rotate(axes.begin(), axes.begin() + (across + 1) % 3, axes.end());
  }
  const auto turned = [&axes](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p(axes[0]), p(axes[1]), p(axes[2]));
  };
  return {turned(point), turned(sun)};
}

Eigen::Vector3f tint_of(Surface surface) {
  switch (surface) {
    case Surface::kSoil:
      return {0.16F, 0.02F, -0.12F};
    case Surface::kGravel:
    case Surface::kRock:
      return {0.14F, 0.04F, -0.14F};
    case Surface::kGrass:
    case Surface::kLeaves:
      return {0.40F, 0.10F, 0.14F};
    case Surface::kPlanks:
    case Surface::kBark:
      return {0.12F, -0.02F, -0.14F};
    case Surface::kSkin:
      return {0.08F, -0.06F, -0.06F};
    case Surface::kSand:
    case Surface::kConcrete:
    case Surface::kCloth:
      return {0.05F, 0.01F, -0.06F};
    case Surface::kPlain:
      break;
  }
  return Eigen::Vector3f::Zero();
}

Eigen::Vector3f albedo_at(const Material& material, const Eigen::Vector3d& place,
                          double footprint_m) {
  std::array<float, kTextureBlock> in[7] = {}, out[3];
  in[0].fill(static_cast<float>(place.x()));
  in[1].fill(static_cast<float>(place.y()));
  in[2].fill(static_cast<float>(place.z()));
  in[6].fill(static_cast<float>(footprint_m));
  texture(material.surface, material.contrast, material.seed,
          {kTextureBlock, in[0].data(), in[1].data(), in[2].data(), in[3].data(), in[4].data(),
           in[5].data(), in[6].data(), out[0].data(), out[1].data(), out[2].data()});
  const Eigen::Array3f tinted = 1.0F + out[1][0] * tint_of(material.surface).array();
  return out[0][0] * material.albedo.array() * tinted;
}

void texture(Surface surface, float contrast, std::uint32_t seed, const TextureRows& rows) {
  if (surface == Surface::kPlain || contrast <= 0.0F) {
    std::fill_n(rows.value, rows.count, 1.0F);
    std::fill_n(rows.hue, rows.count, 0.0F);
    std::fill_n(rows.relief, rows.count, 1.0F);
    return;
  }
  texture_rows(surface, contrast, seed, rows);
}

}  // namespace tread
