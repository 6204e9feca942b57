// What the tests of the program share: running it as a user does, and a small drive.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "synthetic_drive.hpp"
#include "test_data.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread::testing {

namespace fs = std::filesystem;

struct Ran {
  int status = -1;
  std::string out;
  std::string err;
  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(out); }
};

inline Ran run(const std::string& command) {
  const ScratchFolder scratch;
  const std::string err = (scratch / "err").string();
  Ran ran;
  FILE* pipe = popen((command + " 2>" + err).c_str(), "r");
  EXPECT_NE(pipe, nullptr);
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    ran.out.append(buffer.data(), n);
  }
  const int ended = pclose(pipe);
  ran.status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -ended;
  ran.err = read_file(err).value_or("");
  return ran;
}

inline Ran tread(const std::string& arguments) {
  return run(std::string(TREAD_PROGRAM) + " " + arguments);
}

// Expects a failure whose message holds all of the words.
inline void expect_refused(const std::string& arguments, const std::vector<std::string>& words,
                           int status = 1) {
  const Ran ran = tread(arguments);
  EXPECT_EQ(ran.status, status) << arguments << "\n" << ran.out << ran.err;
  EXPECT_TRUE(ran.err.starts_with("tread: ")) << arguments << "\n" << ran.err;
  EXPECT_EQ(ran.err.find("?."), std::string::npos) << ran.err;
  EXPECT_EQ(ran.err.find(".tread-"), std::string::npos) << ran.err;
  for (const std::string& word : words) {
    EXPECT_NE(ran.err.find(word), std::string::npos) << arguments << "\n" << ran.err << word;
  }
}

// Four frames towards a block, written once and copied by each test.
inline const fs::path& drive() {
  static const ScratchFolder folder;
  static const fs::path path = [] {
    fs::create_directories(folder / "left");
    fs::create_directories(folder / "right");
    const StereoRig rig = small_rig();
    Trajectory trajectory;
    for (int i = 0; i < 4; ++i) {
      Isometry3d T_world_body = Isometry3d::Identity();
      T_world_body.translation().x() = 0.3 * i;
      const StereoFrame frame =
          render_frame(rig, T_world_body * rig.mount->T_body_left, block_and_kerb, 8.0);
      const std::string name = "00000" + std::to_string(i) + ".png";
      EXPECT_TRUE(write_png(folder / "left" / name, frame.left.view()));
      EXPECT_TRUE(write_png(folder / "right" / name, frame.right.view()));
      trajectory.push_back({100'000'000LL * i, *frame.T_world_left});
    }
    EXPECT_TRUE(write_rig(folder / "rig.yaml", rig));
    EXPECT_TRUE(write_tum_trajectory(folder / "poses.txt", trajectory));
    return folder.path();
  }();
  return path;
}

inline fs::path copy_of_drive(const ScratchFolder& scratch) {
  fs::copy(drive(), scratch / "drive", fs::copy_options::recursive);
  return scratch / "drive";
}

inline std::string pair_arguments() {
  return (drive() / "left/000001.png").string() + " " + (drive() / "right/000001.png").string();
}

}  // namespace tread::testing
