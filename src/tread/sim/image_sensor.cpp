#include "tread/sim/image_sensor.hpp"

#include <algorithm>
#include <cmath>

#include "tread/core/parallel.hpp"
#include "tread/sim/hash_noise_kernel.hpp"
#include "tread/sim/image_sensor_kernel.hpp"

namespace tread {
namespace {

constexpr int kRows = 16;  // of a chunk

// One number for all the noise of a channel of an image.
std::uint32_t key_of(const ImageNumber& number, std::uint32_t channel) {
  std::uint32_t key = hash_mix(static_cast<std::uint32_t>(number.seed));
  key = hash_mix(key ^ static_cast<std::uint32_t>(number.seed >> 32));
  key = hash_mix(key ^ static_cast<std::uint32_t>(number.frame));
  key = hash_mix(key ^ static_cast<std::uint32_t>(static_cast<std::uint64_t>(number.frame) >> 32));
  return hash_mix(key ^ (4U * static_cast<std::uint32_t>(number.camera) + channel));
}

std::size_t place_of(double signal) {
  return static_cast<std::size_t>(std::sqrt(std::clamp(signal, 0.0, 1.0)) * (kResponseSteps - 1) +
                                  0.5);
}

}  // namespace

OptionSet describe(ImageSensorOptions& options) {
  OptionSet set;
  set.add("automatic", options.automatic, "exposure and gain are chosen for target_mean");
  set.add("exposure_s", options.exposure_s, "of each row, unless automatic, s", 1e-7, 10.0);
  set.add("gain", options.gain, "of the amplifier, unless automatic", 0.01, 1000.0);
  set.add("target_mean", options.target_mean, "of the image, if automatic, of 255", 1.0, 254.0);
  set.add("shortest_s", options.shortest_s, "exposure, if automatic, s", 1e-7, 10.0);
  set.add("longest_s", options.longest_s, "exposure, if automatic, s", 1e-7, 10.0);
  set.add("largest_gain", options.largest_gain, "if automatic", 1.0, 1000.0);
  set.add("saturating_s", options.saturating_s, "exposure in which white in the sun saturates, s",
          1e-7, 10.0);
  set.add("full_well_e", options.full_well_e, "electrons that a pixel holds", 100.0, 1e7);
  set.add("read_noise_e", options.read_noise_e, "standard deviation, electrons", 0.0, 1e4);
  set.add("vignetting", options.vignetting, "share of the natural fall-off to the corners", 0.0,
          1.0);
  set.add("gamma", options.gamma, "of the response; 1: linear", 0.5, 4.0);
  set.require({"shortest_s", "longest_s"},
              "the shortest exposure must not be longer than the longest",
              [&options] { return options.shortest_s <= options.longest_s; });
  return set;
}

Result<ImageSensor> ImageSensor::make(const ImageSensorOptions& options, const CameraRays& rays) {
  if (Status sound = check_options(options); !sound) return forward(sound);
  ImageSensor sensor;
  sensor.options_ = options;
  sensor.vignetting_.resize(rays.pixels.width, rays.pixels.height);
  for (int v = 0; v < rays.pixels.height; ++v) {
    for (int u = 0; u < rays.pixels.width; ++u) {
      const double cosine = std::max(rays.pixels(u, v).z, 0.0);
      const double natural = cosine * cosine * cosine * cosine;
      sensor.vignetting_(u, v) = static_cast<float>(1.0 + options.vignetting * (natural - 1.0));
    }
  }
  sensor.response_.resize(kResponseSteps);
  for (std::size_t i = 0; i < sensor.response_.size(); ++i) {
    const double root = static_cast<double>(i) / (kResponseSteps - 1);
    sensor.response_[i] =
        static_cast<std::uint8_t>(std::lround(255.0 * std::pow(root, 2.0 / options.gamma)));
  }
  return sensor;
}

// Of every eighth pixel each way, if light 1 becomes the signal `scale`.
double ImageSensor::mean_byte(const CameraView& view, double scale) const {
  constexpr int kStep = 8;
  double sum = 0.0, count = 0.0;
  for (int v = kStep / 2; v < view.grey.height; v += kStep) {
    for (int u = kStep / 2; u < view.grey.width; u += kStep) {
      const auto light = static_cast<double>(view.grey(u, v) * vignetting_(u, v));
      sum += response_[place_of(scale * light)];
      ++count;
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

Exposure ImageSensor::meter(const CameraView& view) const {
  if (!options_.automatic || !same_size(view.grey, vignetting_)) {
    return {options_.exposure_s, options_.gain};
  }
  // The mean grows with the scale: halve what it lies in, by ratio.
  double low = options_.shortest_s / options_.saturating_s,
         high = options_.longest_s / options_.saturating_s * options_.largest_gain;
  constexpr int kHalvings = 14;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(low * high);
    (mean_byte(view, middle) < options_.target_mean ? low : high) = middle;
  }
  const double wanted_s = std::sqrt(low * high) * options_.saturating_s;
  const double exposure_s = std::clamp(wanted_s, options_.shortest_s, options_.longest_s);
  return {exposure_s, std::clamp(wanted_s / exposure_s, 1.0, options_.largest_gain)};
}

Status ImageSensor::check(const CameraView& view, bool has_light, const Exposure& exposure) const {
  if (!same_size(view.depth, vignetting_) || !has_light) {
    return fail(ErrorCode::kBadArgument,
                "the view is not one of this camera, or has no light of it", "view",
                "Render it with the rays of this camera, with light, and colour if asked");
  }
  if (!(exposure.exposure_s > 0.0) || !(exposure.gain > 0.0) ||
      !std::isfinite(exposure.exposure_s * exposure.gain)) {
    return fail(ErrorCode::kBadValue, "exposure and gain are not above 0", "exposure",
                "Take those of meter()");
  }
  return {};
}

Status ImageSensor::expose(const CameraView& view, const Exposure& exposure,
                           const ImageNumber& number, Image<std::uint8_t>& image,
                           const Context& context) const {
  const ScopedTimer timer(context, "sim/expose");
  const bool has_light = same_size(view.grey, vignetting_);
  if (Status sound = check(view, has_light, exposure); !sound) return sound;
  image.resize(vignetting_.width, vignetting_.height);
  const std::uint32_t key = key_of(number, 3);
  parallel_chunks(context, 0, image.height, kRows, [&](int first, int last) {
    for (int v = first; v < last; ++v) {
      SensorRow row = row_of(v, exposure, key);
      row.light = view.grey.row(v);
      row.out = image.row(v);
      expose_row(row);
    }
  });
  return {};
}

Status ImageSensor::expose(const CameraView& view, const Exposure& exposure,
                           const ImageNumber& number, Image<Rgb>& image,
                           const Context& context) const {
  const ScopedTimer timer(context, "sim/expose");
  const bool has_light = same_size(view.colour, vignetting_);
  if (Status sound = check(view, has_light, exposure); !sound) return sound;
  image.resize(vignetting_.width, vignetting_.height);
  parallel_chunks(context, 0, image.height, kRows, [&](int first, int last) {
    for (int v = first; v < last; ++v) {
      for (std::uint32_t channel = 0; channel < 3; ++channel) {
        SensorRow row = row_of(v, exposure, key_of(number, channel));
        row.light = &view.colour.row(v)->r + channel;
        row.step = 3;
        row.out = &image.row(v)->r + channel;
        row.out_step = 3;
        expose_row(row);
      }
    }
  });
  return {};
}

SensorRow ImageSensor::row_of(int v, const Exposure& exposure, std::uint32_t key) const {
  SensorRow row;
  row.vignetting = vignetting_.row(v);
  row.count = vignetting_.width;
  row.electrons =
      static_cast<float>(exposure.exposure_s / options_.saturating_s * options_.full_well_e);
  row.full_well = static_cast<float>(options_.full_well_e);
  row.read_variance = static_cast<float>(options_.read_noise_e * options_.read_noise_e);
  row.gain = static_cast<float>(exposure.gain);
  row.key = hash_mix(key ^ (static_cast<std::uint32_t>(v) * kHashStepY));
  row.response = response_.data();
  return row;
}

}  // namespace tread
