// The scripts beside the program: building in a copied folder, and what is said without root.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "test_data.hpp"
#include "tread/io/atomic_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::ScratchFolder;

const fs::path kScripts = fs::path(TREAD_SOURCE_DIR) / "scripts";

struct Ran {
  int status = -1;
  std::string text;  // both streams
};

Ran shell(const std::string& command) {
  Ran ran;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  EXPECT_NE(pipe, nullptr);
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    ran.text.append(buffer.data(), n);
  }
  const int ended = pclose(pipe);
  ran.status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
  return ran;
}

TEST(BuildScript, ACopiedBuildFolderIsMadeAnew) {
  const ScratchFolder folder;
  const fs::path first = folder / "first";
  fs::create_directories(first / "scripts");
  fs::copy(kScripts / "build", first / "scripts/build");
  ASSERT_TRUE(write_file(first / "CMakeLists.txt",
                         "cmake_minimum_required(VERSION 3.25)\nproject(p NONE)\n"
                         "add_custom_target(all_of_it ALL COMMAND ${CMAKE_COMMAND} -E touch "
                         "${PROJECT_SOURCE_DIR}/built)\n"));
  ASSERT_TRUE(write_file(first / "CMakePresets.json",
                         R"({"version": 6, "configurePresets": [{"name": "x", "generator": "Ninja",
          "binaryDir": "${sourceDir}/build/x"}],
          "buildPresets": [{"name": "x", "configurePreset": "x"}]})"));
  const auto build = [](const fs::path& where) {
    return shell((where / "scripts/build").string() + " x");
  };
  const Ran fresh = build(first);
  ASSERT_EQ(fresh.status, 0) << fresh.text;
  EXPECT_NE(fresh.text.find("Configuring"), std::string::npos);
  const Ran again = build(first);
  ASSERT_EQ(again.status, 0) << again.text;
  EXPECT_EQ(again.text, "");
  const fs::path second = folder / "second";
  fs::copy(first, second, fs::copy_options::recursive);
  fs::remove(second / "built");
  const Ran copied = build(second);
  EXPECT_EQ(copied.status, 0) << copied.text;
  EXPECT_NE(copied.text.find("made in another place"), std::string::npos) << copied.text;
  EXPECT_TRUE(fs::exists(second / "built"));
}

TEST(InstallScript, WithoutRootAndSudoItPrintsTheLineToRun) {
  const ScratchFolder folder;
  // A system where nothing is installed and the user is nobody in particular.
  const auto tool = [&](const char* name, const std::string& body) {
    ASSERT_TRUE(write_file(folder / name, "#!/bin/sh\n" + body + "\n"));
    fs::permissions(folder / name, fs::perms::owner_all);
  };
  tool("dpkg-query", "exit 1");
  tool("id", "echo 1000");
  const Ran ran = shell("PATH=" + folder.path().string() + " /bin/bash " +
                        (kScripts / "install_dependencies").string());
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(ran.text.find("apt-get update && apt-get install -y --no-install-recommends g++ "),
            std::string::npos)
      << ran.text;
}

}  // namespace
}  // namespace tread
