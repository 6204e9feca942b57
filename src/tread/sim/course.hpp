// Courses: simulated worlds described in YAML files. docs/simulation.md has every entry.
//
//   tread_course: 1
//   name: pallets
//   size_m: [12, 8]
//   origin_m: [-2, -4]             # lower corner; x east, y north
//   ground: {surface: gravel, relief: [{noise: {rms_m: 0.02, longest_m: 3}}]}
//   objects:
//     - pallet: {at_m: [3, 0], stack: 2, offset_m: 0.4}
//     - rocks: {count: 60, size_m: [0.05, 0.3]}
//   faults:
//     - {sensor: gnss, kind: dead, from_s: 10, until_s: 15}
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/sim/fault.hpp"
#include "tread/sim/world.hpp"

namespace tread {

struct Course {
  std::shared_ptr<const World> world;  // never null
  std::vector<Fault> faults;           // what breaks of the robot's sensors, and when
};

// A course from its file: the same name and seed, the same world to the bit. `seed` replaces that
// of the file. Errors name file, line, entry and remedy: an unknown entry (with the nearest known
// one), a value out of range, a height map that is not there, a start that is off the ground.
[[nodiscard]] Result<Course> read_course(const std::filesystem::path& path,
                                         std::optional<std::uint64_t> seed = {});
// The same from text; `file` names it in messages and is where height maps are looked for beside.
[[nodiscard]] Result<Course> parse_course(const std::string& text,
                                          const std::filesystem::path& file,
                                          std::optional<std::uint64_t> seed = {});

}  // namespace tread
