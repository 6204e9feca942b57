// Palettes: control colours -> tables of 256 sRGB colours. A colour that sRGB cannot show loses
// chroma until it can; lightness and hue are kept, because the eye reads the value from them.
#include "palette.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>

namespace tread {
namespace {

constexpr int kColours = 256;
using Table = std::array<Rgb, kColours>;

struct Oklab {
  double lightness, a, b;
};
struct LinearRgb {
  double r, g, b;
};

// Lightness 0 to 1, chroma, hue in degrees.
struct Control {
  double lightness, chroma, hue_deg;
};

Oklab to_oklab(const Control& c) {
  const double hue = c.hue_deg * std::numbers::pi / 180.0;
  return {c.lightness, c.chroma * std::cos(hue), c.chroma * std::sin(hue)};
}

LinearRgb to_linear(const Oklab& lab) {
  const auto cube = [](double v) { return v * v * v; };
  const double l = cube(lab.lightness + 0.3963377774 * lab.a + 0.2158037573 * lab.b);
  const double m = cube(lab.lightness - 0.1055613458 * lab.a - 0.0638541728 * lab.b);
  const double s = cube(lab.lightness - 0.0894841775 * lab.a - 1.2914855480 * lab.b);
  return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
          -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
          -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

bool can_be_shown(const LinearRgb& c) {
  const auto inside = [](double v) { return v >= -1e-6 && v <= 1.0 + 1e-6; };
  return inside(c.r) && inside(c.g) && inside(c.b);
}

std::uint8_t to_byte(double linear) {
  const double v = std::clamp(linear, 0.0, 1.0);
  const double encoded = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * encoded));
}

Rgb to_rgb(const Oklab& lab) {
  double share = 1.0;  // of the chroma
  LinearRgb linear = to_linear(lab);
  for (int i = 0; i < 100 && !can_be_shown(linear); ++i) {
    share -= 0.01;
    linear = to_linear({lab.lightness, share * lab.a, share * lab.b});
  }
  return {to_byte(linear.r), to_byte(linear.g), to_byte(linear.b)};
}

Table make_table(std::span<const Control> controls) {
  Table table;
  const double last = static_cast<double>(controls.size() - 1);
  for (int i = 0; i < kColours; ++i) {
    const double position = last * i / (kColours - 1);
    const std::size_t k = std::min(static_cast<std::size_t>(position), controls.size() - 2);
    const double t = position - static_cast<double>(k);
    const Oklab from = to_oklab(controls[k]), to = to_oklab(controls[k + 1]);
    table[static_cast<std::size_t>(i)] =
        to_rgb({std::lerp(from.lightness, to.lightness, t), std::lerp(from.a, to.a, t),
                std::lerp(from.b, to.b, t)});
  }
  return table;
}

constexpr std::array<Control, 7> kHeightControls{{{0.27, 0.12, 300},
                                                  {0.38, 0.13, 282},
                                                  {0.49, 0.11, 240},
                                                  {0.60, 0.11, 190},
                                                  {0.71, 0.15, 158},
                                                  {0.82, 0.18, 130},
                                                  {0.93, 0.18, 105}}};
constexpr std::array<Control, 7> kCostControls{{{0.13, 0.04, 285},
                                                {0.26, 0.14, 295},
                                                {0.39, 0.17, 325},
                                                {0.52, 0.19, 5},
                                                {0.65, 0.19, 38},
                                                {0.78, 0.17, 68},
                                                {0.91, 0.17, 98}}};
constexpr std::array<Control, 8> kDisparityControls{{{0.32, 0.15, 285},
                                                     {0.52, 0.19, 264},
                                                     {0.70, 0.14, 225},
                                                     {0.82, 0.16, 165},
                                                     {0.88, 0.20, 122},
                                                     {0.80, 0.17, 78},
                                                     {0.63, 0.21, 42},
                                                     {0.42, 0.17, 27}}};
constexpr std::array<Control, 2> kGreyControls{{{0.15, 0.0, 0}, {1.0, 0.0, 0}}};

const Table& table_of(Palette palette) {
  static const Table height = make_table(kHeightControls);
  static const Table cost = make_table(kCostControls);
  static const Table disparity = make_table(kDisparityControls);
  static const Table grey = make_table(kGreyControls);
  switch (palette) {
    case Palette::kHeight:
      return height;
    case Palette::kCost:
      return cost;
    case Palette::kDisparity:
      return disparity;
    case Palette::kGrey:
      break;
  }
  return grey;
}

}  // namespace

Rgb palette_colour(Palette palette, double share) {
  const double index = std::round(std::clamp(share, 0.0, 1.0) * (kColours - 1));
  return table_of(palette)[static_cast<std::size_t>(index)];
}

std::string hex_colour(Rgb colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.r, colour.g, colour.b);
}

}  // namespace tread
