// Values to colours, images and grids to pictures. Rows of a grid are turned over, so that y points
// up in the picture. Cost: linear in the pixels, value_range sorts partly.
#include "pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tread {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

ImageView<const float> view_of(const Grid<float>& grid) {
  return {grid.values.data(), grid.geometry.columns, grid.geometry.rows, grid.geometry.columns};
}

// Slope of the heights along one axis from the known neighbours; zero where there is none.
double slope_along(const Grid<float>& height, Cell c, Cell step) {
  const Cell before{c.x - step.x, c.y - step.y}, after{c.x + step.x, c.y + step.y};
  const auto known = [&](Cell n) {
    return height.geometry.contains(n) && std::isfinite(height[n]);
  };
  const Cell low = known(before) ? before : c, high = known(after) ? after : c;
  const int cells = (high.x - low.x) + (high.y - low.y);
  if (cells == 0) return 0.0;
  return (height[high] - height[low]) / (cells * height.geometry.resolution_m);
}

// 1 on level ground, more where the ground faces the light, down to 0 where it faces away.
double relief_light(const Grid<float>& height, Cell c, double exaggeration) {
  const Eigen::Vector3d normal =
      Eigen::Vector3d(-exaggeration * slope_along(height, c, {1, 0}),
                      -exaggeration * slope_along(height, c, {0, 1}), 1.0)
          .normalized();
  const Eigen::Vector3d to_light = Eigen::Vector3d(-1.0, 1.0, std::sqrt(2.0)).normalized();
  return std::max(0.0, normal.dot(to_light)) / to_light.z();
}

Rgb lit(Rgb colour, double light) {
  constexpr double kAmbient = 0.3;
  const double factor = kAmbient + (1.0 - kAmbient) * light;
  const auto channel = [factor](std::uint8_t v) {
    // What is brighter than level ground goes towards white, so that the hue stays.
    const double bright = factor > 1.0 ? v + (255.0 - v) * (factor - 1.0) : v * factor;
    return static_cast<std::uint8_t>(std::lround(std::clamp(bright, 0.0, 255.0)));
  };
  return {channel(colour.r), channel(colour.g), channel(colour.b)};
}

template <class ColourOfCell>
MapPicture paint_map(const Grid<float>& values, int wanted_px, const ColourOfCell& colour) {
  const GridGeometry& g = values.geometry;
  const int factor = std::max(1, wanted_px / std::max({1, g.columns, g.rows}));
  Image<Rgb> cells(g.columns, g.rows);
  for (int y = 0; y < g.rows; ++y) {
    for (int x = 0; x < g.columns; ++x) cells(x, g.rows - 1 - y) = colour(Cell{x, y});
  }
  return {enlarge(cells, factor), g.origin, factor / g.resolution_m};
}

int shrink_factor(const Grid<float>& values, int wanted_px) {
  const int longer = std::max(values.geometry.columns, values.geometry.rows);
  return std::max(1, (longer + wanted_px - 1) / wanted_px);
}

}  // namespace

Rgb colour_of(const ColourScale& scale, float value) {
  if (scale.lethal_from && value >= *scale.lethal_from) return scale.lethal;
  if (!std::isfinite(value)) return scale.unknown;
  const double span = static_cast<double>(scale.high) - scale.low;
  return colour_at(scale, span > 0.0 ? (value - scale.low) / span : 0.0);
}

Rgb colour_at(const ColourScale& scale, double share) {
  return palette_colour(scale.palette, scale.reversed ? 1.0 - share : share);
}

ValueRange value_range(ImageView<const float> values, double outlier_share) {
  std::vector<float> known;
  for (int y = 0; y < values.height; ++y) {
    std::copy_if(values.row(y), values.row(y) + values.width, std::back_inserter(known),
                 [](float v) { return std::isfinite(v); });
  }
  if (known.empty()) return {};
  const auto rank = [&](double share) {
    const auto nth = known.begin() + std::lround(share * static_cast<double>(known.size() - 1));
    std::nth_element(known.begin(), nth, known.end());
    return *nth;
  };
  ValueRange range{rank(outlier_share), rank(1.0 - outlier_share)};
  // A flat scene gets a range of one part in a thousand around it, not a division by zero.
  const float least = std::max(1e-6F, 1e-3F * std::abs(range.low));
  if (range.high - range.low < least) range = {range.low - least, range.high + least};
  return range;
}

ValueRange value_range(const Grid<float>& values, double outlier_share) {
  return value_range(view_of(values), outlier_share);
}

Image<Rgb> colour_map(ImageView<const float> values, const ColourScale& scale) {
  Image<Rgb> picture(values.width, values.height);
  for (int y = 0; y < values.height; ++y) {
    for (int x = 0; x < values.width; ++x) picture(x, y) = colour_of(scale, values(x, y));
  }
  return picture;
}

Image<Rgb> colour_map(ImageView<const float> values, float low, float high, Palette palette,
                      Rgb unknown) {
  ColourScale scale;
  scale.palette = palette;
  scale.low = low;
  scale.high = high;
  scale.unknown = unknown;
  return colour_map(values, scale);
}

Image<Rgb> grey_picture(ImageView<const std::uint8_t> grey) {
  Image<Rgb> picture(grey.width, grey.height);
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      const std::uint8_t v = grey(x, y);
      picture(x, y) = {v, v, v};
    }
  }
  return picture;
}

Image<Rgb> enlarge(ImageView<const Rgb> picture, int factor) {
  Image<Rgb> large(picture.width * factor, picture.height * factor);
  for (int y = 0; y < large.height; ++y) {
    for (int x = 0; x < large.width; ++x) large(x, y) = picture(x / factor, y / factor);
  }
  return large;
}

Image<Rgb> side_by_side(ImageView<const Rgb> left, ImageView<const Rgb> right, int gap_px) {
  Image<Rgb> both(left.width + gap_px + right.width, std::max(left.height, right.height),
                  kUnknownColour);
  for (int y = 0; y < left.height; ++y) {
    std::copy(left.row(y), left.row(y) + left.width, both.row(y));
  }
  for (int y = 0; y < right.height; ++y) {
    std::copy(right.row(y), right.row(y) + right.width, both.row(y) + left.width + gap_px);
  }
  return both;
}

Grid<float> crop_to_known(const Grid<float>& values, int margin_cells) {
  const GridGeometry& g = values.geometry;
  Cell low{g.columns, g.rows}, high{-1, -1};
  for (int y = 0; y < g.rows; ++y) {
    for (int x = 0; x < g.columns; ++x) {
      if (std::isnan(values[{x, y}])) continue;
      low = {std::min(low.x, x), std::min(low.y, y)};
      high = {std::max(high.x, x), std::max(high.y, y)};
    }
  }
  if (high.x < 0) return values;
  low = {std::max(0, low.x - margin_cells), std::max(0, low.y - margin_cells)};
  high = {std::min(g.columns - 1, high.x + margin_cells),
          std::min(g.rows - 1, high.y + margin_cells)};
  Grid<float> part(GridGeometry{g.resolution_m,
                                g.origin + g.resolution_m * Eigen::Vector2d(low.x, low.y),
                                high.x - low.x + 1, high.y - low.y + 1});
  for (int y = 0; y < part.geometry.rows; ++y) {
    for (int x = 0; x < part.geometry.columns; ++x) {
      part[{x, y}] = values[{low.x + x, low.y + y}];
    }
  }
  return part;
}

Grid<float> shrink(const Grid<float>& values, int factor) {
  const GridGeometry& g = values.geometry;
  const auto joined = [factor](int cells) { return (cells + factor - 1) / factor; };
  Grid<float> small(
      GridGeometry{g.resolution_m * factor, g.origin, joined(g.columns), joined(g.rows)});
  for (int y = 0; y < small.geometry.rows; ++y) {
    for (int x = 0; x < small.geometry.columns; ++x) {
      double sum = 0.0;
      int count = 0;
      for (int v = y * factor; v < std::min((y + 1) * factor, g.rows); ++v) {
        for (int u = x * factor; u < std::min((x + 1) * factor, g.columns); ++u) {
          if (std::isnan(values[{u, v}])) continue;
          sum += values[{u, v}];
          ++count;
        }
      }
      small[{x, y}] = count == 0 ? kUnknown : static_cast<float>(sum / count);
    }
  }
  return small;
}

MapPicture draw_map(const Grid<float>& values, const ColourScale& scale, int wanted_px) {
  const int factor = shrink_factor(values, wanted_px);
  if (factor > 1) return draw_map(shrink(values, factor), scale, wanted_px);
  return paint_map(values, wanted_px, [&](Cell c) { return colour_of(scale, values[c]); });
}

MapPicture draw_relief(const Grid<float>& height, const ColourScale& scale, int wanted_px,
                       double exaggeration) {
  const int factor = shrink_factor(height, wanted_px);
  if (factor > 1) return draw_relief(shrink(height, factor), scale, wanted_px, exaggeration);
  return paint_map(height, wanted_px, [&](Cell c) {
    const Rgb colour = colour_of(scale, height[c]);
    return std::isfinite(height[c]) ? lit(colour, relief_light(height, c, exaggeration)) : colour;
  });
}

std::string number_text(double value, const std::string& unit) {
  const double size = std::abs(value);
  std::string text;
  if (!std::isfinite(value)) {
    text = std::isnan(value) ? "unknown" : fmt::format("{}", value);
  } else if (size != 0.0 && (size < 1e-3 || size >= 1e5)) {
    text = fmt::format("{:.2e}", value);
  } else {
    text = fmt::format("{:.{}f}", value, size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3);
    if (text.find('.') != std::string::npos) {
      text.erase(text.find_last_not_of('0') + 1);
      if (text.back() == '.') text.pop_back();
    }
    if (text == "-0") text = "0";
  }
  return unit.empty() ? text : text + " " + unit;
}

std::vector<double> round_ticks(double low, double high, int count) {
  if (!(high > low) || count < 1) return {};
  const double raw = (high - low) / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double lead = raw / power;
  const double step = power * (lead < 1.5 ? 1.0 : lead < 3.5 ? 2.0 : lead < 7.5 ? 5.0 : 10.0);
  std::vector<double> ticks;
  for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i += 1.0) {
    ticks.push_back(i * step);
  }
  return ticks;
}

}  // namespace tread
