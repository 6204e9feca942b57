#include "tread/sim/shading.hpp"

#include <algorithm>
#include <cmath>

#include "tread/sim/camera_view.hpp"
#include "tread/sim/sky_kernel.hpp"
#include "tread/sim/texture.hpp"
#include "tread/sim/texture_kernel.hpp"

namespace tread {
namespace {

using Row = SurfaceBatch::Row<float>;
using Colour = Eigen::Array3f;

constexpr float kHazeM = 900.0F;  // way after which half of the light is that of the haze

// Light of the sun, of the sky, and that the ground throws back up.
struct Lights {
  Colour sun, sky, ground;
};

struct SkyColours {
  Colour horizon, zenith, cloud;
};

Lights lights_of(const Scene& scene) {
  const Sun& sun = scene.world().sun;
  const auto strength = static_cast<float>(sun.strength), sky = static_cast<float>(sun.sky);
  const auto up = static_cast<float>(scene.sun_direction().z());
  Lights lights;
  lights.sun = (up > 0.0F ? strength : 0.0F) * Colour(1.04F, 1.0F, 0.90F);
  lights.sky = sky * Colour(0.88F, 1.0F, 1.18F);
  lights.ground = 0.22F * (up * lights.sun + lights.sky) * Colour(1.05F, 1.0F, 0.85F);
  return lights;
}

SkyColours sky_of(const Scene& scene) {
  const auto sky = static_cast<float>(scene.world().sun.sky);
  return {sky * Colour(1.75F, 1.95F, 2.15F), sky * Colour(0.55F, 0.95F, 1.75F),
          sky * Colour(2.35F, 2.35F, 2.40F)};
}

float grey_of(const Colour& c) {
  return kGreyOf.r * c.x() + kGreyOf.g * c.y() + kGreyOf.b * c.z();
}

// Textures of the points, one material after another.
class Textures {
 public:
  Textures(const Scene& scene, const SurfaceBatch& points) : points_(points) {
    const int count = points.count;
    for (int first = 0; first < count; ++first) {
      const std::int32_t material = points.material[static_cast<std::size_t>(first)];
      if (material < 0 || seen(material)) continue;
      look(scene.materials()[static_cast<std::size_t>(material)], material, first);
    }
  }
  alignas(64) Row value{}, hue{}, relief{};

 private:
  static constexpr int kRows = 7;

  bool seen(std::int32_t material) const {
    return std::find(seen_.begin(), seen_.begin() + kinds_, material) != seen_.begin() + kinds_;
  }
  void look(const Material& material, std::int32_t index, int first) {
    seen_[static_cast<std::size_t>(kinds_++)] = index;
    if (first == 0 &&
        std::all_of(points_.material.begin(), points_.material.begin() + points_.count,
                    [index](std::int32_t other) { return other == index; })) {
      texture(material.surface, material.contrast, material.seed,
              {points_.count, points_.u.data(), points_.v.data(), points_.w.data(),
               points_.sun_u.data(), points_.sun_v.data(), points_.sun_w.data(),
               points_.footprint_m.data(), value.data(), hue.data(), relief.data()});
      return;
    }
    std::array<std::uint16_t, RayBatch::kMost> from;
    int count = 0;
    for (int i = first; i < points_.count; ++i) {
      if (points_.material[static_cast<std::size_t>(i)] == index) {
        from[static_cast<std::size_t>(count++)] = static_cast<std::uint16_t>(i);
      }
    }
    const int whole = (count + kTextureBlock - 1) / kTextureBlock * kTextureBlock;
    const Row* sources[kRows] = {&points_.u,          &points_.v,     &points_.w,
                                 &points_.sun_u,      &points_.sun_v, &points_.sun_w,
                                 &points_.footprint_m};
    alignas(64) std::array<Row, kRows> in;
    alignas(64) std::array<Row, 3> out;
    for (std::size_t row = 0; row < kRows; ++row) {
      for (int i = 0; i < whole; ++i) {
        // What is missing to a whole block: the last point again.
        in[row][static_cast<std::size_t>(i)] =
            (*sources[row])[from[static_cast<std::size_t>(std::min(i, count - 1))]];
      }
    }
    texture(material.surface, material.contrast, material.seed,
            {whole, in[0].data(), in[1].data(), in[2].data(), in[3].data(), in[4].data(),
             in[5].data(), in[6].data(), out[0].data(), out[1].data(), out[2].data()});
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      value[from[i]] = out[0][i];
      hue[from[i]] = out[1][i];
      relief[from[i]] = out[2][i];
    }
  }

  const SurfaceBatch& points_;
  std::array<std::int32_t, RayBatch::kMost> seen_;
  int kinds_ = 0;
};

// How a material answers to the three lights: in the mean, and by hue.
struct Answer {
  std::array<float, 3> mean, by_hue;  // sun, sky, ground
};
Answer answer_of(const Material& material, const Lights& lights, int channel) {
  const Colour albedo = material.albedo.array(), tint = tint_of(material.surface).array();
  const Colour* each[3] = {&lights.sun, &lights.sky, &lights.ground};
  Answer answer;
  for (std::size_t i = 0; i < 3; ++i) {
    const Colour mean = *each[i] * albedo, by_hue = mean * tint;
    answer.mean[i] = channel < 0 ? grey_of(mean) : mean(channel);
    answer.by_hue[i] = channel < 0 ? grey_of(by_hue) : by_hue(channel);
  }
  return answer;
}

// The light of one channel (0 to 2, or -1 for grey) along every ray.
class Channel {
 public:
  Channel(const Scene& scene, int index) : scene_(scene), index_(index), lights_(lights_of(scene)) {
    const SkyColours sky = sky_of(scene);
    horizon_ = of(sky.horizon);
    zenith_ = of(sky.zenith);
    cloud_ = of(sky.cloud);
    const Answer ground = answer_of(scene.world().ground_materials.front(), lights_, index_);
    plain_ = std::max(0.0F, static_cast<float>(scene.sun_direction().z())) * ground.mean[0] +
             ground.mean[1];
  }
  void run(const RayBatch& rays, const SurfaceBatch& points, const Textures& textures,
           const Row& sunlit, const Row& clouds, Row& out) const {
    const auto count = static_cast<std::size_t>(points.count);
    std::array<Row, 6> answers;
    std::int32_t last = -1;
    Answer answer{};
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t material = points.material[i];
      if (material != last) {
        answer = material >= 0 ? answer_of(scene_.materials()[static_cast<std::size_t>(material)],
                                           lights_, index_)
                               : Answer{};
        last = material;
      }
      for (std::size_t light = 0; light < 3; ++light) {
        answers[light][i] = answer.mean[light];
        answers[3 + light][i] = answer.by_hue[light];
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const float up = 0.5F + 0.5F * points.normal_z[i], hue = textures.hue[i];
      const float light = textures.value[i] * (sunlit[i] * (answers[0][i] + hue * answers[3][i]) +
                                               up * (answers[1][i] + hue * answers[4][i]) +
                                               (1.0F - up) * (answers[2][i] + hue * answers[5][i]));
      const auto way = static_cast<float>(points.distance_m[i]);
      out[i] = light + (horizon_ - light) * way / (way + kHazeM);
    }
    if (std::find(points.material.begin(), points.material.begin() + points.count, -1) !=
        points.material.begin() + points.count) {
      add_sky(rays, points, clouds, out);
    }
  }

 private:
  // The sky; and below the horizon, where the world has ended, a plain as far as the haze lets see,
  // some 1.5 m below the camera. Nothing on it: it has no depth.
  [[nodiscard]] float far_away(float up, float cloud) const {
    if (up < 0.0F) {
      const float way = -1.5F / up;
      return plain_ + (horizon_ - plain_) * way / (way + 0.1F * kHazeM);
    }
    const float clear = horizon_ + up / (up + 0.35F) * 1.35F * (zenith_ - horizon_);
    return clear + cloud * (cloud_ - clear);
  }
  void add_sky(const RayBatch& rays, const SurfaceBatch& points, const Row& clouds,
               Row& out) const {
    for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
      if (points.material[i] >= 0) continue;
      const auto up = static_cast<float>(rays.direction[2][i]);
      out[i] = rays.spread_rad[i] >= 0.0F ? far_away(up, clouds[i]) : 0.0F;
    }
  }
  [[nodiscard]] float of(const Colour& c) const { return index_ < 0 ? grey_of(c) : c(index_); }

  const Scene& scene_;
  int index_;
  Lights lights_;
  float horizon_ = 0.0F, zenith_ = 0.0F, cloud_ = 0.0F, plain_ = 0.0F;
};

// How much of the sun each point gets: shadow, slant, relief of the texture.
void sunlight(const Scene& scene, const SurfaceBatch& points, const Textures& textures,
              const Row& lit, Row& out) {
  const Eigen::Vector3f sun = scene.sun_direction().cast<float>();
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
    const float facing =
        points.normal_x[i] * sun.x() + points.normal_y[i] * sun.y() + points.normal_z[i] * sun.z();
    const float slant = facing > 0.0F ? facing : -facing * points.through[i];
    out[i] = points.material[i] >= 0 ? lit[i] * slant * textures.relief[i] : 0.0F;
  }
}

void clouds_of(const Scene& scene, const RayBatch& rays, const SurfaceBatch& points, Row& out) {
  const auto sky = [&](std::int32_t material) { return material < 0; };
  out.fill(0.0F);
  if (std::none_of(points.material.begin(), points.material.begin() + points.count, sky)) return;
  alignas(64) std::array<Row, 3> direction;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
      direction[axis][i] = static_cast<float>(rays.direction[axis][i]);
    }
  }
  cloud_rows(direction[0].data(), direction[1].data(), direction[2].data(), points.count,
             static_cast<std::uint32_t>(scene.world().seed), out.data());
}

}  // namespace

void shade(const Scene& scene, const RayBatch& rays, const SurfaceBatch& points, const Row& lit,
           bool colour, LightBatch& light) {
  const Textures textures(scene, points);
  alignas(64) Row sunlit, clouds;
  sunlight(scene, points, textures, lit, sunlit);
  clouds_of(scene, rays, points, clouds);
  if (!colour) {
    Channel(scene, -1).run(rays, points, textures, sunlit, clouds, light.grey);
    return;
  }
  for (int channel = 0; channel < 3; ++channel) {
    Channel(scene, channel)
        .run(rays, points, textures, sunlit, clouds,
             light.colour[static_cast<std::size_t>(channel)]);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
    light.grey[i] = grey_of({light.colour[0][i], light.colour[1][i], light.colour[2][i]});
  }
}

}  // namespace tread
