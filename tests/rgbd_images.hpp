// Small RGB-D images for the tests of their sources, and what a source makes of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "file_mutations.hpp"
#include "sample_images.hpp"
#include "tread/io/rgbd_source.hpp"

namespace tread::testing {

// 4 x 3 pixels of 16 bits: 0, 65535, then all of `value`.
inline std::string depth_png(int value, int width = 4, int height = 3) {
  std::string rows;
  for (int i = 0; i < width * height; ++i) {
    const int stored = i == 0 ? 0 : i == 1 ? 65535 : value;
    rows += {static_cast<char>(stored >> 8), static_cast<char>(stored & 0xff)};
  }
  return make_png(width, height, 16, 0, rows);
}

inline std::string colour_png(char value, int width = 4, int height = 3) {
  return make_png(width, height, 8, 2,
                  std::string(static_cast<std::size_t>(3 * width * height), value));
}

inline void put(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::create_directories(path.parent_path());
  put_file(path, bytes);
}

struct RgbdRead {
  std::vector<RgbdFrame> frames;
  std::vector<Error> errors;
  std::string taken;  // one letter a frame: x, or - for refused
};

inline RgbdRead read_all(RgbdSource& source) {
  RgbdRead read;
  for (;;) {
    auto next = source.next();
    if (next && !*next) return read;
    read.taken += next ? 'x' : '-';
    if (next) {
      read.frames.push_back(std::move(**next));
    } else {
      read.errors.push_back(next.error());
    }
  }
}

inline bool mentions(const Error& error, const std::string& text) {
  return error.message().find(text) != std::string::npos;
}

}  // namespace tread::testing
