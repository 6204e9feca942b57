#include "tread/slam/depth_kernel.hpp"

#include <algorithm>
#include <limits>
#include <utility>

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/slam/depth_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using F32 = hn::ScalableTag<float>;
using Floats = hn::Vec<F32>;

HWY_INLINE Floats set(float v) {
  return hn::Set(F32(), v);
}
HWY_INLINE Floats unknown() {
  return set(std::numeric_limits<float>::quiet_NaN());
}

// Calls body(x) for vectors that cover [0, width) and stores what it returns.
template <class Body>
HWY_INLINE void for_vectors(int width, float* out, const Body& body) {
  const int lanes = static_cast<int>(hn::Lanes(F32()));
  HWY_ALIGN float last[hn::MaxLanes(F32())];
  for (int x = 0; x < width; x += lanes) {
    const Floats v = body(x);
    if (x + lanes <= width) {
      hn::StoreU(v, F32(), out + x);
    } else {
      hn::Store(v, F32(), last);
      std::copy(last, last + (width - x), out + x);
    }
  }
}

// Columns x to x + lanes - 1 of a row, NaN where there are none.
HWY_INLINE Floats load(const float* row, int width, int x) {
  const int lanes = static_cast<int>(hn::Lanes(F32()));
  if (row != nullptr && x >= 0 && x + lanes <= width) return hn::LoadU(F32(), row + x);
  HWY_ALIGN float part[hn::MaxLanes(F32())];
  for (int i = 0; i < lanes; ++i) {
    const int at = x + i;
    part[i] =
        row != nullptr && at >= 0 && at < width ? row[at] : std::numeric_limits<float>::quiet_NaN();
  }
  return hn::Load(F32(), part);
}

HWY_INLINE Floats three_sigma(const DepthNoise& noise, Floats z) {
  return hn::MulAdd(hn::Mul(z, z), set(static_cast<float>(3.0 * noise.quadratic_per_m)),
                    set(static_cast<float>(3.0 * noise.constant_m)));
}

void halve_row_here(ImageView<const float> depth, const DepthNoise& noise, int y, float* half) {
  const float* rows[2] = {depth.row(2 * y), depth.row(2 * y + 1)};
  const int width = depth.width / 2;
  const int lanes = static_cast<int>(hn::Lanes(F32()));
  for_vectors(width, half, [&](int x) HWY_ATTR {
    Floats four[4];
    for (int j = 0; j < 2; ++j) {
      const Floats a = load(rows[j], depth.width, 2 * x);
      const Floats b = load(rows[j], depth.width, 2 * x + lanes);
#if HWY_TARGET == HWY_SCALAR
      four[2 * j] = a;
      four[2 * j + 1] = b;
#else
      four[2 * j] = hn::ConcatEven(F32(), b, a);
      four[2 * j + 1] = hn::ConcatOdd(F32(), b, a);
#endif
    }
    const Floats far = set(std::numeric_limits<float>::max());
    Floats nearest = far;
    for (const Floats& z : four) nearest = hn::Min(nearest, hn::IfThenElse(hn::Eq(z, z), z, far));
    const Floats limit = hn::Add(nearest, three_sigma(noise, nearest));
    Floats sum = hn::Zero(F32()), count = hn::Zero(F32());
    for (const Floats& z : four) {
      const auto counts = hn::Le(z, limit);
      sum = hn::Add(sum, hn::IfThenElseZero(counts, z));
      count = hn::Add(count, hn::IfThenElseZero(counts, set(1.0F)));
    }
    return hn::IfThenElse(hn::Lt(nearest, far), hn::Div(sum, count), unknown());
  });
}

void smooth_row_here(ImageView<const float> depth, const DepthNoise& noise, float focal_px,
                     int spacing, int y, float* smooth) {
  const Floats slope = set(kSmoothSlope * 2.0F * static_cast<float>(spacing) / focal_px);
  const float* rows[5];
  for (int j = 0; j < 5; ++j) {
    const int from = y + (j - 2) * spacing;
    rows[j] = from >= 0 && from < depth.height ? depth.row(from) : nullptr;
  }
  for_vectors(depth.width, smooth, [&](int x) HWY_ATTR {
    const Floats z = load(rows[2], depth.width, x);
    const Floats gate = hn::MulAdd(z, slope, three_sigma(noise, z));
    Floats sum = hn::Zero(F32()), count = hn::Zero(F32());
    for (const float* row : rows) {
      if (row == nullptr) continue;
      for (int i = -2; i <= 2; ++i) {
        // The mean of differences: exact where all are one depth.
        const Floats away = hn::Sub(load(row, depth.width, x + i * spacing), z);
        const auto counts = hn::Le(hn::Abs(away), gate);
        sum = hn::Add(sum, hn::IfThenElseZero(counts, away));
        count = hn::Add(count, hn::IfThenElseZero(counts, set(1.0F)));
      }
    }
    return hn::Add(z, hn::Div(sum, count));  // 0 / 0 where z is unknown
  });
}

void normal_row_here(const Pinhole& camera, const DepthNoise& noise, ImageView<const float> depth,
                     int y, float* nx, float* ny, float* nz) {
  const int width = depth.width;
  const float* above = y > 0 ? depth.row(y - 1) : nullptr;
  const float* below = y + 1 < depth.height ? depth.row(y + 1) : nullptr;
  const float* here = depth.row(y);
  const Floats inverse_fx = set(1.0F / camera.fx), inverse_fy = set(1.0F / camera.fy);
  const Floats yn = set((static_cast<float>(y) - camera.cy) / camera.fy);
  const int lanes = static_cast<int>(hn::Lanes(F32()));
  HWY_ALIGN float last[3][hn::MaxLanes(F32())];
  for (int x = 0; x < width; x += lanes) {
    const Floats z = load(here, width, x);
    const Floats l = load(here, width, x - 1), r = load(here, width, x + 1);
    const Floats u = load(above, width, x), d = load(below, width, x);
    const Floats gate = hn::Mul(z, set(1.0F / 16.0F));
    auto known = hn::Le(hn::Abs(hn::Sub(l, z)), gate);
    for (const Floats& other : {r, u, d}) {
      known = hn::And(known, hn::Le(hn::Abs(hn::Sub(other, z)), gate));
    }
    // Planes have straight inverse depths.
    const Floats one = set(1.0F), square = hn::Mul(z, z);
    const Floats bend = hn::MulAdd(z, set(kLargestBend / camera.fx),
                                   hn::Mul(three_sigma(noise, z), set(1.0F / 3.0F)));
    const Floats twice = hn::Div(set(2.0F), z);
    for (const auto& [a, b] : {std::pair(l, r), std::pair(u, d)}) {
      const Floats off = hn::Sub(hn::Add(hn::Div(one, a), hn::Div(one, b)), twice);
      known = hn::And(known, hn::Le(hn::Mul(hn::Abs(off), square), bend));
    }
    const Floats xn = hn::Mul(
        hn::Sub(hn::ConvertTo(F32(), hn::Iota(hn::RebindToSigned<F32>(), x)), set(camera.cx)),
        inverse_fx);
    // Along the row (a, b, c) and the column (e, f, g): differences of the points of the
    // neighbours.
    const Floats c = hn::Sub(r, l), g = hn::Sub(d, u);
    const Floats a = hn::MulAdd(xn, c, hn::Mul(hn::Add(r, l), inverse_fx));
    const Floats b = hn::Mul(yn, c);
    const Floats e = hn::Mul(xn, g);
    const Floats f = hn::MulAdd(yn, g, hn::Mul(hn::Add(d, u), inverse_fy));
    // Column x row: towards the camera.
    const Floats px = hn::Sub(hn::Mul(f, c), hn::Mul(g, b));
    const Floats py = hn::Sub(hn::Mul(g, a), hn::Mul(e, c));
    const Floats pz = hn::Sub(hn::Mul(e, b), hn::Mul(f, a));
    const Floats length = hn::Sqrt(hn::MulAdd(px, px, hn::MulAdd(py, py, hn::Mul(pz, pz))));
    const Floats scale = hn::IfThenElse(known, hn::Div(set(1.0F), length), unknown());
    const Floats n[3] = {hn::Mul(px, scale), hn::Mul(py, scale), hn::Mul(pz, scale)};
    float* const out[3] = {nx, ny, nz};
    for (int i = 0; i < 3; ++i) {
      if (x + lanes <= width) {
        hn::StoreU(n[i], F32(), out[i] + x);
      } else {
        hn::Store(n[i], F32(), last[i]);
        std::copy(last[i], last[i] + (width - x), out[i] + x);
      }
    }
  }
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(halve_row_here);
HWY_EXPORT(smooth_row_here);
HWY_EXPORT(normal_row_here);

void halve_depth_row(ImageView<const float> depth, const DepthNoise& noise, int y, float* half) {
  HWY_DYNAMIC_DISPATCH(halve_row_here)(depth, noise, y, half);
}
void smooth_depth_row(ImageView<const float> depth, const DepthNoise& noise, float focal_px,
                      int spacing, int y, float* smooth) {
  HWY_DYNAMIC_DISPATCH(smooth_row_here)(depth, noise, focal_px, spacing, y, smooth);
}
void normal_row(const Pinhole& camera, const DepthNoise& noise, ImageView<const float> depth, int y,
                float* nx, float* ny, float* nz) {
  HWY_DYNAMIC_DISPATCH(normal_row_here)(camera, noise, depth, y, nx, ny, nz);
}
}  // namespace tread
#endif
