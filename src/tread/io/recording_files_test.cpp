// Tables of sensors beyond EuRoC: what is wrong with them. (That what is written comes back:
// data_set_writer_test.)
#include "tread/io/recording_files.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "file_mutations.hpp"
#include "test_data.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::put_file;
using testing::ScratchFolder;

std::string numbers(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += "," + std::to_string(i);
  return text;
}

// Each table with its number of columns behind the stamp.
struct Table {
  const char* name;
  int columns;
  std::function<Result<std::size_t>(const fs::path&, std::vector<Error>*)> count;
};

template <class Sample>
Table table(const char* name, int columns,
            Result<std::vector<Sample>> (*read)(const fs::path&, std::vector<Error>*)) {
  return {name, columns,
          [=](const fs::path& path, std::vector<Error>* problems) -> Result<std::size_t> {
            const auto samples = read(path, problems);
            if (!samples) return forward(samples);
            return samples->size();
          }};
}

const std::vector<Table>& tables() {
  static const std::vector<Table> kTables = {
      table("gnss", 5, read_gnss), table("wheels", 4, read_wheels), table("legs", 48, read_legs),
      table("head", 2, read_head), table("bumps", 1, read_bumps)};
  return kTables;
}

TEST(RecordingFiles, EachTableWantsItsColumns) {
  const ScratchFolder scratch;
  for (const Table& t : tables()) {
    const fs::path path = scratch / t.name;
    put_file(path, "#head\n1" + numbers(t.columns) + "\n3" + numbers(t.columns) + "\r\n");
    const auto good = t.count(path, nullptr);
    ASSERT_TRUE(good) << t.name << good.error().message();
    EXPECT_EQ(*good, 2U);
    for (const int columns : {0, t.columns - 1, t.columns + 1}) {
      put_file(path, "1" + numbers(t.columns) + "\n2" + numbers(columns) + "\n");
      const auto bad = t.count(path, nullptr);
      ASSERT_FALSE(bad) << t.name << columns;
      EXPECT_EQ(bad.error().where, path.string() + ":2");
      std::vector<Error> problems;
      EXPECT_EQ(t.count(path, &problems).value(), 1U) << "the other line is of use";
      EXPECT_EQ(problems.size(), 1U);
    }
    EXPECT_FALSE(t.count(scratch / "nothing", nullptr));
    put_file(path, "");
    EXPECT_FALSE(t.count(path, nullptr));
  }
}

TEST(RecordingFiles, TimesIncreaseAndNumbersAreFinite) {
  const ScratchFolder scratch;
  for (const Table& t : tables()) {
    const fs::path path = scratch / t.name;
    const std::string rest = numbers(t.columns - 1);
    for (const std::string& line :
         {"5" + rest + ",0\n5" + rest + ",0\n", "5" + rest + ",0\n4" + rest + ",0\n",
          "5" + rest + ",nan\n", "5" + rest + ",inf\n", "5" + rest + ",x\n", "-5" + rest + ",0\n",
          "0.5" + rest + ",0\n"}) {
      put_file(path, line);
      EXPECT_FALSE(t.count(path, nullptr)) << t.name << line;
    }
  }
}

TEST(RecordingFiles, ValuesThatCannotBeAreRefused) {
  const ScratchFolder scratch;
  put_file(scratch / "a", "1,0,0,0,-1,0\n");
  EXPECT_FALSE(read_gnss(scratch / "a"));
  put_file(scratch / "a", "1,2\n");
  EXPECT_FALSE(read_bumps(scratch / "a"));
}

TEST(RecordingFiles, DamagedTablesAreReadOrRefusedCleanly) {
  const ScratchFolder scratch;
  std::string text = "#head\n";
  for (int i = 0; i < 8; ++i) text += std::to_string(1000 + i) + ",1.5,-2.5,3e-3,4,5\n";
  const int refused = testing::damaged_files_refused(
      text, scratch / "gnss", [](const fs::path& path) { return read_gnss(path).has_value(); });
  EXPECT_GT(refused, 200);
  EXPECT_LT(refused, 2000);
}

TEST(RecordingFiles, ADescriptionIsReadOrRefusedByLine) {
  const ScratchFolder scratch;
  EXPECT_FALSE(is_recording(scratch.path()));
  EXPECT_FALSE(read_recording_info(scratch.path()));
  const std::string good =
      "tread_recording: 1\ndescription: \"x: y\"\nheads: 2\nsamples:\n  imu0: 5\n  bump0: 0\n";
  put_file(scratch / "recording.yaml", good);
  EXPECT_TRUE(is_recording(scratch.path()));
  const auto info = read_recording_info(scratch.path());
  ASSERT_TRUE(info) << info.error().message();
  EXPECT_EQ(info->description, "x: y");
  EXPECT_EQ(info->heads, 2);
  EXPECT_EQ(info->samples,
            (std::vector<std::pair<std::string, std::int64_t>>{{"imu0", 5}, {"bump0", 0}}));
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    put_file(scratch / "recording.yaml", text);
    const auto bad = read_recording_info(scratch.path());
    EXPECT_FALSE(bad) << to;
    return bad ? std::string() : bad.error().message();
  };
  EXPECT_NE(refused("tread_recording: 1", "tread_recording: 2").find("version 2"),
            std::string::npos);
  EXPECT_NE(refused("heads: 2", "heads: two").find("recording.yaml:3"), std::string::npos);
  (void)refused("imu0: 5", "imu0: many");
  (void)refused("samples:", "sample:");
}

}  // namespace
}  // namespace tread
