#include "tread/sim/fault.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tread/core/options.hpp"

namespace tread {
namespace {

constexpr std::array<std::pair<const char*, FaultKind>, 6> kNames = {{
    {"dead", FaultKind::kDead},
    {"stuck", FaultKind::kStuck},
    {"frozen", FaultKind::kFrozen},
    {"saturated", FaultKind::kSaturated},
    {"shuffled", FaultKind::kShuffled},
    {"clock_jump", FaultKind::kClockJump},
}};

constexpr double kLongest_s = 1e6;  // of delays and jumps: 11 days

bool in_effect(const Fault& fault, double time_s) {
  return fault.from_s <= time_s && time_s < fault.until_s;
}

// Values of these have no range that they could be clipped to.
bool has_range(std::string_view sensor) {
  return sensor != "gnss" && sensor != "bump" && sensor != "head";
}

Status check_sensor(const Fault& fault, int heads, const std::string& where) {
  const std::vector<std::string> names = sensor_names(heads);
  if (std::find(names.begin(), names.end(), fault.sensor) != names.end()) return {};
  const std::string near = nearest_name(fault.sensor, names);
  return fail(ErrorCode::kBadValue, fmt::format("there is no sensor '{}'", fault.sensor),
              where + ".sensor",
              near.empty() ? fmt::format("Give one of: {}", fmt::join(names, ", "))
                           : fmt::format("Did you mean '{}'?", near));
}

Status check_times(const Fault& fault, const std::string& where) {
  if (!std::isfinite(fault.from_s) || fault.from_s < 0.0) {
    return fail(ErrorCode::kBadValue, fmt::format("{} s is not a time to begin", fault.from_s),
                where + ".from_s", "Give seconds from the start, 0 or more");
  }
  if (fault.until_s > fault.from_s) return {};
  return fail(ErrorCode::kBadValue,
              fmt::format("it ends at {} s, not after {} s", fault.until_s, fault.from_s),
              where + ".until_s", "Give a time after from_s, or none for the rest of the run");
}

Status check_amount(const Fault& fault, const std::string& where) {
  const double amount = fault.amount;
  const char* remedy = nullptr;
  switch (fault.kind) {
    case FaultKind::kSaturated:
      if (!has_range(fault.sensor)) {
        return fail(ErrorCode::kBadValue,
                    fmt::format("the values of '{}' have no range", fault.sensor), where + ".kind",
                    "Let imu, wheels, legs or a camera be saturated");
      }
      if (!(amount > 0.0 && amount <= 1.0)) remedy = "Give a share of the range, above 0, up to 1";
      break;
    case FaultKind::kShuffled:
      if (!(amount > 0.0 && amount <= kLongest_s)) remedy = "Give seconds, above 0, up to 1e6";
      break;
    case FaultKind::kClockJump:
      if (!(std::abs(amount) > 0.0 && std::abs(amount) <= kLongest_s)) {
        remedy = "Give seconds, not 0, from -1e6 to 1e6";
      }
      break;
    default:
      if (amount != 0.0) remedy = "Leave the amount out: this kind has none";
      break;
  }
  if (remedy == nullptr) return {};
  return fail(ErrorCode::kBadValue,
              fmt::format("{} is no amount of '{}'", amount, name_of(fault.kind)),
              where + ".amount", remedy);
}

}  // namespace

std::string name_of(FaultKind kind) {
  for (const auto& [name, named] : kNames) {
    if (named == kind) return name;
  }
  return "";
}

std::optional<FaultKind> fault_kind_named(std::string_view name) {
  for (const auto& [known, kind] : kNames) {
    if (known == name) return kind;
  }
  return std::nullopt;
}

std::vector<std::string> fault_kind_names() {
  std::vector<std::string> names;
  for (const auto& entry : kNames) names.emplace_back(entry.first);
  return names;
}

std::vector<std::string> sensor_names(int heads) {
  std::vector<std::string> names = {"imu", "gnss", "wheels", "legs", "bump", "head"};
  for (int head = 0; head < heads; ++head) names.push_back(fmt::format("camera{}", head));
  return names;
}

Status check_faults(std::span<const Fault> faults, int heads) {
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const std::string where = fmt::format("faults[{}]", i);
    if (Status done = check_sensor(faults[i], heads, where); !done) return done;
    if (Status done = check_times(faults[i], where); !done) return done;
    if (Status done = check_amount(faults[i], where); !done) return done;
  }
  return {};
}

FaultSchedule::FaultSchedule(std::span<const Fault> faults, std::string_view sensor) {
  for (const Fault& fault : faults) {
    if (fault.sensor == sensor) faults_.push_back(fault);
  }
}

const Fault* FaultSchedule::find(FaultKind kind, double time_s) const {
  const auto found = std::find_if(faults_.rbegin(), faults_.rend(), [&](const Fault& fault) {
    return fault.kind == kind && in_effect(fault, time_s);
  });
  return found == faults_.rend() ? nullptr : &*found;
}

bool FaultSchedule::has(FaultKind kind) const {
  return std::any_of(faults_.begin(), faults_.end(),
                     [=](const Fault& fault) { return fault.kind == kind; });
}

double FaultSchedule::clock_jump_s(double time_s) const {
  double jump_s = 0.0;
  for (const Fault& fault : faults_) {
    if (fault.kind == FaultKind::kClockJump && in_effect(fault, time_s)) jump_s += fault.amount;
  }
  return jump_s;
}

}  // namespace tread
