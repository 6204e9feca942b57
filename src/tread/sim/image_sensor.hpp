// From light to the bytes of an 8-bit camera: exposure, vignetting, shot and read noise, gain,
// saturation and response. The model of the EMVA 1288 standard:
//   electrons e = light x exposure / saturating exposure x full well x vignetting, at most full
//   well its variance e (Poisson, as a normal distribution) + read noise^2 byte = 255 (gain e /
//   full well)^(1 / gamma)
// so that at gamma 1 the variance of a byte grows linearly with its mean, by gain 255 / full well:
// the photon transfer line.
//
// Noise is a hash of seed, camera, frame, pixel and channel: the same bytes every time. Cost: about
// 2 ns a pixel of a grey image.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/sim/camera_rays.hpp"
#include "tread/sim/camera_view.hpp"

namespace tread {

struct SensorRow;

struct ImageSensorOptions {
  bool automatic = true;         // exposure and gain for the mean below; else these two:
  double exposure_s = 0.002;     // of each row
  double gain = 1.0;             // of the amplifier
  double target_mean = 110.0;    // of the image, of 255
  double shortest_s = 2e-5;      // exposures that automatic exposure chooses from
  double longest_s = 0.01;       // to keep motion blur small
  double largest_gain = 16.0;    // used once the exposure is longest
  double saturating_s = 0.001;   // exposure in which light 1 (white in the sun) fills the well
  double full_well_e = 10000.0;  // electrons that a pixel holds
  double read_noise_e = 8.0;     // standard deviation, electrons
  double vignetting = 0.6;       // share of the natural fall-off cos^4 of the angle to the axis
  double gamma = 2.2;            // of the response; 1: linear
};
[[nodiscard]] OptionSet describe(ImageSensorOptions& options);

struct Exposure {
  double exposure_s = 0.0;
  double gain = 1.0;
};

// Which image it is: each has noise of its own.
struct ImageNumber {
  std::uint64_t seed = 0;
  std::int64_t frame = 0;
  int camera = 0;
};

class ImageSensor {
 public:
  // Errors: options out of range.
  [[nodiscard]] static Result<ImageSensor> make(const ImageSensorOptions& options,
                                                const CameraRays& rays);

  // What automatic exposure chooses for a view, else the options' own. Of a stereo pair both
  // cameras take that of one.
  [[nodiscard]] Exposure meter(const CameraView& view) const;
  // The image of a view of this camera, grey or in colour. `image` keeps its memory. A view of
  // another size, or without what is asked for, is an error.
  [[nodiscard]] Status expose(const CameraView& view, const Exposure& exposure,
                              const ImageNumber& number, Image<std::uint8_t>& image,
                              const Context& context = {}) const;
  [[nodiscard]] Status expose(const CameraView& view, const Exposure& exposure,
                              const ImageNumber& number, Image<Rgb>& image,
                              const Context& context = {}) const;

 private:
  ImageSensor() = default;
  [[nodiscard]] Status check(const CameraView& view, bool has_light,
                             const Exposure& exposure) const;
  [[nodiscard]] SensorRow row_of(int v, const Exposure& exposure, std::uint32_t key) const;
  [[nodiscard]] double mean_byte(const CameraView& view, double scale) const;

  ImageSensorOptions options_;
  Image<float> vignetting_;
  std::vector<std::uint8_t> response_;  // by the square root of the signal
};

}  // namespace tread
