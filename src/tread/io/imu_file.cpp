#include "tread/io/imu_file.hpp"

#include <algorithm>
#include <cmath>

#include "tread/io/stamped_csv.hpp"

namespace tread {
namespace {

// What an integration of it would still bear, and far beyond any sensor.
constexpr double kFastest_rad_per_s = 1e3;
constexpr double kHardest_m_per_s2 = 1e5;

const char* what_is_wrong(const internal::StampedRow& row) {
  const auto within = [&](std::size_t first, double limit) {
    const auto* begin = row.numbers.data() + first;
    return std::all_of(begin, begin + 3, [=](double value) { return std::abs(value) <= limit; });
  };
  if (!within(0, kFastest_rad_per_s)) return "above 1000 rad/s";
  if (!within(3, kHardest_m_per_s2)) return "above 100000 m/s^2";
  return nullptr;
}

}  // namespace

Result<std::vector<ImuSample>> read_imu(const std::filesystem::path& path,
                                        std::vector<Error>* problems) {
  const internal::CsvLayout layout{6, false, "time in ns, wx, wy, wz (rad/s), ax, ay, az (m/s^2)",
                                   what_is_wrong};
  const auto rows = internal::read_stamped_csv(path, layout, problems);
  if (!rows) return forward(rows);
  return with_memory_checked(path.string(), "Give a part of the file", [&] {
    std::vector<ImuSample> samples;
    samples.reserve(rows->size());
    for (std::size_t i = 0; i < rows->size(); ++i) {
      const internal::StampedRow row = (*rows)[i];
      const auto& n = row.numbers;
      samples.push_back({row.stamp_ns, {n[0], n[1], n[2]}, {n[3], n[4], n[5]}});
    }
    return Result<std::vector<ImuSample>>(std::move(samples));
  });
}

}  // namespace tread
