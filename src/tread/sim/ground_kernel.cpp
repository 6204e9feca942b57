#include "tread/sim/ground_kernel.hpp"

#include <algorithm>
#include <cmath>

#include "tread/sim/hash_noise_kernel.hpp"

// Compiled once for every instruction set, as texture_kernel.cpp is.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/sim/ground_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

constexpr int kN = 16;
using Floats = float[kN];
using Doubles = double[kN];
using Indices = std::int32_t[kN];

// All that is known of sixteen rays and their squares. Compilers make vectors of loops over these
// rows, since they see that none lies over another; what is read from anywhere is read before.
struct Block {
  alignas(64) Doubles origin[3], direction[3];  // scene axes
  alignas(64) Doubles rough, distance;
  alignas(64) Indices corner;             // vertex (x, y) of the square
  alignas(64) Doubles x, y;               // that vertex, in cells
  alignas(64) Floats h00, h10, h01, h11;  // heights of the square's corners
  alignas(64) Floats sx[4], sy[4];        // smooth slopes at them, in the same order
  alignas(64) Floats a, b;                // place in the square, 0 to 1
  alignas(64) Floats flat_x, flat_y;      // slopes of the triangle
  alignas(64) Floats spread, footprint;
  alignas(64) Floats point[3], normal[3], from[3];
};

void load(const RayBatch& rays, const Eigen::Vector3d& centre, int first, const float* rough,
          Block& s) {
  const auto at = static_cast<std::size_t>(first);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double middle = centre(static_cast<Eigen::Index>(axis));
    for (std::size_t i = 0; i < kN; ++i) {
      s.origin[axis][i] = rays.origin[axis][at + i] - middle;
      s.direction[axis][i] = rays.direction[axis][at + i];
    }
  }
  for (std::size_t i = 0; i < kN; ++i) {
    s.rough[i] = static_cast<double>(rough[i]);
    s.spread[i] = rays.spread_rad[at + i];
  }
}

void find_squares(const GroundView& g, const std::uint32_t* part, Block& s) {
  const std::int32_t squares = g.columns - 1;
  const double per_row = 1.0 / squares;
  for (int i = 0; i < kN; ++i) {
    const auto number = static_cast<std::int32_t>(part[i]);
    // A half in the numerator: whole quotients stay whole.
    const auto y = static_cast<std::int32_t>((number + 0.5) * per_row);
    const std::int32_t x = number - y * squares;
    s.corner[i] = y * g.columns + x;
    s.x[i] = x;
    s.y[i] = y;
  }
  for (int i = 0; i < kN; ++i) {
    const GroundVertex* low = g.vertices + s.corner[i];
    const GroundVertex* high = low + g.columns;
    s.h00[i] = low[0].height;
    s.h10[i] = low[1].height;
    s.h01[i] = high[0].height;
    s.h11[i] = high[1].height;
    s.sx[0][i] = low[0].slope_x;
    s.sx[1][i] = low[1].slope_x;
    s.sx[2][i] = high[0].slope_x;
    s.sx[3][i] = high[1].slope_x;
    s.sy[0][i] = low[0].slope_y;
    s.sy[1][i] = low[1].slope_y;
    s.sy[2][i] = high[0].slope_y;
    s.sy[3][i] = high[1].slope_y;
  }
}

// Distances along the rays to the planes of the triangles; GroundSurface::hit says the same of one.
void find_distances(const GroundView& g, Block& s) {
  const double cells = 1.0 / g.resolution_m, cell_m = g.resolution_m, first_x = g.first_x,
               first_y = g.first_y;
  for (int i = 0; i < kN; ++i) {
    const double h00 = static_cast<double>(s.h00[i]), h10 = static_cast<double>(s.h10[i]),
                 h01 = static_cast<double>(s.h01[i]), h11 = static_cast<double>(s.h11[i]);
    const double dx = s.direction[0][i], dy = s.direction[1][i];
    // From the corner of the square to the ray's origin, and to where it comes out.
    const double from_x = s.origin[0][i] - first_x - s.x[i] * cell_m,
                 from_y = s.origin[1][i] - first_y - s.y[i] * cell_m;
    const double way = s.rough[i];
    const double a = (from_x + way * dx) * cells, b = (from_y + way * dy) * cells;
    const bool upper = a + b > 1.0;
    const double sx = cells * (upper ? h11 - h01 : h10 - h00),
                 sy = cells * (upper ? h11 - h10 : h01 - h00), h = upper ? h10 + h01 - h11 : h00;
    const double above = s.origin[2][i] - h - sx * from_x - sy * from_y;
    const double exact = above / (sx * dx + sy * dy - s.direction[2][i]);
    // Along the plane nothing better than the tracer's distance can be said.
    s.distance[i] = std::abs(exact - way) < 1e-3 + 1e-3 * way ? exact : way;
    s.a[i] = static_cast<float>(a);
    s.b[i] = static_cast<float>(b);
    s.flat_x[i] = static_cast<float>(sx);
    s.flat_y[i] = static_cast<float>(sy);
  }
}

HWY_INLINE float between(const Floats* corners, int i, float a, float b) {
  const float west = corners[0][i] + b * (corners[2][i] - corners[0][i]),
              east = corners[1][i] + b * (corners[3][i] - corners[1][i]);
  return west + a * (east - west);
}

void find_normals(Block& s) {
  for (int i = 0; i < kN; ++i) {
    const float sx = between(s.sx, i, s.a[i], s.b[i]), sy = between(s.sy, i, s.a[i], s.b[i]);
    const float fx = s.flat_x[i], fy = s.flat_y[i];
    const float smooth = 1.0F / std::sqrt(1.0F + sx * sx + sy * sy),
                flat = 1.0F / std::sqrt(1.0F + fx * fx + fy * fy);
    // Smooth, but for edges, where the two differ by more than 14 to 30 degrees.
    const float alike = smooth * flat * (1.0F + sx * fx + sy * fy);
    const float share = smooth_step(0.85F, 0.97F, alike);
    const float nx = -flat * fx + share * (flat * fx - smooth * sx),
                ny = -flat * fy + share * (flat * fy - smooth * sy),
                nz = flat + share * (smooth - flat);
    const float length = 1.0F / std::sqrt(nx * nx + ny * ny + nz * nz);
    s.normal[0][i] = length * nx;
    s.normal[1][i] = length * ny;
    s.normal[2][i] = length * nz;
  }
}

void find_points(Block& s) {
  for (int i = 0; i < kN; ++i) {
    const double t = s.distance[i];
    const auto x = static_cast<float>(s.origin[0][i] + t * s.direction[0][i]),
               y = static_cast<float>(s.origin[1][i] + t * s.direction[1][i]),
               z = static_cast<float>(s.origin[2][i] + t * s.direction[2][i]);
    s.point[0][i] = x;
    s.point[1][i] = y;
    s.point[2][i] = z;
    const float fx = s.flat_x[i], fy = s.flat_y[i];
    const float flat = 1.0F / std::sqrt(1.0F + fx * fx + fy * fy);
    const float facing =
        flat * (fx * static_cast<float>(s.direction[0][i]) +
                fy * static_cast<float>(s.direction[1][i]) - static_cast<float>(s.direction[2][i]));
    s.footprint[i] =
        s.spread[i] * static_cast<float>(t) / std::sqrt(larger_of(magnitude(facing), kGrazing));
    // Off the ground, on the side it is seen from, by more than single precision may be wrong.
    const float amount = flat * (kOffM + kOffShare * (magnitude(x) + magnitude(y) + magnitude(z)));
    const float off = facing > 0.0F ? amount : -amount;
    s.from[0][i] = x - off * fx;
    s.from[1][i] = y - off * fy;
    s.from[2][i] = z + off;
  }
}

void store(const Block& s, int first, SurfaceBatch& points) {
  const auto put = [first](const Floats& from, SurfaceBatch::Row<float>& to) {
    std::copy_n(from, kN, to.begin() + first);
  };
  std::copy_n(s.distance, kN, points.distance_m.begin() + first);
  put(s.footprint, points.footprint_m);
  put(s.point[0], points.u);
  put(s.point[1], points.v);
  put(s.point[2], points.w);
  put(s.normal[0], points.normal_x);
  put(s.normal[1], points.normal_y);
  put(s.normal[2], points.normal_z);
  for (std::size_t axis = 0; axis < 3; ++axis) put(s.from[axis], points.from[axis]);
}

// How far, in cells, the look of the ground at a place (in cells) is taken from beside it, so that
// borders between materials are ragged: cells are how the world is written, not how it looks.
HWY_INLINE void ragged(float x, float y, float& dx, float& dy) {
  constexpr float kReach = 0.9F, kFrequency = 1.3F;
  const float u = kFrequency * x, v = kFrequency * y;
  dx = kReach * (gradient_noise(u, v, 1U) + 0.7F * gradient_noise(2.0F * u, 2.0F * v, 2U) +
                 0.5F * gradient_noise(5.0F * u, 5.0F * v, 3U));
  dy = kReach * (gradient_noise(u, v, 4U) + 0.7F * gradient_noise(2.0F * u, 2.0F * v, 5U) +
                 0.5F * gradient_noise(5.0F * u, 5.0F * v, 6U));
}

void find_materials(const GroundView& g, int first, const Block& s, SurfaceBatch& points) {
  auto* material = &points.material[static_cast<std::size_t>(first)];
  std::uint32_t border = 0;
  for (int i = 0; i < kN; ++i) {
    const std::int32_t nearest = s.corner[i] + static_cast<std::int32_t>(s.a[i] > 0.5F) +
                                 g.columns * static_cast<std::int32_t>(s.b[i] > 0.5F);
    const std::uint32_t look = g.vertices[nearest].look;
    material[i] = static_cast<std::int32_t>(look);
    border |= look;
  }
  if ((border & kGroundBorder) == 0) return;
  alignas(64) Floats x, y;
  for (int i = 0; i < kN; ++i) {
    const float cx = static_cast<float>(s.x[i]) + s.a[i], cy = static_cast<float>(s.y[i]) + s.b[i];
    float dx = 0.0F, dy = 0.0F;
    ragged(cx, cy, dx, dy);
    x[i] = cx + dx + 0.5F;
    y[i] = cy + dy + 0.5F;
  }
  Indices beside;
  for (int i = 0; i < kN; ++i) {
    beside[i] = std::clamp(lattice_floor(y[i]), 0, g.rows - 1) * g.columns +
                std::clamp(lattice_floor(x[i]), 0, g.columns - 1);
  }
  for (int i = 0; i < kN; ++i) {
    if ((static_cast<std::uint32_t>(material[i]) & kGroundBorder) != 0) {
      material[i] = static_cast<std::int32_t>(g.vertices[beside[i]].look & (kGroundBorder - 1U));
    }
  }
}

void meet_ground_here(const GroundView& ground, const RayBatch& rays, const Eigen::Vector3d& centre,
                      const Eigen::Vector3d& sun, int first, const std::uint32_t* part,
                      const float* rough, SurfaceBatch& points) {
  Block block;
  load(rays, centre, first, rough, block);
  find_squares(ground, part, block);
  find_distances(ground, block);
  find_normals(block);
  find_points(block);
  store(block, first, points);
  find_materials(ground, first, block, points);
  const auto sun_u = static_cast<float>(sun.x()), sun_v = static_cast<float>(sun.y()),
             sun_w = static_cast<float>(sun.z());
  // Smooth light on flat triangles: those just in front are no shadow.
  const auto clear = static_cast<float>(0.25 * ground.resolution_m);
  for (std::size_t i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(first) + kN;
       ++i) {
    points.sun_u[i] = sun_u;
    points.sun_v[i] = sun_v;
    points.sun_w[i] = sun_w;
    points.clear_m[i] = clear;
    points.through[i] = 0.0F;
  }
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {

HWY_EXPORT(meet_ground_here);

void meet_ground(const GroundView& ground, const RayBatch& rays, const Eigen::Vector3d& centre,
                 const Eigen::Vector3d& sun, int first, const std::uint32_t* part,
                 const float* rough, SurfaceBatch& points) {
  HWY_DYNAMIC_DISPATCH(meet_ground_here)(ground, rays, centre, sun, first, part, rough, points);
}

}  // namespace tread
#endif
