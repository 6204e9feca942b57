// The defaults that docs/pipeline.md tells are those of the program, and all options are told.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "tread/io/image_file.hpp"
#include "tread/pipeline/rover_mapper.hpp"
#include "tread/plan/planner.hpp"
#include "tread/sim/course.hpp"

namespace tread {
namespace {

std::vector<std::string> split(const std::string& text, const std::string& separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = text.find(separator); end != std::string::npos;
       end = text.find(separator, begin)) {
    parts.push_back(text.substr(begin, end - begin));
    begin = end + separator.size();
  }
  parts.push_back(text.substr(begin));
  return parts;
}

struct Told {
  std::string value;  // the default and what else stands there
  int line;
};

// Option names with the defaults told: in tables, | `a.b`, `c` | 1, 2 | for a.b and a.c, and in the
// text, `a.b` [1].
std::multimap<std::string, Told> told_defaults(const std::string& path) {
  std::multimap<std::string, Told> told;
  std::ifstream file(path);
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::regex inline_default(R"(`([a-z_.]+)` \[([^\]]+)\])");
    for (std::sregex_iterator match(line.begin(), line.end(), inline_default), end; match != end;
         ++match) {
      told.insert({(*match)[1].str(), {(*match)[2].str(), number}});
    }
    if (!line.starts_with("| `")) continue;
    const std::vector<std::string> columns = split(line, " | ");
    if (columns.size() < 2) continue;
    const std::vector<std::string> names = split(columns[0].substr(2), ", ");
    const std::vector<std::string> values = split(columns[1], ", ");
    std::string group;
    for (std::size_t i = 0; i < names.size(); ++i) {
      std::string name = names[i].substr(1, names[i].size() - 2);
      if (i == 0 && name.find('.') != std::string::npos) {
        group = name.substr(0, name.rfind('.') + 1);
      } else if (name.find('.') == std::string::npos) {
        name.insert(0, group);
      }
      if (i < values.size()) told.insert({name, {values[i], number}});
    }
  }
  return told;
}

TEST(PipelinePage, DefaultsAreThoseOfTheProgram) {
  const auto told = told_defaults(std::string(TREAD_SOURCE_DIR) + "/docs/pipeline.md");
  RoverMapOptions map;
  PlannerOptions plan;
  ImageReading images;
  OptionSet options = describe(map);
  options.add_group("plan", describe(plan));
  options.add_group("images", describe(images));
  for (const OptionField& field : options.fields()) {
    // Told as the ones they stand for, and where they differ.
    if (field.name.starts_with("stereo.sgm.holes.")) continue;
    if (field.name.starts_with("stereo.sgm.speckle.")) continue;
    const auto [first, last] = told.equal_range(field.name);
    EXPECT_NE(first, last) << "docs/pipeline.md does not tell of " << field.name;
    for (auto entry = first; entry != last; ++entry) {
      // "0.5" or "0.5 (paper Q: 1)", but not "0.55".
      const std::string value = field.print(), &there = entry->second.value;
      EXPECT_TRUE(there.starts_with(value) &&
                  (there.size() == value.size() ||
                   std::string(" ;").find(there[value.size()]) != std::string::npos))
          << "docs/pipeline.md:" << entry->second.line << ": " << field.name << " is " << value
          << ", not " << there;
    }
  }
}

// What a heading is called in links: small letters, blanks as hyphens, no other signs.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_') {
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (c == ' ') {
      anchor += '-';
    }
  }
  return anchor;
}

// Every entry that docs/simulation.md tells of course files is one.
TEST(Docs, TheCourseOfTheSimulationPageIsSound) {
  std::ifstream file(std::string(TREAD_SOURCE_DIR) + "/docs/simulation.md");
  std::string text, line;
  bool inside = false;
  while (std::getline(file, line)) {
    if (line.starts_with("```")) {
      if (inside) break;
      inside = line == "```yaml";
      continue;
    }
    if (inside && line.find("height_map:") == std::string::npos) text += line + "\n";
  }
  ASSERT_NE(text.find("tread_course"), std::string::npos);
  const auto course = parse_course(text, "simulation.md");
  ASSERT_TRUE(course) << course.error().message();
  EXPECT_GT(course->world->solids.size(), 40U);
  EXPECT_EQ(course->faults.size(), 3U);
}

TEST(Docs, LinksLeadToFilesAndHeadings) {
  namespace fs = std::filesystem;
  const fs::path root(TREAD_SOURCE_DIR);
  std::vector<fs::path> pages = {root / "README.md", root / "BENCHMARKS.md"};
  for (const auto& entry : fs::directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  std::map<fs::path, std::vector<std::string>> anchors;
  const auto anchors_of = [&](const fs::path& page) -> const std::vector<std::string>& {
    auto [found, fresh] = anchors.try_emplace(page);
    if (!fresh) return found->second;
    std::ifstream file(page);
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("#")) {
        found->second.push_back(anchor_of(line.substr(line.find_first_not_of("# "))));
      }
    }
    return found->second;
  };
  int links = 0;
  const std::regex link(R"(\]\(([^)#\s]*)(#[^)\s]+)?\))");
  for (const fs::path& page : pages) {
    std::ifstream file(page);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    for (std::sregex_iterator match(text.begin(), text.end(), link), end; match != end; ++match) {
      const std::string target = (*match)[1].str(), anchor = (*match)[2].str();
      if (target.find("://") != std::string::npos) continue;
      ++links;
      const fs::path to = target.empty() ? page : (page.parent_path() / target).lexically_normal();
      EXPECT_TRUE(fs::exists(to)) << page << " links to " << target;
      if (anchor.empty() || to.extension() != ".md") continue;
      const auto& there = anchors_of(to);
      EXPECT_NE(std::find(there.begin(), there.end(), anchor.substr(1)), there.end())
          << page << " links to " << target << anchor;
    }
  }
  EXPECT_GT(links, 20);
}

}  // namespace
}  // namespace tread
