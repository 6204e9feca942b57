// What the tests of rig files share: files in a scratch folder, and messages looked at.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "test_data.hpp"
#include "tread/io/rig_file.hpp"

namespace tread::testing {

class RigFiles : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    const std::filesystem::path path = scratch_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
    return path.string();
  }
  Result<StereoRig> read_text(const std::string& text, ImageSize size = {}) {
    return read_rig(write("rig.yaml", text), size);
  }
  Result<StereoRig> read_pair(const std::string& left, const std::string& right) {
    return read_rig(write("left.yaml", left) + "," + write("right.yaml", right));
  }
  ScratchFolder scratch_;
};

inline std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

inline std::string message_of(const Result<StereoRig>& rig) {
  EXPECT_FALSE(rig);
  return rig ? "read" : rig.error().message();
}

#define EXPECT_SAYS(message, part) \
  EXPECT_NE((message).find(part), std::string::npos) << "says: " << (message)

}  // namespace tread::testing
