#include "tread/sim/relief.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tread/sim/random.hpp"

namespace tread {
namespace {

constexpr int kWavesPerOctave = 48;

struct Wave {
  double amplitude, kx, ky, phase;
};

// The share of the variance between wave numbers a < b of a spectrum k^-exponent.
double power_between(double a, double b, double exponent) {
  const double n = 1.0 - exponent;
  return std::abs(n) < 1e-9 ? std::log(b / a) : (std::pow(b, n) - std::pow(a, n)) / n;
}

// One wave for each of equal steps of log k, anywhere within its step and in any direction. A wave
// of wave number k whose crests are slanted is slower along a line, so that a profile sees k cos of
// the slant: the spectrum of the profile keeps the exponent of the waves' all the same.
std::vector<Wave> waves_of(const NoiseOptions& options, std::uint64_t seed) {
  const double low = 2.0 * std::numbers::pi / options.longest_m,
               high = 2.0 * std::numbers::pi / options.shortest_m;
  const double octaves = std::log2(high / low);
  const int count = std::max(1, static_cast<int>(std::lround(kWavesPerOctave * octaves)));
  Random random(seed);
  std::vector<Wave> waves;
  double power = 0.0;
  for (int i = 0; i < count; ++i) {
    const double a = low * std::pow(high / low, static_cast<double>(i) / count),
                 b = low * std::pow(high / low, (i + 1.0) / count);
    const double share = power_between(a, b, options.exponent);
    const double k = a * std::pow(b / a, random.uniform());
    const double direction = std::numbers::pi * random.uniform();
    waves.push_back({std::sqrt(2.0 * share), k * std::cos(direction), k * std::sin(direction),
                     2.0 * std::numbers::pi * random.uniform()});
    power += share;
  }
  for (Wave& wave : waves) wave.amplitude *= options.rms_m / std::sqrt(power);
  return waves;
}

// 1 up to `inner`, 0 from `outer` on, smooth in between.
double fade(double distance, double inner, double outer) {
  if (distance <= inner) return 1.0;
  if (distance >= outer) return 0.0;
  const double t = (outer - distance) / (outer - inner);
  return t * t * (3.0 - 2.0 * t);
}

template <class Change>
void change_each(Grid<float>& heights, const Change& change) {
  const GridGeometry& geometry = heights.geometry;
  for (int y = 0; y < geometry.rows; ++y) {
    for (int x = 0; x < geometry.columns; ++x) {
      float& height = heights[{x, y}];
      height = static_cast<float>(change(geometry.centre({x, y}), static_cast<double>(height)));
    }
  }
}

// Along the line from its start, and off it.
struct AlongLine {
  Eigen::Vector2d from, direction;
  double length;
  explicit AlongLine(const BandOptions& band)
      : from(band.from_m),
        direction((band.to_m - band.from_m).normalized()),
        length((band.to_m - band.from_m).norm()) {}
  [[nodiscard]] double along(const Eigen::Vector2d& p) const { return direction.dot(p - from); }
  [[nodiscard]] double across(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d d = p - from;
    return std::abs(direction.x() * d.y() - direction.y() * d.x());
  }
};

}  // namespace

Grid<float> noise_relief(const GridGeometry& geometry, const NoiseOptions& options,
                         std::uint64_t seed) {
  const std::vector<Wave> waves = waves_of(options, seed);
  const auto count = static_cast<Eigen::Index>(waves.size());
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows of_x(2 * count, geometry.columns), of_y(geometry.rows, 2 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Wave& wave = waves[static_cast<std::size_t>(i)];
    for (int x = 0; x < geometry.columns; ++x) {
      const double angle = wave.kx * geometry.centre({x, 0}).x() + wave.phase;
      of_x(2 * i, x) = static_cast<float>(wave.amplitude * std::cos(angle));
      of_x(2 * i + 1, x) = static_cast<float>(-wave.amplitude * std::sin(angle));
    }
    for (int y = 0; y < geometry.rows; ++y) {
      const double angle = wave.ky * geometry.centre({0, y}).y();
      of_y(y, 2 * i) = static_cast<float>(std::cos(angle));
      of_y(y, 2 * i + 1) = static_cast<float>(std::sin(angle));
    }
  }
  Grid<float> heights(geometry);
  Eigen::Map<Rows>(heights.values.data(), geometry.rows, geometry.columns).noalias() = of_y * of_x;
  return heights;
}

void add_band(Grid<float>& heights, const BandOptions& band, double height_m) {
  const AlongLine line(band);
  change_each(heights, [&](const Eigen::Vector2d& p, double height) {
    const double s = line.along(p), half = 0.5 * band.width_m;
    const double beyond = std::max({-s, s - line.length, 0.0});
    return height + height_m * fade(line.across(p), half, half + band.bank_m) *
                        fade(beyond, 0.0, band.bank_m);
  });
}

void add_ramp(Grid<float>& heights, const BandOptions& band, double rise_m, double plateau_m) {
  const AlongLine line(band);
  change_each(heights, [&](const Eigen::Vector2d& p, double height) {
    const double s = line.along(p), half = 0.5 * band.width_m;
    const double up = std::clamp(s / line.length, 0.0, 1.0);
    return height + rise_m * up * fade(line.across(p), half, half + band.bank_m) *
                        fade(s - line.length - plateau_m, 0.0, band.bank_m);
  });
}

void add_mound(Grid<float>& heights, const Eigen::Vector2d& middle, double radius_m,
               double height_m) {
  change_each(heights, [&](const Eigen::Vector2d& p, double height) {
    return height + height_m * fade((p - middle).norm(), 0.0, radius_m);
  });
}

void level_disc(Grid<float>& heights, const Eigen::Vector2d& middle, double radius_m,
                double blend_m) {
  const GridGeometry& geometry = heights.geometry;
  const Cell centre = geometry.cell_at(middle);
  if (!geometry.contains(centre)) return;
  const double level = heights[centre];
  change_each(heights, [&](const Eigen::Vector2d& p, double height) {
    return height + (level - height) * fade((p - middle).norm(), radius_m, radius_m + blend_m);
  });
}

void level_road(Grid<float>& heights, const std::vector<Eigen::Vector2d>& line, double width_m,
                double bank_m, double smooth_m) {
  const GridGeometry& geometry = heights.geometry;
  const double step = geometry.resolution_m;
  std::vector<double> ground, profile;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Eigen::Vector2d along = line[i] - line[i - 1];
    const int count = std::max(1, static_cast<int>(std::lround(along.norm() / step)));
    for (int k = i == 1 ? 0 : 1; k <= count; ++k) {
      const Eigen::Vector2d p = line[i - 1] + static_cast<double>(k) / count * along;
      const Cell c = geometry.cell_at(p);
      ground.push_back(heights[{std::clamp(c.x, 0, geometry.columns - 1),
                                std::clamp(c.y, 0, geometry.rows - 1)}]);
    }
  }
  // Means over a window, which is shorter towards the ends.
  std::vector<double> sums{0.0};
  for (const double h : ground) sums.push_back(sums.back() + h);
  const auto last = static_cast<std::ptrdiff_t>(ground.size()) - 1,
             half = static_cast<std::ptrdiff_t>(0.5 * smooth_m / step);
  for (std::ptrdiff_t i = 0; i <= last; ++i) {
    const std::ptrdiff_t reach = std::min({half, i, last - i});
    const auto from = static_cast<std::size_t>(i - reach),
               to = static_cast<std::size_t>(i + reach + 1);
    profile.push_back((sums[to] - sums[from]) / static_cast<double>(to - from));
  }
  change_each(heights, [&](const Eigen::Vector2d& p, double height) {
    const NearestOnLine nearest = nearest_on_line(line, p);
    const double share = fade(nearest.distance_m, 0.5 * width_m, 0.5 * width_m + bank_m);
    if (share <= 0.0) return height;
    const double at = std::clamp(nearest.way_m / step, 0.0, static_cast<double>(last));
    const auto i = std::min(static_cast<std::size_t>(at), profile.size() - 2);
    const double b = at - static_cast<double>(i);
    return height + share * ((1.0 - b) * profile[i] + b * profile[i + 1] - height);
  });
}

NearestOnLine nearest_on_line(const std::vector<Eigen::Vector2d>& line,
                              const Eigen::Vector2d& place) {
  NearestOnLine nearest{(place - line.front()).norm(), 0.0};
  double before = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Eigen::Vector2d step = line[i] - line[i - 1];
    const double length = step.norm();
    const double share =
        length > 0.0 ? std::clamp(step.dot(place - line[i - 1]) / (length * length), 0.0, 1.0)
                     : 0.0;
    const double distance = (line[i - 1] + share * step - place).norm();
    if (distance < nearest.distance_m) nearest = {distance, before + share * length};
    before += length;
  }
  return nearest;
}

}  // namespace tread
