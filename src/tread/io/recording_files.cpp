#include "tread/io/recording_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "tread/io/atomic_file.hpp"
#include "tread/io/recording_folder.hpp"
#include "tread/io/stamped_csv.hpp"
#include "tread/io/text_tree.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using internal::CsvLayout;
using internal::StampedRow;

template <class Sample>
Result<std::vector<Sample>> read_samples(const fs::path& path, const CsvLayout& layout,
                                         std::vector<Error>* problems,
                                         Sample (*sample_of)(const StampedRow& row)) {
  const auto rows = internal::read_stamped_csv(path, layout, problems);
  if (!rows) return forward(rows);
  return with_memory_checked(path.string(), "Give a part of the file", [&] {
    std::vector<Sample> samples;
    samples.reserve(rows->size());
    for (std::size_t i = 0; i < rows->size(); ++i) samples.push_back(sample_of((*rows)[i]));
    return Result<std::vector<Sample>>(std::move(samples));
  });
}

LegSample leg_sample(const StampedRow& row) {
  LegSample sample;
  sample.stamp_ns = row.stamp_ns;
  const double* from = row.numbers.data();
  for (auto* values : {&sample.position_rad, &sample.velocity_rad_per_s, &sample.torque_nm}) {
    std::copy(from, from + kLegJoints, values->begin());
    from += kLegJoints;
  }
  for (Eigen::Vector3d& force : sample.foot_force_n) {
    force = {from[0], from[1], from[2]};
    from += 3;
  }
  return sample;
}

}  // namespace

Result<std::vector<GnssFix>> read_gnss(const fs::path& path, std::vector<Error>* problems) {
  const CsvLayout layout{5, false, "time in ns, x, y, z, sigma level, sigma up (m)",
                         [](const StampedRow& row) {
                           const bool below = row.numbers[3] < 0.0 || row.numbers[4] < 0.0;
                           return below ? "a standard deviation is below 0" : nullptr;
                         }};
  return read_samples<GnssFix>(path, layout, problems, [](const StampedRow& row) {
    const auto& n = row.numbers;
    return GnssFix{row.stamp_ns, {n[0], n[1], n[2]}, n[3], n[4]};
  });
}

Result<std::vector<WheelSample>> read_wheels(const fs::path& path, std::vector<Error>* problems) {
  const CsvLayout layout{4, false, "time in ns, left, right (rad), left, right current (A)",
                         nullptr};
  return read_samples<WheelSample>(path, layout, problems, [](const StampedRow& row) {
    const auto& n = row.numbers;
    return WheelSample{row.stamp_ns, n[0], n[1], n[2], n[3]};
  });
}

Result<std::vector<LegSample>> read_legs(const fs::path& path, std::vector<Error>* problems) {
  const CsvLayout layout{std::size_t{3} * kLegJoints + std::size_t{3} * kLegs, false,
                         "time in ns, 12 positions (rad), 12 velocities (rad/s), 12 torques (Nm), "
                         "12 numbers of forces (N)",
                         nullptr};
  return read_samples<LegSample>(path, layout, problems, leg_sample);
}

Result<std::vector<HeadState>> read_head(const fs::path& path, std::vector<Error>* problems) {
  const CsvLayout layout{2, false, "time in ns, pan, tilt (rad)", nullptr};
  return read_samples<HeadState>(path, layout, problems, [](const StampedRow& row) {
    return HeadState{row.stamp_ns, row.numbers[0], row.numbers[1]};
  });
}

Result<std::vector<BumpEvent>> read_bumps(const fs::path& path, std::vector<Error>* problems) {
  const CsvLayout layout{1, false, "time in ns, 1 if pressed, else 0", [](const StampedRow& row) {
                           const bool known = row.numbers[0] == 0.0 || row.numbers[0] == 1.0;
                           return known ? nullptr : "neither 0 nor 1";
                         }};
  return read_samples<BumpEvent>(path, layout, problems, [](const StampedRow& row) {
    return BumpEvent{row.stamp_ns, row.numbers[0] == 1.0};
  });
}

bool is_recording(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / internal::kRecordingMark, ignored);
}

Result<RecordingInfo> read_recording_info(const fs::path& folder) {
  const fs::path path = folder / internal::kRecordingMark;
  const auto text = read_file(path, std::size_t{1} << 20);
  if (!text) return forward(text);
  const auto tree = internal::parse_yaml(*text, path.string());
  if (!tree) return forward(tree);
  const internal::Field root(*tree, path.string());
  const auto version_field = root.at("tread_recording");
  if (!version_field) return forward(version_field);
  const auto version = version_field->whole_number();
  if (!version) return forward(version);
  if (*version != 1) {
    return version_field->error(ErrorCode::kUnsupported,
                                fmt::format("version {} is not known", *version),
                                "This program reads version 1");
  }
  RecordingInfo info;
  const auto description = root.at("description"), heads = root.at("heads");
  if (!description) return forward(description);
  if (!heads) return forward(heads);
  const auto words = description->text();
  if (!words) return forward(words);
  info.description = *words;
  const auto count = heads->whole_number();
  if (!count) return forward(count);
  info.heads = *count;
  const auto samples = root.at("samples");
  if (!samples) return forward(samples);
  const auto entries = samples->entries();
  if (!entries) return forward(entries);
  for (const auto& [name, field] : *entries) {
    const auto number = field.whole_number();
    if (!number) return forward(number);
    info.samples.emplace_back(name, *number);
  }
  return info;
}

}  // namespace tread
