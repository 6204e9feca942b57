// Finds the depth and colour images of a folder and says which belong together: names, lists and
// poses. Looks into no image.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/geometry/trajectory.hpp"
#include "tread/io/rgbd_camera.hpp"

namespace tread {

struct RgbdFolder {
  enum class Kind { kFrames, kTum, kList };
  struct Frame {
    std::string name;              // stem of the depth image
    std::filesystem::path depth;   // empty: there is only colour of this name
    std::filesystem::path colour;  // empty: there is none
    std::int64_t stamp_ns = 0;
    std::optional<Isometry3d> T_world_camera;
  };
  Kind kind = Kind::kFrames;
  std::filesystem::path path;          // the folder that the images are in or named from
  std::vector<Frame> frames;           // by time, no two of one time
  double depth_per_metre = 1000.0;     // units of the depth images
  bool full_depth_is_unknown = false;  // 65535 means that nothing was measured, as 0 does
  std::optional<RgbdCamera> camera;    // only a list brings one
  Trajectory truth;                    // all poses that are there
  std::vector<Error> problems;         // lines and poses that are left out
};

// See open_rgbd_source for what is understood. Fails if there are no frames, with a list of that.
[[nodiscard]] Result<RgbdFolder> find_rgbd_folder(const std::filesystem::path& path);

// True for what find_rgbd_folder would try to read, be it damaged. Reads names, and of seq.txt its
// head.
[[nodiscard]] bool looks_like_rgbd(const std::filesystem::path& path);

namespace internal {

// Internal to io: the kinds that are described by lists, in rgbd_lists.cpp.
// `associations`: the file of that purpose; empty if there is none.
[[nodiscard]] Result<RgbdFolder> read_tum_folder(const std::filesystem::path& path,
                                                 const std::filesystem::path& associations);
[[nodiscard]] Result<RgbdFolder> read_rgbd_list(const std::filesystem::path& file);

// "frame-000012" of frame-000012.depth.png.
[[nodiscard]] std::string rgbd_frame_name(const std::filesystem::path& depth);

}  // namespace internal
}  // namespace tread
