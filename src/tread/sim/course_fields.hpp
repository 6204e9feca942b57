// Internal to sim: reads the entries of one map of a course file. The first error sticks, so that a
// reader is a list of its entries; done() gives it, or refuses entries that nobody asked for.
//
//   CourseFields fields(field);
//   const double rise = fields.number("rise_m", 0.15, 0.01, 1.0);
//   if (Status s = fields.done(); !s) return s;
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "tread/io/text_tree.hpp"
#include "tread/sim/surface.hpp"

namespace tread::internal {

constexpr double kDegree = std::numbers::pi / 180.0;

class CourseFields {
 public:
  explicit CourseFields(const Field& field) : field_(field) {}

  // Between low and high, both allowed; the default if it is not there.
  [[nodiscard]] double number(const char* key, double otherwise, double low, double high);
  [[nodiscard]] double required_number(const char* key, double low, double high);
  [[nodiscard]] int whole(const char* key, int otherwise, int low, int high);
  [[nodiscard]] double angle(const char* key_deg, double otherwise_deg, double low, double high) {
    return kDegree * number(key_deg, otherwise_deg, low, high);
  }
  // Pairs of metres; the largest course is some kilometres.
  [[nodiscard]] Eigen::Vector2d place(const char* key);
  [[nodiscard]] Eigen::Vector2d place(const char* key, const Eigen::Vector2d& otherwise);
  [[nodiscard]] Eigen::Vector3d sizes(const char* key, const Eigen::Vector3d& otherwise, double low,
                                      double high);
  [[nodiscard]] std::vector<Eigen::Vector2d> places(const char* key, std::size_t fewest);
  [[nodiscard]] Surface surface(const char* key, Surface otherwise);
  [[nodiscard]] std::string text(const char* key, const std::string& otherwise);
  // One of several words, as its number.
  [[nodiscard]] std::size_t choice(const char* key, const std::vector<std::string>& words,
                                   std::size_t otherwise);
  // The entry itself, to be read by other means.
  [[nodiscard]] std::optional<Field> find(const char* key);
  [[nodiscard]] bool has(const char* key) { return find(key).has_value(); }

  void refuse(const char* key, ErrorCode code, const std::string& what, const std::string& remedy);
  [[nodiscard]] Status done() const;
  [[nodiscard]] bool good() const { return !error_; }
  [[nodiscard]] const Field& field() const { return field_; }

 private:
  template <class T>
  [[nodiscard]] std::optional<T> take(const Result<T>& value);
  [[nodiscard]] std::optional<Field> require(const char* key);

  Field field_;
  std::vector<std::string> asked_;
  std::optional<Error> error_;
};

}  // namespace tread::internal
