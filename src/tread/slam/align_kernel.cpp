#include "tread/slam/align_kernel.hpp"

#include <algorithm>
#include <array>

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/slam/align_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using F32 = hn::ScalableTag<float>;
using I32 = hn::RebindToSigned<F32>;
using Floats = hn::Vec<F32>;
using Ints = hn::Vec<I32>;

HWY_INLINE Floats set(float v) {
  return hn::Set(F32(), v);
}
HWY_INLINE Floats zero() {
  return hn::Zero(F32());
}

struct Vector3 {
  Floats x, y, z;
};
HWY_INLINE Floats dot(const Vector3& a, const Vector3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Vector3 cross(const Vector3& a, const Vector3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
HWY_INLINE Vector3 rotate(const float* R, const Vector3& p) {
  const auto row = [&](int i) HWY_ATTR {
    return hn::MulAdd(set(R[i]), p.x, hn::MulAdd(set(R[i + 1]), p.y, hn::Mul(set(R[i + 2]), p.z)));
  };
  return {row(0), row(3), row(6)};
}
HWY_INLINE Vector3 move(const float* R, const float* t, const Vector3& p) {
  const Vector3 r = rotate(R, p);
  return {hn::Add(r.x, set(t[0])), hn::Add(r.y, set(t[1])), hn::Add(r.z, set(t[2]))};
}

// 1, and beyond `limit` so that the error grows linearly only.
HWY_INLINE Floats huber_weight(Floats r, Floats limit) {
  return hn::Min(set(1.0F), hn::Div(limit, hn::Max(hn::Abs(r), limit)));
}

HWY_INLINE double total(Floats v) {
  HWY_ALIGN float lanes[hn::MaxLanes(F32())];
  hn::Store(v, F32(), lanes);
  double sum = 0.0;
  for (std::size_t i = 0; i < hn::Lanes(F32()); ++i) sum += lanes[i];
  return sum;
}

// The sums of NormalEquations, lane by lane.
template <bool kCross>
struct Sums {
  Floats H[21], g[6], K[kCross ? 21 : 1], error, weight, count;

  HWY_INLINE void clear() {
    for (Floats& v : H) v = zero();
    for (Floats& v : g) v = zero();
    for (Floats& v : K) v = zero();
    error = weight = count = zero();
  }
  HWY_INLINE void add(const Floats* J, const Floats* other, Floats r, Floats w) {
    Floats wJ[6];
    for (int i = 0; i < 6; ++i) wJ[i] = hn::Mul(w, J[i]);
    int k = 0;
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j, ++k) H[k] = hn::MulAdd(wJ[i], J[j], H[k]);
      g[i] = hn::MulAdd(wJ[i], r, g[i]);
    }
    if constexpr (kCross) {
      k = 0;
      for (int i = 0; i < 6; ++i) {
        for (int j = i; j < 6; ++j, ++k) {
          K[k] = hn::MulAdd(wJ[i], other[j], hn::MulAdd(wJ[j], other[i], K[k]));
        }
      }
    }
    error = hn::MulAdd(hn::Mul(w, r), r, error);
    weight = hn::Add(weight, w);
    count = hn::Add(count, hn::IfThenElseZero(hn::Gt(w, zero()), set(1.0F)));
  }
  HWY_INLINE void give(NormalEquations& out) const {
    int k = 0;
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j, ++k) {
        const double h = total(H[k]), c = kCross ? 0.5 * total(K[kCross ? k : 0]) : 0.0;
        out.H(i, j) += h;
        out.cross(i, j) += c;
        if (i == j) continue;
        out.H(j, i) += h;
        out.cross(j, i) += c;
      }
      out.g(i) += total(g[i]);
    }
    out.error += total(error);
    out.weight += total(weight);
    out.count += static_cast<std::int64_t>(total(count) + 0.5);
  }
};

template <bool kCross>
HWY_NOINLINE void icp_row(const IcpJob& job, int y, NormalEquations& out) {
  const F32 f32;
  const I32 i32;
  const int lanes = static_cast<int>(hn::Lanes(f32));
  const DepthView& frame = job.frame;
  const DepthView& model = job.model;
  const int width = frame.depth.width;
  const Pinhole& camera = frame.camera;
  const Pinhole& other = model.camera;
  const Floats yn = set((static_cast<float>(y) - camera.cy) / camera.fy);
  const Ints model_width = hn::Set(i32, model.depth.width),
             model_height = hn::Set(i32, model.depth.height);
  const Ints stride = hn::Set(i32, static_cast<std::int32_t>(model.depth.stride));
  const Floats gate = set(job.gate_m * job.gate_m);
  Sums<kCross> sums;
  sums.clear();
  HWY_ALIGN float ends[4][hn::MaxLanes(F32())];
  for (int x = 0; x < width; x += lanes) {
    // Rows end with whole vectors of memory or not: the last one is filled up with unknown depth.
    const auto row_of = [&](const ImageView<const float>& image, int i) HWY_ATTR {
      const float* row = image.row(y) + x;
      if (x + lanes <= width) return hn::LoadU(f32, row);
      std::fill(std::copy(row, row + (width - x), ends[i]), ends[i] + lanes,
                std::numeric_limits<float>::quiet_NaN());
      return hn::Load(f32, ends[i]);
    };
    const Floats z = row_of(frame.depth, 0);
    auto good = hn::Gt(z, zero());
    if (hn::AllFalse(f32, good)) continue;
    const Floats xn = hn::Mul(hn::Sub(hn::ConvertTo(f32, hn::Iota(i32, x)), set(camera.cx)),
                              set(1.0F / camera.fx));
    const Vector3 q = move(job.R, job.t, {hn::Mul(xn, z), hn::Mul(yn, z), z});
    const Floats inverse = hn::Div(set(1.0F), q.z);
    const auto project = [&](Floats a, float f, float c) HWY_ATTR {
      const Floats pixel = hn::MulAdd(hn::Mul(a, inverse), set(f), set(c));
      return hn::NearestInt(hn::Min(hn::Max(pixel, set(-2.0F)), set(1e6F)));
    };
    const Ints u = project(q.x, other.fx, other.cx), v = project(q.y, other.fy, other.cy);
    const auto inside = hn::And(hn::And(hn::Gt(u, hn::Set(i32, -1)), hn::Lt(u, model_width)),
                                hn::And(hn::Gt(v, hn::Set(i32, -1)), hn::Lt(v, model_height)));
    good = hn::And(good, hn::And(hn::Gt(q.z, zero()), hn::RebindMask(f32, inside)));
    if (hn::AllFalse(f32, good)) continue;
    const Ints pixel = hn::IfThenElseZero(inside, hn::Add(hn::Mul(v, stride), u));
    const Floats model_z = hn::GatherIndex(f32, model.depth.row(0), pixel);
    const Vector3 n{hn::GatherIndex(f32, model.normal[0].row(0), pixel),
                    hn::GatherIndex(f32, model.normal[1].row(0), pixel),
                    hn::GatherIndex(f32, model.normal[2].row(0), pixel)};
    const auto bearing = [&](Ints at, float f, float c) HWY_ATTR {
      return hn::Mul(hn::Sub(hn::ConvertTo(f32, at), set(c)), set(1.0F / f));
    };
    const Vector3 e{hn::NegMulAdd(bearing(u, other.fx, other.cx), model_z, q.x),
                    hn::NegMulAdd(bearing(v, other.fy, other.cy), model_z, q.y),
                    hn::Sub(q.z, model_z)};
    const Vector3 own = rotate(job.R, {row_of(frame.normal[0], 1), row_of(frame.normal[1], 2),
                                       row_of(frame.normal[2], 3)});
    const Floats r = dot(n, e);
    const Floats sigma = hn::MulAdd(hn::Mul(z, z), set(job.quadratic_per_m), set(job.constant_m));
    // Unknown depths and normals are not a number, and no comparison with one holds.
    good =
        hn::And(good, hn::And(hn::Le(dot(e, e), gate), hn::Ge(dot(own, n), set(job.least_cosine))));
    const Floats w = hn::IfThenElseZero(
        good, hn::Div(huber_weight(r, hn::Mul(sigma, set(job.huber))), hn::Mul(sigma, sigma)));
    const auto clean = [&](Floats a) HWY_ATTR { return hn::IfThenElseZero(good, a); };
    const Vector3 turn = cross(q, n);
    const Floats J[6] = {clean(n.x),    clean(n.y),    clean(n.z),
                         clean(turn.x), clean(turn.y), clean(turn.z)};
    Floats K[6];
    if constexpr (kCross) {
      const Vector3 own_turn = cross(q, own);
      K[0] = clean(own.x);
      K[1] = clean(own.y);
      K[2] = clean(own.z);
      K[3] = clean(own_turn.x);
      K[4] = clean(own_turn.y);
      K[5] = clean(own_turn.z);
    }
    sums.add(J, K, clean(r), w);
  }
  sums.give(out);
}

void icp_rows_here(const IcpJob& job, int first, int last, bool with_cross, NormalEquations& sums) {
  for (int y = first; y < last; ++y) {
    with_cross ? icp_row<true>(job, y, sums) : icp_row<false>(job, y, sums);
  }
}

template <bool kCross>
void photo_points_of(const PhotoJob& job, int first, int last, PhotoSums& out) {
  const F32 f32;
  const I32 i32;
  const int lanes = static_cast<int>(hn::Lanes(f32));
  const PhotoPointsView& points = job.points;
  const auto stride = hn::Set(i32, static_cast<std::int32_t>(job.image.stride));
  const Floats most_u = set(static_cast<float>(job.image.width - 1)),
               most_v = set(static_cast<float>(job.image.height - 1));
  const Floats sigma = set(job.sigma);
  const Floats information = set(1.0F / (job.sigma * job.sigma));
  Sums<kCross> sums;
  sums.clear();
  Floats key = zero(), here = zero(), key_here = zero(), here_here = zero(), absolute = zero();
  HWY_ALIGN float ends[6][hn::MaxLanes(F32())];
  for (int i = first; i < last; i += lanes) {
    const auto take = [&](const float* values, int k) HWY_ATTR {
      const float* from = values + i;
      if (i + lanes <= last) return hn::LoadU(f32, from);
      std::fill(std::copy(from, from + (last - i), ends[k]), ends[k] + lanes, -1.0F);
      return hn::Load(f32, ends[k]);
    };
    const Vector3 P{take(points.x, 0), take(points.y, 1), take(points.z, 2)};
    const Vector3 q = move(job.R, job.t, P);
    const Floats inverse = hn::Div(set(1.0F), q.z);
    const Floats u = hn::MulAdd(hn::Mul(q.x, inverse), set(job.camera.fx), set(job.camera.cx));
    const Floats v = hn::MulAdd(hn::Mul(q.y, inverse), set(job.camera.fy), set(job.camera.cy));
    auto good = hn::And(hn::Gt(P.z, zero()), hn::Gt(q.z, zero()));
    good = hn::And(good, hn::And(hn::And(hn::Ge(u, zero()), hn::Lt(u, most_u)),
                                 hn::And(hn::Ge(v, zero()), hn::Lt(v, most_v))));
    if (hn::AllFalse(f32, good)) continue;
    const Floats safe_u = hn::IfThenElseZero(good, u), safe_v = hn::IfThenElseZero(good, v);
    const Ints x = hn::ConvertTo(i32, safe_u), y = hn::ConvertTo(i32, safe_v);
    const Floats fu = hn::Sub(safe_u, hn::ConvertTo(f32, x));
    const Floats fv = hn::Sub(safe_v, hn::ConvertTo(f32, y));
    const Ints pixel = hn::Add(hn::Mul(y, stride), x);
    const Ints below = hn::Add(pixel, stride);
    const auto sample = [&](const float* image) HWY_ATTR {
      const Floats a = hn::GatherIndex(f32, image, pixel);
      const Floats b = hn::GatherIndex(f32, image + 1, pixel);
      const Floats c = hn::GatherIndex(f32, image, below);
      const Floats d = hn::GatherIndex(f32, image + 1, below);
      const Floats upper = hn::MulAdd(hn::Sub(b, a), fu, a);
      const Floats lower = hn::MulAdd(hn::Sub(d, c), fu, c);
      return hn::MulAdd(hn::Sub(lower, upper), fv, upper);
    };
    const Floats now = sample(job.image.data);
    const Floats was = take(points.intensity, 3);
    const Floats r = hn::Sub(hn::MulAdd(set(job.gain), now, set(job.offset)), was);
    const Floats w = hn::IfThenElseZero(
        good, hn::Mul(information, huber_weight(r, hn::Mul(sigma, set(job.huber)))));
    const auto clean = [&](Floats a) HWY_ATTR { return hn::IfThenElseZero(good, a); };
    // (gx, gy) d pi / d P of the keyframe.
    const Floats inverse_z = hn::Div(set(1.0F), P.z);
    const auto jacobian = [&](Floats gx, Floats gy, Floats* J) HWY_ATTR {
      const Floats a = hn::Mul(hn::Mul(gx, set(job.camera.fx)), inverse_z);
      const Floats b = hn::Mul(hn::Mul(gy, set(job.camera.fy)), inverse_z);
      const Vector3 slope{a, b, hn::Neg(hn::Mul(hn::MulAdd(a, P.x, hn::Mul(b, P.y)), inverse_z))};
      const Vector3 turn = cross(P, slope);
      J[0] = clean(slope.x);
      J[1] = clean(slope.y);
      J[2] = clean(slope.z);
      J[3] = clean(turn.x);
      J[4] = clean(turn.y);
      J[5] = clean(turn.z);
    };
    Floats J[6], K[6];
    jacobian(take(points.gx, 4), take(points.gy, 5), J);
    if constexpr (kCross) jacobian(sample(job.image_gx.data), sample(job.image_gy.data), K);
    const Floats residual = clean(r);
    sums.add(J, K, residual, w);
    const Floats w_now = hn::Mul(w, clean(now)), known_was = clean(was);
    key = hn::MulAdd(w, known_was, key);
    here = hn::Add(here, w_now);
    key_here = hn::MulAdd(w_now, known_was, key_here);
    here_here = hn::MulAdd(w_now, clean(now), here_here);
    absolute = hn::Add(absolute, hn::Abs(residual));
  }
  sums.give(out.equations);
  out.key += total(key);
  out.here += total(here);
  out.key_here += total(key_here);
  out.here_here += total(here_here);
  out.absolute += total(absolute);
}

void photo_points_here(const PhotoJob& job, int first, int last, bool with_cross, PhotoSums& sums) {
  with_cross ? photo_points_of<true>(job, first, last, sums)
             : photo_points_of<false>(job, first, last, sums);
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(icp_rows_here);
HWY_EXPORT(photo_points_here);

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  H += other.H;
  g += other.g;
  cross += other.cross;
  error += other.error;
  weight += other.weight;
  count += other.count;
  return *this;
}

PhotoSums& PhotoSums::operator+=(const PhotoSums& other) {
  equations += other.equations;
  key += other.key;
  here += other.here;
  key_here += other.key_here;
  here_here += other.here_here;
  absolute += other.absolute;
  return *this;
}

void PhotoPoints::clear() {
  for (std::vector<float>* values : {&x, &y, &z, &intensity, &gx, &gy}) values->clear();
}

void icp_rows(const IcpJob& job, int first, int last, bool with_cross, NormalEquations& sums) {
  HWY_DYNAMIC_DISPATCH(icp_rows_here)(job, first, last, with_cross, sums);
}
void photo_points(const PhotoJob& job, int first, int last, bool with_cross, PhotoSums& sums) {
  HWY_DYNAMIC_DISPATCH(photo_points_here)(job, first, last, with_cross, sums);
}
}  // namespace tread
#endif
