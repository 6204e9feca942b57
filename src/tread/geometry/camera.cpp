#include "tread/geometry/camera.hpp"

#include <cassert>
#include <cmath>
#include <vector>

namespace tread {
namespace {

std::vector<std::string> parameter_names(const PinholeCamera&) {
  return {"fx", "fy", "cx", "cy", "skew"};
}

std::vector<std::string> parameter_names(const BrownCamera& camera) {
  std::vector<std::string> names = parameter_names(camera.pinhole);
  names.insert(names.end(), {"lx", "ly"});
  for (int i = 1; i <= 5; ++i) names.push_back("K" + std::to_string(i));
  for (int i = 1; i <= 5; ++i) names.push_back("P" + std::to_string(i));
  for (int i = 1; i <= 3; ++i) names.push_back("D" + std::to_string(i));
  return names;
}

std::vector<std::string> parameter_names(const KannalaBrandtCamera&) {
  return {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"};
}

PinholeCamera scaled_pinhole(const PinholeCamera& camera, double factor) {
  // The corner of the image, half a pixel before the centre of the first, stays the corner.
  return {camera.fx * factor, camera.fy * factor, (camera.cx + 0.5) * factor - 0.5,
          (camera.cy + 0.5) * factor - 0.5, camera.skew * factor};
}

}  // namespace

Projection project(const CameraModel& camera, const Eigen::Vector3d& p) {
  return std::visit([&p](const auto& model) { return model.project(p); }, camera);
}

Unprojection unproject(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  return std::visit([&pixel](const auto& model) { return model.unproject(pixel); }, camera);
}

PinholeCamera pinhole_of(const CameraModel& camera) {
  if (const auto* brown = std::get_if<BrownCamera>(&camera)) return brown->pinhole;
  if (const auto* wide = std::get_if<KannalaBrandtCamera>(&camera)) {
    return {wide->fx, wide->fy, wide->cx, wide->cy, 0.0};
  }
  return std::get<PinholeCamera>(camera);
}

Status check_camera(const CameraModel& camera, const std::string& where) {
  const auto [values, names] = std::visit(
      [](const auto& model) { return std::pair(model.parameters(), parameter_names(model)); },
      camera);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const std::string field = where + "." + names[static_cast<std::size_t>(i)];
    if (!std::isfinite(values[i])) {
      return fail(ErrorCode::kBadValue, "not a finite number", field, "Write a number");
    }
    if (i < 2 && values[i] <= 0.0) {
      return fail(ErrorCode::kBadValue,
                  values[i] == 0.0 ? "focal length is 0" : "focal length is negative", field,
                  "Write the focal length in pixels, above 0");
    }
  }
  return {};
}

CameraModel scaled(const CameraModel& camera, double factor) {
  assert(factor > 0.0);
  const PinholeCamera pinhole = scaled_pinhole(pinhole_of(camera), factor);
  if (const auto* brown = std::get_if<BrownCamera>(&camera)) {
    BrownCamera result = *brown;
    result.pinhole = pinhole;
    return result;
  }
  if (const auto* wide = std::get_if<KannalaBrandtCamera>(&camera)) {
    return KannalaBrandtCamera{pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy, wide->k};
  }
  return pinhole;
}

}  // namespace tread
