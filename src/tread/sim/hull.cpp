#include "tread/sim/hull.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tread/sim/random.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;

// As many points as asked for, each new one the farthest from the others of some tries: without
// slivers.
std::vector<Vector3d> spread_points(int count, Random& random) {
  constexpr int kTries = 24;
  std::vector<Vector3d> points;
  while (static_cast<int>(points.size()) < count) {
    Vector3d best = Vector3d::UnitZ();
    double best_gap = -1.0;
    for (int i = 0; i < kTries; ++i) {
      const double z = 2.0 * random.uniform() - 1.0,
                   turn = 2.0 * std::numbers::pi * random.uniform();
      const double r = std::sqrt(1.0 - z * z);
      const Vector3d p(r * std::cos(turn), r * std::sin(turn), z);
      double gap = 4.0;
      for (const Vector3d& other : points) gap = std::min(gap, (p - other).norm());
      if (gap > best_gap) {
        best_gap = gap;
        best = p;
      }
    }
    points.push_back(best);
  }
  return points;
}

// Every three points that have all others on one side are a face: n^4 / 6, which for a stone is
// nothing, and right without any bookkeeping.
std::vector<std::array<std::int32_t, 3>> faces_of(const std::vector<Vector3d>& points) {
  std::vector<std::array<std::int32_t, 3>> faces;
  const auto count = static_cast<std::int32_t>(points.size());
  const auto at = [&](std::int32_t i) -> const Vector3d& {
    return points[static_cast<std::size_t>(i)];
  };
  for (std::int32_t a = 0; a < count; ++a) {
    for (std::int32_t b = a + 1; b < count; ++b) {
      for (std::int32_t c = b + 1; c < count; ++c) {
        const Vector3d n = (at(b) - at(a)).cross(at(c) - at(a));
        bool above = false, below = false;
        for (std::int32_t d = 0; d < count && !(above && below); ++d) {
          if (d == a || d == b || d == c) continue;
          (n.dot(at(d) - at(a)) > 0.0 ? above : below) = true;
        }
        if (!above) faces.push_back({a, b, c});
        if (above && !below) faces.push_back({a, c, b});
      }
    }
  }
  return faces;
}

}  // namespace

Mesh stone_hull(int corners, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vector3d> points = spread_points(std::clamp(corners, 8, 40), random);
  // A stone is broken rather than turned: a few planes cut its ball.
  for (int cut = 0; cut < 3; ++cut) {
    const Vector3d n = points[static_cast<std::size_t>(random.uniform() * corners) % points.size()];
    const double depth = 0.55 + 0.3 * random.uniform();
    for (Vector3d& p : points) {
      // Moved unevenly by a hair, so that no four points are of one plane.
      if (n.dot(p) > depth) p *= (depth + 1e-3 * random.uniform()) / n.dot(p);
    }
  }
  Mesh mesh;
  mesh.triangles = faces_of(points);
  for (const Vector3d& p : points) mesh.vertices.push_back(p.cast<float>());
  return mesh;
}

}  // namespace tread
