#include "tread/sim/course_fields.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tread/core/options.hpp"

namespace tread::internal {

constexpr double kFarthest_m = 1e4;

template <class T>
std::optional<T> CourseFields::take(const Result<T>& value) {
  if (value) return *value;
  if (!error_) error_ = value.error();
  return std::nullopt;
}

std::optional<Field> CourseFields::find(const char* key) {
  asked_.emplace_back(key);
  return field_.find(key);
}

std::optional<Field> CourseFields::require(const char* key) {
  asked_.emplace_back(key);
  return take(field_.at(key));
}

void CourseFields::refuse(const char* key, ErrorCode code, const std::string& what,
                          const std::string& remedy) {
  if (error_) return;
  const auto entry = field_.find(key);
  error_ = (entry ? *entry : field_).error(code, what, remedy).value();
}

double CourseFields::number(const char* key, double otherwise, double low, double high) {
  const auto entry = find(key);
  if (!entry) return otherwise;
  const auto value = take(entry->number());
  if (!value) return otherwise;
  if (*value < low || *value > high) {
    refuse(key, ErrorCode::kBadValue, fmt::format("{} is out of range", *value),
           fmt::format("Write a number from {} to {}", low, high));
    return otherwise;
  }
  return *value;
}

double CourseFields::required_number(const char* key, double low, double high) {
  if (!require(key)) return low;
  return number(key, low, low, high);
}

int CourseFields::whole(const char* key, int otherwise, int low, int high) {
  const auto entry = find(key);
  if (!entry) return otherwise;
  const auto value = take(entry->whole_number());
  if (!value) return otherwise;
  if (*value < low || *value > high) {
    refuse(key, ErrorCode::kBadValue, fmt::format("{} is out of range", *value),
           fmt::format("Write a whole number from {} to {}", low, high));
    return otherwise;
  }
  return *value;
}

Eigen::Vector2d CourseFields::place(const char* key) {
  if (!require(key)) return Eigen::Vector2d::Zero();
  return place(key, Eigen::Vector2d::Zero());
}

Eigen::Vector2d CourseFields::place(const char* key, const Eigen::Vector2d& otherwise) {
  const auto entry = find(key);
  if (!entry) return otherwise;
  const auto values = take(entry->numbers(2));
  if (!values) return otherwise;
  const Eigen::Vector2d place((*values)[0], (*values)[1]);
  if (place.cwiseAbs().maxCoeff() > kFarthest_m) {
    refuse(key, ErrorCode::kBadValue, "beyond what a course can be",
           fmt::format("Write numbers within {} m", kFarthest_m));
    return otherwise;
  }
  return place;
}

Eigen::Vector3d CourseFields::sizes(const char* key, const Eigen::Vector3d& otherwise, double low,
                                    double high) {
  const auto entry = find(key);
  if (!entry) return otherwise;
  const auto values = take(entry->numbers(3));
  if (!values) return otherwise;
  const Eigen::Vector3d sizes((*values)[0], (*values)[1], (*values)[2]);
  if (sizes.minCoeff() < low || sizes.maxCoeff() > high) {
    refuse(key, ErrorCode::kBadValue, "a size is out of range",
           fmt::format("Write sizes from {} to {} m", low, high));
    return otherwise;
  }
  return sizes;
}

std::vector<Eigen::Vector2d> CourseFields::places(const char* key, std::size_t fewest) {
  const auto entry = fewest > 0 ? require(key) : find(key);
  if (!entry) return {};
  const auto items = take(entry->items());
  if (!items) return {};
  std::vector<Eigen::Vector2d> places;
  for (const Field& item : *items) {
    const auto values = take(item.numbers(2));
    if (!values) return {};
    places.emplace_back((*values)[0], (*values)[1]);
    if (places.back().cwiseAbs().maxCoeff() > kFarthest_m) {
      refuse(key, ErrorCode::kBadValue, "too far away",
             fmt::format("Places are within {} m", kFarthest_m));
    }
  }
  if (places.size() < fewest) {
    refuse(key, ErrorCode::kBadValue, fmt::format("{} places are too few", places.size()),
           fmt::format("Write at least {}: [[x, y], [x, y], ...]", fewest));
  }
  return places;
}

Surface CourseFields::surface(const char* key, Surface otherwise) {
  const auto entry = find(key);
  if (!entry) return otherwise;
  const auto name = take(entry->text());
  if (!name) return otherwise;
  if (const auto surface = surface_named(*name)) return *surface;
  const std::string near = nearest_name(*name, surface_names());
  refuse(key, ErrorCode::kBadValue, fmt::format("there is no surface '{}'", *name),
         near.empty() ? fmt::format("Known are: {}", fmt::join(surface_names(), ", "))
                      : fmt::format("Did you mean '{}'?", near));
  return otherwise;
}

std::string CourseFields::text(const char* key, const std::string& otherwise) {
  const auto entry = find(key);
  if (!entry) return otherwise;
  return take(entry->text()).value_or(otherwise);
}

std::size_t CourseFields::choice(const char* key, const std::vector<std::string>& words,
                                 std::size_t otherwise) {
  const auto entry = find(key);
  if (!entry) return otherwise;
  const auto word = take(entry->text());
  if (!word) return otherwise;
  const auto found = std::find(words.begin(), words.end(), *word);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  const std::string near = nearest_name(*word, words);
  refuse(key, ErrorCode::kBadValue, fmt::format("'{}' is none of the choices", *word),
         near.empty() ? fmt::format("Known are: {}", fmt::join(words, ", "))
                      : fmt::format("Did you mean '{}'?", near));
  return otherwise;
}

Status CourseFields::done() const {
  if (error_) return tl::unexpected<Error>(*error_);
  return field_.allow_only(asked_);
}

}  // namespace tread::internal
