// Damaged files for the tests of readers: every shorter file, and seeded random damage. A reader
// must give a clean result either way; what else may go wrong is found by the sanitizers.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>
#include <string>
#include <string_view>

namespace tread::testing {

inline void put_file(const std::filesystem::path& path, std::string_view bytes) {
  // A new file and not the old one cut: some file systems wait for the disk after that.
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline std::string get_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

// The number of shorter files that `read` takes: read(path) says whether it did.
inline int shorter_files_taken(const std::string& valid, const std::filesystem::path& path,
                               const std::function<bool(const std::filesystem::path&)>& read) {
  int taken = 0;
  for (std::size_t size = 0; size < valid.size(); ++size) {
    put_file(path, std::string_view(valid).substr(0, size));
    if (read(path)) ++taken;
  }
  return taken;
}

// Bytes changed, pieces cut out or doubled.
inline std::string damaged(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  const std::size_t changes = 1 + below(4);
  for (std::size_t i = 0; i < changes && !bytes.empty(); ++i) {
    const std::size_t at = below(bytes.size());
    const std::size_t length = 1 + below(8);
    switch (below(6)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(below(256));
        break;
      case 2:
        bytes[at] = '\xff';
        break;
      case 3:
        bytes[at] = "0123456789.-eE \n:[{"[below(19)];
        break;
      case 4:
        bytes.erase(at, length);
        break;
      default:
        bytes.insert(at, bytes.substr(at, length));
        break;
    }
  }
  return bytes;
}

// Reads 2000 damaged versions; returns how many were refused.
inline int damaged_files_refused(const std::string& valid, const std::filesystem::path& path,
                                 const std::function<bool(const std::filesystem::path&)>& read) {
  std::mt19937 random(20240607);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    put_file(path, damaged(valid, random));
    if (!read(path)) ++refused;
  }
  return refused;
}

}  // namespace tread::testing
