// Finds the stereo images of a folder and says which belong together. Looks at names only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tread/core/result.hpp"

namespace tread {

struct StereoFolder {
  enum class Kind { kKitti, kLeftRight };
  struct Frame {
    std::string name;             // stem of the files
    std::filesystem::path left;   // empty: there is none of this name
    std::filesystem::path right;  // likewise
    std::int64_t number = 0;      // counted from 0, or what the name says
    std::int64_t stamp_ns = 0;    // what the name says, or number at 10 Hz
  };
  Kind kind = Kind::kLeftRight;
  std::string left_folder;  // "image_0"; empty for NAME_left beside NAME_right
  std::vector<Frame> frames;
};

// Fails if no images are found, with a list of what is understood, and if two files of one camera
// have the same stem.
[[nodiscard]] Result<StereoFolder> find_stereo_folder(const std::filesystem::path& path);

}  // namespace tread
