// What a recording (data_set_writer.hpp) has beyond EuRoC: the tables of the other sensors, and its
// description. Lines that are left out are told as read_imu does it; times increase strictly.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/geometry/samples.hpp"

namespace tread {

// "time in ns,x,y,z,sigma_level,sigma_up" a line, metres; sigmas not below 0.
[[nodiscard]] Result<std::vector<GnssFix>> read_gnss(const std::filesystem::path& path,
                                                     std::vector<Error>* problems = nullptr);
// "time in ns,left,right,left_current,right_current" a line, rad and A.
[[nodiscard]] Result<std::vector<WheelSample>> read_wheels(const std::filesystem::path& path,
                                                           std::vector<Error>* problems = nullptr);
// "time in ns", 12 positions, 12 velocities, 12 torques, 4 times x, y, z of a foot's force.
[[nodiscard]] Result<std::vector<LegSample>> read_legs(const std::filesystem::path& path,
                                                       std::vector<Error>* problems = nullptr);
// "time in ns,pan,tilt" a line, rad.
[[nodiscard]] Result<std::vector<HeadState>> read_head(const std::filesystem::path& path,
                                                       std::vector<Error>* problems = nullptr);
// "time in ns,pressed" a line, 0 or 1.
[[nodiscard]] Result<std::vector<BumpEvent>> read_bumps(const std::filesystem::path& path,
                                                        std::vector<Error>* problems = nullptr);

struct RecordingInfo {
  std::string description;
  int heads = 0;
  std::vector<std::pair<std::string, std::int64_t>> samples;  // "gnss0", 12
};

// Whether a folder has a recording.yaml.
[[nodiscard]] bool is_recording(const std::filesystem::path& folder);
// What it says.
[[nodiscard]] Result<RecordingInfo> read_recording_info(const std::filesystem::path& folder);

}  // namespace tread
