// Samples of an inertial measurement unit as EuRoC/ASL folders hold them (imu0/data.csv).
#pragma once

#include <filesystem>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/geometry/samples.hpp"

namespace tread {

// "time in ns,wx,wy,wz,ax,ay,az" a line, rad/s and m/s^2, in the axes of the IMU; lines that start
// with '#' are skipped. Times of the result increase strictly. A line that cannot be read, that has
// numbers which no sensor gives (above 1000 rad/s or 100,000 m/s^2), or whose time does not fit
// those around it costs its sample: `problems` gets one entry for each of the two kinds that counts
// them and names the first few. Without `problems`, and if no sample is left, it is the error of
// the whole. At most 1 GiB.
[[nodiscard]] Result<std::vector<ImuSample>> read_imu(const std::filesystem::path& path,
                                                      std::vector<Error>* problems = nullptr);

}  // namespace tread
