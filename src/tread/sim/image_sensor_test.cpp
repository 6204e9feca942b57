#include "tread/sim/image_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "instruction_sets.hpp"

namespace tread {
namespace {

constexpr int kWidth = 200, kHeight = 150;

CameraRays narrow_rays() {
  const PinholeCamera camera{400.0, 400.0, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1), 0.0};
  return make_camera_rays(camera, {kWidth, kHeight}).value();
}
CameraView even_view(float light) {
  return {Image<float>(kWidth, kHeight, light),
          Image<LightRgb>(kWidth, kHeight, {light, 0.5F * light, 0.25F * light}),
          Image<float>(kWidth, kHeight, 1.0F)};
}
ImageSensorOptions linear() {
  ImageSensorOptions options;
  options.automatic = false;
  options.exposure_s = 0.001;
  options.saturating_s = 0.001;
  options.gamma = 1.0;
  options.vignetting = 0.0;
  return options;
}

struct Moments {
  double mean = 0.0, variance = 0.0;
};
Moments moments(const Image<std::uint8_t>& image) {
  double sum = 0.0, squares = 0.0;
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      sum += image(u, v);
      squares += image(u, v) * image(u, v);
    }
  }
  const double n = image.width * image.height;
  return {sum / n, squares / n - sum * sum / (n * n)};
}

Image<std::uint8_t> expose(const ImageSensorOptions& options, const CameraView& view,
                           const Exposure& exposure, const ImageNumber& number = {},
                           const Context& context = {}) {
  const ImageSensor sensor = ImageSensor::make(options, narrow_rays()).value();
  Image<std::uint8_t> image;
  EXPECT_TRUE(sensor.expose(view, exposure, number, image, context));
  return image;
}

// Photon transfer (EMVA 1288): variance = K mean + (K read noise)^2 + 1/12 of rounding, with K
// bytes an electron, for several wells, gains and read noises.
TEST(ImageSensor, VarianceFollowsShotAndReadNoise) {
  testing::on_every_target([] {
    for (const double well : {4000.0, 20000.0}) {
      for (const double read : {0.0, 30.0}) {
        for (const double gain : {1.0, 4.0}) {
          ImageSensorOptions options = linear();
          options.full_well_e = well;
          options.read_noise_e = read;
          for (const double signal : {0.15, 0.4, 0.7}) {
            const auto light = static_cast<float>(signal / gain);
            const Moments got =
                moments(expose(options, even_view(light), {options.exposure_s, gain}));
            const double per_electron = 255.0 * gain / well;
            const double expected =
                per_electron * 255.0 * signal + std::pow(per_electron * read, 2.0) + 1.0 / 12.0;
            EXPECT_NEAR(got.mean, 255.0 * signal, 0.15);
            // 30000 pixels: the variance is known to 0.8 %.
            EXPECT_NEAR(got.variance / expected, 1.0, 0.04) << well << " " << read << " " << gain;
          }
        }
      }
    }
  });
}

TEST(ImageSensor, SaturatesAtTheWellAndAtTheByte) {
  const ImageSensorOptions options = linear();
  EXPECT_EQ(moments(expose(options, even_view(5.0F), {0.001, 1.5})).mean, 255.0);
  // A full well of half the gain is not white: the well is what is full.
  EXPECT_NEAR(moments(expose(options, even_view(5.0F), {0.001, 0.5})).mean, 127.5, 0.6);
  EXPECT_EQ(moments(expose(options, even_view(0.0F), {0.001, 0.01})).mean, 0.0);
}

TEST(ImageSensor, BrightnessGrowsWithExposureAndByGamma) {
  ImageSensorOptions options = linear();
  const Moments once = moments(expose(options, even_view(0.1F), {0.001, 1.0}));
  const Moments twice = moments(expose(options, even_view(0.1F), {0.002, 1.0}));
  EXPECT_NEAR(twice.mean / once.mean, 2.0, 0.01);
  options.gamma = 2.2;
  EXPECT_NEAR(moments(expose(options, even_view(0.1F), {0.001, 1.0})).mean,
              255.0 * std::pow(0.1, 1.0 / 2.2), 0.5);
}

TEST(ImageSensor, VignettingIsAShareOfTheFourthPowerOfTheCosine) {
  ImageSensorOptions options = linear();
  options.full_well_e = 1e7;
  options.read_noise_e = 0.0;
  const CameraRays rays = narrow_rays();
  for (const double share : {0.0, 0.5, 1.0}) {
    options.vignetting = share;
    const Image<std::uint8_t> image = expose(options, even_view(0.9F), {0.001, 1.0});
    const double cosine = rays.pixels(0, 0).z;
    EXPECT_NEAR(image(0, 0), 229.5 * (1.0 + share * (std::pow(cosine, 4.0) - 1.0)), 0.8);
    EXPECT_NEAR(image(kWidth / 2, kHeight / 2), 229.5, 0.8);
  }
}

TEST(ImageSensor, MetersForItsTargetWithinItsLimits) {
  ImageSensorOptions options;
  options.target_mean = 100.0;
  const ImageSensor sensor = ImageSensor::make(options, narrow_rays()).value();
  const auto mean = [&](float light) {
    const CameraView view = even_view(light);
    Image<std::uint8_t> image;
    EXPECT_TRUE(sensor.expose(view, sensor.meter(view), {}, image));
    return moments(image).mean;
  };
  for (const float light : {0.02F, 0.1F, 0.4F, 1.0F}) EXPECT_NEAR(mean(light), 100.0, 2.0) << light;
  // Bright light: short exposures, no gain. Dim light: the longest, then gain.
  const Exposure bright = sensor.meter(even_view(1.0F)), dim = sensor.meter(even_view(0.003F));
  EXPECT_LT(bright.exposure_s, 0.001);
  EXPECT_EQ(bright.gain, 1.0);
  EXPECT_EQ(dim.exposure_s, options.longest_s);
  EXPECT_GT(dim.gain, 2.0);
  const Exposure night = sensor.meter(even_view(1e-7F));
  EXPECT_NEAR(night.gain, options.largest_gain, 0.05);
  options.automatic = false;
  const Exposure fixed = ImageSensor::make(options, narrow_rays()).value().meter(even_view(1e-7F));
  EXPECT_EQ(fixed.exposure_s, options.exposure_s);
  EXPECT_EQ(fixed.gain, options.gain);
}

// Noise differs from frame to frame, camera to camera, seed to seed, and is otherwise the same.
TEST(ImageSensor, EveryImageHasItsOwnNoise) {
  const ImageSensorOptions options = linear();
  const CameraView view = even_view(0.4F);
  const Exposure exposure{0.001, 1.0};
  const Image<std::uint8_t> first = expose(options, view, exposure, {1, 2, 3});
  EXPECT_TRUE(first == expose(options, view, exposure, {1, 2, 3}));
  EXPECT_TRUE(first == expose(options, view, exposure, {1, 2, 3}, Context{2, nullptr}));
  const double variance = moments(first).variance;
  for (const ImageNumber& other : {ImageNumber{2, 2, 3}, ImageNumber{1, 3, 3}, ImageNumber{1, 2, 4},
                                   ImageNumber{1ULL << 40, 2, 3}}) {
    const Image<std::uint8_t> image = expose(options, view, exposure, other);
    double product = 0.0, next = 0.0;
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth - 1; ++u) {
        product += (first(u, v) - 102.0) * (image(u, v) - 102.0);
        next += (image(u, v) - 102.0) * (image(u + 1, v) - 102.0);
      }
    }
    // Of 30000 independent values: 0.006 at one standard deviation.
    EXPECT_LT(std::abs(product / (kWidth * kHeight * variance)), 0.03);
    EXPECT_LT(std::abs(next / (kWidth * kHeight * variance)), 0.03);
  }
}

TEST(ImageSensor, ColoursAreExposedEachByItself) {
  const ImageSensor sensor = ImageSensor::make(linear(), narrow_rays()).value();
  Image<Rgb> image;
  ASSERT_TRUE(sensor.expose(even_view(0.8F), {0.001, 1.0}, {}, image));
  double r = 0.0, g = 0.0, b = 0.0, rg = 0.0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Rgb& c = image(u, v);
      r += c.r;
      g += c.g;
      b += c.b;
      rg += (c.r - 204.0) * (c.g - 102.0);
    }
  }
  const double n = kWidth * kHeight;
  EXPECT_NEAR(r / n, 204.0, 0.1);
  EXPECT_NEAR(g / n, 102.0, 0.1);
  EXPECT_NEAR(b / n, 51.0, 0.1);
  EXPECT_LT(std::abs(rg / n), 0.15) << "channels share their noise";
}

TEST(ImageSensor, RefusesWhatCannotBe) {
  ImageSensorOptions options;
  options.full_well_e = 0.0;
  EXPECT_FALSE(ImageSensor::make(options, narrow_rays()));
  options = {};
  options.shortest_s = 0.1;
  EXPECT_FALSE(ImageSensor::make(options, narrow_rays()));
  const ImageSensor sensor = ImageSensor::make({}, narrow_rays()).value();
  Image<std::uint8_t> grey;
  Image<Rgb> colour;
  EXPECT_FALSE(sensor.expose({}, {0.001, 1.0}, {}, grey));
  EXPECT_FALSE(sensor.expose(even_view(1.0F), {0.0, 1.0}, {}, grey));
  EXPECT_FALSE(sensor.expose(even_view(1.0F), {0.001, std::nan("")}, {}, grey));
  CameraView only_grey = even_view(1.0F);
  only_grey.colour = {};
  EXPECT_TRUE(sensor.expose(only_grey, {0.001, 1.0}, {}, grey));
  EXPECT_FALSE(sensor.expose(only_grey, {0.001, 1.0}, {}, colour));
}

}  // namespace
}  // namespace tread
