#include "tread/sim/texture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "instruction_sets.hpp"
#include "tread/sim/hash_noise_kernel.hpp"

namespace tread {
namespace {

using enum Surface;

const std::vector<Surface> kTextured = {kSoil, kGravel, kSand,   kGrass, kConcrete, kPlanks,
                                        kRock, kBark,   kLeaves, kCloth, kSkin};

// Many points and what becomes of them.
struct Points {
  std::vector<float> u, v, w, sun_u, sun_v, sun_w, footprint, value, hue, relief;

  explicit Points(std::size_t count)
      : u(count),
        v(count),
        w(count),
        sun_u(count, 0.6F),
        sun_v(count, 0.3F),
        sun_w(count, 0.7F),
        footprint(count, 0.002F),
        value(count),
        hue(count),
        relief(count) {}
  void look(Surface surface, float contrast = 1.0F, std::uint32_t seed = 5) {
    texture(surface, contrast, seed,
            {static_cast<int>(u.size()), u.data(), v.data(), w.data(), sun_u.data(), sun_v.data(),
             sun_w.data(), footprint.data(), value.data(), hue.data(), relief.data()});
  }
};
Points spread_out(std::size_t count, float footprint) {
  Points points(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::uint32_t>(3 * i);
    points.u[i] = 5.0F * signed_unit(hash_mix(k));
    points.v[i] = 5.0F * signed_unit(hash_mix(k + 1));
    points.w[i] = 0.04F * signed_unit(hash_mix(k + 2));
    points.footprint[i] = footprint;
  }
  return points;
}

double mean_of(const std::vector<float>& values) {
  double sum = 0.0;
  for (const float x : values) sum += static_cast<double>(x);
  return sum / static_cast<double>(values.size());
}
double sigma_of(const std::vector<float>& values) {
  const double mean = mean_of(values);
  double sum = 0.0;
  for (const float x : values)
    sum += (static_cast<double>(x) - mean) * (static_cast<double>(x) - mean);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(Texture, KeepsTheMeanAlbedoFromNearAndFar) {
  for (const Surface surface : kTextured) {
    for (const float footprint : {0.001F, 0.004F, 0.012F, 0.03F, 0.1F}) {
      Points points = spread_out(16384, footprint);
      points.look(surface);
      EXPECT_NEAR(mean_of(points.value), 1.0, 0.06) << name_of(surface) << " " << footprint;
      EXPECT_NEAR(mean_of(points.hue), 0.0, 0.1) << name_of(surface) << " " << footprint;
      EXPECT_NEAR(mean_of(points.relief), 1.0, 0.06) << name_of(surface) << " " << footprint;
    }
  }
}

// Enough to see at 1 to 10 m through a 640 px camera (pixels of 3 to 30 mm), not so much that
// it would be noise.
TEST(Texture, HasContrastAtEveryDistance) {
  for (const Surface surface : kTextured) {
    const bool faint = surface == kSkin || surface == kCloth;
    for (const float footprint : {0.003F, 0.01F, 0.03F}) {
      Points points = spread_out(8192, footprint);
      points.look(surface);
      EXPECT_GT(sigma_of(points.value), faint ? 0.03 : 0.06) << name_of(surface) << footprint;
      EXPECT_LT(sigma_of(points.value), 0.4) << name_of(surface) << footprint;
    }
  }
}

// Change from one place to another `step` away, against the change over all: what is finer than
// two pixels must be gone, what is coarser must be there.
double change(Surface surface, float footprint, float step) {
  Points here = spread_out(8192, footprint), there = here;
  for (std::size_t i = 0; i < there.u.size(); ++i) {
    there.u[i] += 0.7071F * step;
    there.v[i] += 0.7071F * step;
  }
  here.look(surface);
  there.look(surface);
  double squares = 0.0;
  for (std::size_t i = 0; i < here.value.size(); ++i) {
    const auto d = static_cast<double>(here.value[i] - there.value[i]);
    squares += d * d;
  }
  return std::sqrt(squares / static_cast<double>(here.value.size()));
}

TEST(Texture, IsSmoothWithinAPixelAndNotBeyond) {
  for (const Surface surface : kTextured) {
    if (surface == kPlanks) continue;  // boards have edges
    for (const float footprint : {0.003F, 0.01F, 0.03F}) {
      Points all = spread_out(8192, footprint);
      all.look(surface);
      const double sigma = sigma_of(all.value);
      // Half a pixel of a signal with nothing above one cycle in two pixels: at most 0.7 of what
      // white noise has, sqrt(2) sigma.
      EXPECT_LT(change(surface, footprint, 0.5F * footprint), 0.7 * std::sqrt(2.0) * sigma)
          << name_of(surface) << " " << footprint;
      EXPECT_GT(change(surface, footprint, 6.0F * footprint), 0.35 * std::sqrt(2.0) * sigma)
          << name_of(surface) << " " << footprint;
    }
  }
}

// Grain down to 2 mm, for a camera that comes near.
TEST(Texture, HasGrainOfTwoMillimetres) {
  for (const Surface surface : kTextured) {
    EXPECT_GT(change(surface, 0.0005F, 0.002F), 0.01) << name_of(surface);
  }
}

TEST(Texture, PlainIsExactlyUniformAndContrastScales) {
  Points points = spread_out(256, 0.003F);
  for (const bool plain : {true, false}) {
    points.look(plain ? kPlain : kGravel, plain ? 1.0F : 0.0F);
    for (std::size_t i = 0; i < points.value.size(); ++i) {
      EXPECT_EQ(points.value[i], 1.0F);
      EXPECT_EQ(points.hue[i], 0.0F);
      EXPECT_EQ(points.relief[i], 1.0F);
    }
  }
  points.look(kSoil, 1.0F);
  const double full = sigma_of(points.value);
  points.look(kSoil, 0.5F);
  EXPECT_NEAR(sigma_of(points.value) / full, 0.5, 0.02);
}

// A point looks the same alone and among others: tiles of an image leave no seams.
TEST(Texture, DoesNotDependOnWhatIsLookedAtBeside) {
  for (const Surface surface : kTextured) {
    Points points = spread_out(64, 0.004F);
    for (std::size_t i = 0; i < 64; ++i) points.footprint[i] *= 1.0F + 0.2F * static_cast<float>(i);
    points.look(surface);
    for (const std::size_t i : {std::size_t{3}, std::size_t{40}}) {
      const Material material{surface, {0.5F, 0.5F, 0.5F}, 1.0F, 5};
      const Eigen::Vector3f albedo =
          albedo_at(material,
                    {static_cast<double>(points.u[i]), static_cast<double>(points.v[i]),
                     static_cast<double>(points.w[i])},
                    static_cast<double>(points.footprint[i]));
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(albedo(c),
                    0.5F * points.value[i] * (1.0F + points.hue[i] * tint_of(surface)(c)), 1e-5F)
            << name_of(surface);
      }
    }
  }
}

TEST(Texture, SeedsGiveOtherGrains) {
  for (const Surface surface : kTextured) {
    Points one = spread_out(4096, 0.003F), two = one;
    one.look(surface, 1.0F, 1);
    two.look(surface, 1.0F, 2);
    double product = 0.0;
    const double mean_one = mean_of(one.value), mean_two = mean_of(two.value);
    for (std::size_t i = 0; i < one.value.size(); ++i) {
      product += (static_cast<double>(one.value[i]) - mean_one) *
                 (static_cast<double>(two.value[i]) - mean_two);
    }
    // Only a hundred boards, each of one tone.
    const double limit = surface == kPlanks ? 0.4 : 0.25;
    EXPECT_LT(std::abs(product / 4096.0), limit * sigma_of(one.value) * sigma_of(two.value))
        << name_of(surface);
  }
}

TEST(Texture, IsTheSameWithEveryInstructionSet) {
  std::vector<Points> first;
  testing::on_every_target([&] {
    std::vector<Points> now;
    for (const Surface surface : kTextured) {
      now.push_back(spread_out(512, 0.003F));
      now.back().look(surface);
    }
    if (first.empty()) first = now;
    for (std::size_t k = 0; k < now.size(); ++k) {
      for (std::size_t i = 0; i < now[k].value.size(); ++i) {
        // Fused operations round otherwise; nothing else differs.
        EXPECT_NEAR(now[k].value[i], first[k].value[i], 2e-3F) << name_of(kTextured[k]);
      }
    }
  });
}

// Towards the sun a slope is bright, away from it dark: relief turns over with the sun.
TEST(Texture, ReliefTurnsWithTheSun) {
  for (const Surface surface : {kSoil, kGravel, kSand, kRock}) {
    Points east = spread_out(4096, 0.002F), west = east;
    for (float& x : east.sun_v) x = 0.0F;
    for (float& x : east.sun_w) x = 0.0F;
    west.sun_v = east.sun_v;
    west.sun_w = east.sun_w;
    for (float& x : west.sun_u) x = -x;
    east.look(surface);
    west.look(surface);
    double product = 0.0;
    for (std::size_t i = 0; i < east.relief.size(); ++i) {
      product +=
          (static_cast<double>(east.relief[i]) - 1.0) * (static_cast<double>(west.relief[i]) - 1.0);
    }
    EXPECT_LT(product / 4096.0, -0.3 * sigma_of(east.relief) * sigma_of(west.relief))
        << name_of(surface);
    EXPECT_EQ(east.value, west.value);
  }
}

TEST(TexturePlace, BoardsRunAlongTheLongestSide) {
  const Eigen::Vector3d sides(0.4, 0.6, 0.07), sun(0.1, 0.2, 0.3), p(1.0, 2.0, 3.0);
  // On top: along y, across x, through z.
  const TexturePlace top = texture_place(kPlanks, sides, p, {0.0, 0.0, 1.0}, sun);
  EXPECT_EQ(top.place, Eigen::Vector3d(2.0, 1.0, 3.0));
  EXPECT_EQ(top.sun, Eigen::Vector3d(0.2, 0.1, 0.3));
  // On the long edge: still along y, across z.
  EXPECT_EQ(texture_place(kPlanks, sides, p, {-1.0, 0.0, 0.0}, sun).place,
            Eigen::Vector3d(2.0, 3.0, 1.0));
  // At the end of the boards: across x and z.
  const Eigen::Vector3d end = texture_place(kPlanks, sides, p, {0.0, 1.0, 0.0}, sun).place;
  EXPECT_EQ(end.z(), 2.0);
}

TEST(TexturePlace, FlatTexturesLieOnTheSideTheyAreSeenOn) {
  const Eigen::Vector3d sides(1.0, 1.0, 1.0), sun(0.1, 0.2, 0.3), p(1.0, 2.0, 3.0);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d q =
        texture_place(kGravel, sides, p, Eigen::Vector3d::Unit(axis), sun).place;
    EXPECT_EQ(q.z(), p(axis));
    EXPECT_EQ(q.x() + q.y(), p.sum() - p(axis));
    EXPECT_EQ(texture_place(kRock, sides, p, Eigen::Vector3d::Unit(axis), sun).place, p);
  }
}

}  // namespace
}  // namespace tread
