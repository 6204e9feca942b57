// TIFF files and grids for the tests of raster files.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "tread/core/grid.hpp"

namespace tread::testing {

inline constexpr int kShort = 3, kLong = 4, kDouble = 12, kAscii = 2;

template <class T>
std::string packed(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

// A little-endian TIFF written from the specification, without libtiff: one strip or tile after
// another right behind the head, then the directory.
class TiffMaker {
 public:
  TiffMaker(std::uint32_t width, std::uint32_t height) {
    set_long(256, {width});
    set_long(257, {height});
    set_short(258, {32});     // bits
    set_short(259, {1});      // not compressed
    set_short(262, {1});      // black is zero
    set_short(277, {1});      // bands
    set_short(339, {3});      // floating point
    set_long(278, {height});  // rows a strip
  }
  void set_short(int tag, const std::vector<std::uint16_t>& v) {
    tags_[tag] = {kShort, v.size(), packed(v)};
  }
  void set_long(int tag, const std::vector<std::uint32_t>& v) {
    tags_[tag] = {kLong, v.size(), packed(v)};
  }
  void set_double(int tag, const std::vector<double>& v) {
    tags_[tag] = {kDouble, v.size(), packed(v)};
  }
  void set_text(int tag, const std::string& text) {
    tags_[tag] = {kAscii, text.size() + 1, text + '\0'};
  }
  void drop(int tag) { tags_.erase(tag); }
  // The pixels, by strips (tags 273, 279) or by tiles (324, 325).
  std::string make(const std::vector<std::string>& parts, bool tiled = false) {
    std::vector<std::uint32_t> places, sizes;
    std::string body;
    for (const std::string& part : parts) {
      places.push_back(static_cast<std::uint32_t>(8 + body.size()));
      sizes.push_back(static_cast<std::uint32_t>(part.size()));
      body += part;
    }
    set_long(tiled ? 324 : 273, places);
    set_long(tiled ? 325 : 279, sizes);
    if (body.size() % 2 != 0) body += '\0';
    const std::size_t directory = 8 + body.size();
    const std::size_t values_at = directory + 2 + 12 * tags_.size() + 4;
    std::string entries, values;
    for (const auto& [tag, field] : tags_) {
      entries += packed<std::uint16_t>(
          {static_cast<std::uint16_t>(tag), static_cast<std::uint16_t>(field.type)});
      entries += packed<std::uint32_t>({static_cast<std::uint32_t>(field.count)});
      if (field.bytes.size() <= 4) {
        entries += field.bytes + std::string(4 - field.bytes.size(), '\0');
      } else {
        entries += packed<std::uint32_t>({static_cast<std::uint32_t>(values_at + values.size())});
        values += field.bytes + std::string(field.bytes.size() % 2, '\0');
      }
    }
    return std::string("II*\0", 4) +
           packed<std::uint32_t>({static_cast<std::uint32_t>(directory)}) + body +
           packed<std::uint16_t>({static_cast<std::uint16_t>(tags_.size())}) + entries +
           std::string(4, '\0') + values;
  }

 private:
  struct Field {
    int type;
    std::size_t count;
    std::string bytes;
  };
  std::map<int, Field> tags_;
};

// 3 x 2 pixels: 1 2 3 above 4 5 6, at pixel size 0.5, upper left corner (10, 20).
inline TiffMaker small_geotiff() {
  TiffMaker maker(3, 2);
  maker.set_double(33550, {0.5, 0.5, 0.0});
  maker.set_double(33922, {0, 0, 0, 10, 20, 0});
  return maker;
}
inline const std::string kSixPixels = packed<float>({1, 2, 3, 4, 5, 6});

inline Grid<float> random_grid(int columns, int rows) {
  GridGeometry geometry;
  geometry.resolution_m = 0.1;
  geometry.origin = {-3.05, 12.5};
  geometry.columns = columns;
  geometry.rows = rows;
  Grid<float> grid(geometry);
  std::mt19937 random(3);
  for (float& value : grid.values) {
    // Every pattern of bits, among them infinite and NaN ones with payloads.
    value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
  }
  grid.values[0] = std::numeric_limits<float>::quiet_NaN();
  return grid;
}

inline bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

}  // namespace tread::testing
