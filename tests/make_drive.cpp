// Writes a small drive over made ground: what the examples, the snippets of the documents and the
// tests of the command line run on.
//   make_drive FOLDER
#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <string>

#include "synthetic_drive.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/trajectory_file.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  for (const char* side : {"left", "right"}) std::filesystem::create_directories(folder / side);
  const tread::StereoRig rig = tread::testing::small_rig();
  const auto done = [](const tread::Status& status) {
    if (!status) std::cerr << status.error().message() << '\n';
    return status.has_value();
  };
  tread::Trajectory trajectory;
  for (int i = 0; i < 5; ++i) {
    tread::Isometry3d T_world_body = tread::Isometry3d::Identity();
    T_world_body.translation().x() = 0.25 * i;
    const tread::StereoFrame frame = tread::testing::render_frame(
        rig, T_world_body * rig.mount->T_body_left, tread::testing::block_and_kerb, 8.0);
    const std::string name = fmt::format("{:06}.png", i);
    if (!done(tread::write_png(folder / "left" / name, frame.left.view()))) return 1;
    if (!done(tread::write_png(folder / "right" / name, frame.right.view()))) return 1;
    trajectory.push_back({100'000'000LL * i, *frame.T_world_left});
  }
  if (!done(tread::write_rig(folder / "rig.yaml", rig))) return 1;
  return done(tread::write_tum_trajectory(folder / "poses.txt", trajectory)) ? 0 : 1;
}
