// Every test and bench that the pages of docs/ name exists: a row of docs/papers.md whose check has
// been renamed or taken out fails here.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = TREAD_SOURCE_DIR;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::vector<std::smatch> all_matches(const std::string& text, const std::regex& pattern) {
  return {std::sregex_iterator(text.begin(), text.end(), pattern), std::sregex_iterator()};
}

// "Suite.Name" of every test in the sources.
std::set<std::string> tests_in_sources() {
  const std::regex pattern(R"(\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\))");
  std::set<std::string> names;
  for (const char* folder : {"src", "apps", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      if (entry.path().extension() != ".cpp") continue;
      const std::string text = text_of(entry.path());
      for (const auto& match : all_matches(text, pattern)) {
        names.insert(match[1].str() + "." + match[2].str());
      }
    }
  }
  return names;
}

// `Suite.Name`, `Suite.*` or, where a name is too long to print, `Suite.Beginning...`.
bool exists(const std::set<std::string>& tests, const std::string& named) {
  const std::size_t cut = std::min(named.find('*'), named.find("..."));
  if (cut == std::string::npos) return tests.contains(named);
  const std::string beginning = named.substr(0, cut);
  const auto next = tests.lower_bound(beginning);
  return next != tests.end() && next->starts_with(beginning);
}

struct Row {
  int line = 0;
  std::vector<std::string> columns;
};

// The rows of the tables "says | in tread | check | state".
std::vector<Row> claims() {
  std::ifstream stream(kRoot / "docs" / "papers.md");
  std::vector<Row> rows;
  std::string line;
  bool inside = false;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (!line.starts_with("|")) {
      inside = false;
      continue;
    }
    if (line.starts_with("| says |")) inside = true;
    if (!inside || line.starts_with("| says |") || line.starts_with("|---")) continue;
    Row row{number, {}};
    for (std::size_t begin = 1; begin < line.size();) {
      const std::size_t end = std::min(line.find('|', begin), line.size());
      row.columns.push_back(line.substr(begin, end - begin));
      begin = end + 1;
    }
    rows.push_back(row);
  }
  return rows;
}

TEST(PapersPage, EveryRowHasFourColumnsAndAState) {
  const std::vector<Row> rows = claims();
  ASSERT_GT(rows.size(), 80U);
  for (const Row& row : rows) {
    ASSERT_EQ(row.columns.size(), 4U) << "docs/papers.md:" << row.line;
    const std::regex state(R"(^ (built|in part|not built|contradiction)\b.*)");
    EXPECT_TRUE(std::regex_match(row.columns[3], state)) << "docs/papers.md:" << row.line;
    if (row.columns[3].starts_with(" not built")) continue;
    // A number of the paper that is built has a check that can fail.
    const bool number = std::regex_search(row.columns[0], std::regex(R"([0-9])"));
    EXPECT_TRUE(!number || row.columns[2].find('`') != std::string::npos)
        << "docs/papers.md:" << row.line << " has a number and no check";
  }
}

TEST(PapersPage, EveryTestAndBenchThatDocsNameExists) {
  const std::set<std::string> tests = tests_in_sources();
  ASSERT_TRUE(tests.contains("PapersPage.EveryTestAndBenchThatDocsNameExists"));
  std::set<std::string> suites;
  for (const std::string& test : tests) suites.insert(test.substr(0, test.find('.')));
  EXPECT_FALSE(exists(tests, "PapersPage.NoSuchTest"));
  EXPECT_FALSE(exists(tests, "PapersPag.*"));

  int named = 0;
  for (const Row& row : claims()) {
    ASSERT_GE(row.columns.size(), 3U);
    for (const auto& match : all_matches(row.columns[2], std::regex(R"(`([A-Z]\w*\.[\w*]+)`)"))) {
      ++named;
      EXPECT_TRUE(exists(tests, match[1].str()))
          << "docs/papers.md:" << row.line << " names " << match[1];
    }
    for (const auto& match : all_matches(row.columns[2], std::regex(R"(bench `(\w+)`)"))) {
      EXPECT_TRUE(fs::exists(kRoot / "bench" / (match[1].str() + ".cpp")))
          << "docs/papers.md:" << row.line << " names bench " << match[1];
    }
  }
  EXPECT_GT(named, 80);
  // In the other pages, what stands in backticks with the name of a suite before the point.
  for (const fs::path& page : {kRoot / "docs", kRoot / "README.md", kRoot / "BENCHMARKS.md"}) {
    std::vector<fs::path> files = {page};
    if (fs::is_directory(page)) files.assign(fs::directory_iterator(page), {});
    for (const fs::path& file : files) {
      if (file.extension() != ".md") continue;
      const std::string text = text_of(file);
      for (const auto& match :
           all_matches(text, std::regex(R"(`((\w+)\.[A-Z*]\w*(?:\.\.\.)?)`)"))) {
        if (!suites.contains(match[2].str())) continue;
        EXPECT_TRUE(exists(tests, match[1].str())) << file << " names " << match[1];
      }
    }
  }
}

}  // namespace
