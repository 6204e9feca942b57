// Reads every include and fails on an arrow that the table of docs/architecture.md does not have:
// the data goes one way, and no module knows a module above or beside it.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

// Module -> modules it may include besides itself, core and geometry.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"core", {}},
    {"geometry", {}},
    {"stereo", {}},
    {"slam", {}},
    {"state", {}},
    {"terrain", {}},
    {"calibrate", {}},
    {"io", {}},
    {"plan", {"terrain"}},
    {"robot", {"plan", "terrain", "state"}},
    {"sim", {"robot", "terrain", "io"}},
    {"pipeline", {"stereo", "slam", "state", "terrain", "calibrate", "io", "plan", "robot"}},
    {"live", {"pipeline", "io"}},
};

// Heavy libraries and the modules that alone may include them, in sources only where it says so.
struct HeavyHeader {
  const char* pattern;
  std::set<std::string> modules;
};
const std::vector<HeavyHeader> kHeavy = {
    {"opencv2/", {"io", "calibrate", "slam"}},
    {"yaml-cpp/", {"io"}},
    {"png.h", {"io"}},
    {"jpeglib.h", {"io"}},
    {"tiff", {"io"}},
    {"geotiff", {"io"}},
    {"xtiffio", {"io"}},
    {"embree3/", {"sim"}},
    {"mujoco/", {"sim"}},
    {"oneapi/", {"core"}},
    {"fmt/",
     {"core", "geometry", "stereo", "slam", "state", "terrain", "calibrate", "io", "plan", "robot",
      "sim", "pipeline", "live"}},
};

struct Include {
  fs::path file;
  std::string module;  // of the file
  std::string target;  // as written
};

std::vector<Include> all_includes() {
  std::vector<Include> includes;
  const fs::path root = fs::path(TREAD_SOURCE_DIR) / "src" / "tread";
  const std::regex pattern(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".hpp" && extension != ".cpp") continue;
    const std::string module = fs::relative(entry.path(), root).begin()->string();
    std::ifstream text(entry.path());
    std::smatch match;
    for (std::string line; std::getline(text, line);) {
      if (std::regex_search(line, match, pattern)) {
        includes.push_back({entry.path(), module, match[1].str()});
      }
    }
  }
  return includes;
}

bool is_test(const fs::path& file) {
  return file.filename().string().find("_test.") != std::string::npos;
}

TEST(Layers, EveryIncludeGoesDownTheTable) {
  const auto includes = all_includes();
  ASSERT_GT(includes.size(), 50U) << "the scan found hardly anything: wrong folder?";
  for (const Include& include : includes) {
    ASSERT_TRUE(kMayInclude.contains(include.module)) << "unknown module: " << include.file;
    if (!include.target.starts_with("tread/")) continue;
    const std::string target = include.target.substr(6, include.target.find('/', 6) - 6);
    if (target == include.module || target == "core") continue;
    if (target == "geometry" && include.module != "core") continue;
    // A module of layer 2 may read the data of its tests with io.
    if (is_test(include.file) && target == "io") continue;
    EXPECT_TRUE(kMayInclude.at(include.module).contains(target))
        << include.file << " includes " << include.target;
  }
}

TEST(Layers, OwnHeadersAreNamedByTheirFullPath) {
  for (const Include& include : all_includes()) {
    const bool own =
        fs::exists(fs::path(TREAD_SOURCE_DIR) / "src" / "tread" / include.module / include.target);
    EXPECT_FALSE(own) << include.file << ": write tread/" << include.module << "/"
                      << include.target;
  }
}

TEST(Layers, HeavyLibrariesStayBehindTheirModuleAndOutOfHeaders) {
  for (const Include& include : all_includes()) {
    if (is_test(include.file)) continue;
    for (const HeavyHeader& heavy : kHeavy) {
      if (!include.target.starts_with(heavy.pattern)) continue;
      EXPECT_NE(include.file.extension(), ".hpp") << include.file << " shows " << include.target;
      EXPECT_TRUE(heavy.modules.contains(include.module))
          << include.file << " includes " << include.target;
    }
  }
}

// All headers of src/tread are installed.
TEST(Layers, NoHeaderIsOfTests) {
  for (const Include& include : all_includes()) {
    if (include.file.extension() != ".hpp") continue;
    EXPECT_EQ(include.file.filename().string().find("test"), std::string::npos) << include.file;
    EXPECT_FALSE(include.target.starts_with("gtest/")) << include.file;
  }
}

TEST(Layers, NoIncludeCycles) {
  std::map<std::string, std::vector<std::string>> edges;
  const fs::path root = fs::path(TREAD_SOURCE_DIR) / "src";
  for (const Include& include : all_includes()) {
    if (include.target.starts_with("tread/")) {
      edges[fs::relative(include.file, root).string()].push_back(include.target);
    }
  }
  std::map<std::string, int> state;  // 0 new, 1 on the way, 2 done
  std::function<bool(const std::string&)> acyclic = [&](const std::string& node) {
    if (state[node] == 1) return false;
    if (state[node] == 2) return true;
    state[node] = 1;
    for (const std::string& next : edges[node]) {
      if (!acyclic(next)) {
        ADD_FAILURE() << node << " -> " << next;
        return false;
      }
    }
    state[node] = 2;
    return true;
  };
  std::vector<std::string> nodes;
  for (const auto& [node, targets] : edges) nodes.push_back(node);
  for (const std::string& node : nodes) EXPECT_TRUE(acyclic(node)) << "cycle through " << node;
}

}  // namespace
