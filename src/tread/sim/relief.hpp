// Shapes of the ground: noise of a stated spectrum, ramps, ditches, mounds.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tread/core/grid.hpp"

namespace tread {

// Gaussian roughness whose profiles along any line have a one-sided power spectrum proportional to
// k^-exponent between two wavelengths, and nothing outside: what surveys of natural ground find,
// with exponents from 2 to 3 (Sayles and Thomas, Nature 271, 1978; ISO 8608 takes 2 for roads).
struct NoiseOptions {
  double rms_m = 0.05;      // standard deviation of the heights
  double longest_m = 5.0;   // wavelengths
  double shortest_m = 0.1;  // at least two cells
  double exponent = 2.2;
};

// At the centres of the cells. A sum of plane waves, 48 an octave, their directions and phases by
// the seed: cos(kx x + ky y + p) splits into products of x and y alone, so that the sum is one
// product of matrices (0.1 us a cell and octave).
[[nodiscard]] Grid<float> noise_relief(const GridGeometry& geometry, const NoiseOptions& options,
                                       std::uint64_t seed);

// A band along a line: heights are raised (or lowered) within it.
struct BandOptions {
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_m = Eigen::Vector2d::UnitX();
  double width_m = 1.0;  // of the flat part across the line
  double bank_m = 0.2;   // from the flat part to the ground beside it
};

// Adds `height_m` (negative: a ditch) within the band, less on its banks, whose profile is smooth.
void add_band(Grid<float>& heights, const BandOptions& band, double height_m);
// Adds a way up: nothing at its start, `rise_m` at its end and beyond within the band's length of a
// plateau.
void add_ramp(Grid<float>& heights, const BandOptions& band, double rise_m, double plateau_m);
// Adds a round hill (negative: a hollow): height_m in the middle, nothing from the radius on.
void add_mound(Grid<float>& heights, const Eigen::Vector2d& middle, double radius_m,
               double height_m);
// Makes a disc level at the height of its middle, blending into the ground around over blend_m.
void level_disc(Grid<float>& heights, const Eigen::Vector2d& middle, double radius_m,
                double blend_m);

// Makes a road along a line: level across, and along it as high as the ground is on the mean over
// smooth_m of the way; its banks blend into the ground beside it.
void level_road(Grid<float>& heights, const std::vector<Eigen::Vector2d>& line, double width_m,
                double bank_m, double smooth_m);

// The nearest point of a line through places: how far away it is, and how far along the line.
struct NearestOnLine {
  double distance_m = 0.0;
  double way_m = 0.0;
};
[[nodiscard]] NearestOnLine nearest_on_line(const std::vector<Eigen::Vector2d>& line,
                                            const Eigen::Vector2d& place);

}  // namespace tread
