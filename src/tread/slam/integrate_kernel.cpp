#include "tread/slam/integrate_kernel.hpp"

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/slam/integrate_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
// Sixteen voxels are two rows of a block; shorter vectors take part of that.
using F32 = hn::CappedTag<float, 16>;
using I32 = hn::RebindToSigned<F32>;
using I16 = hn::Rebind<std::int16_t, F32>;
using U8 = hn::Rebind<std::uint8_t, F32>;
using Floats = hn::Vec<F32>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(F32()));

HWY_INLINE Floats set(float v) {
  return hn::Set(F32(), v);
}

// Colour of the pixel that a voxel falls on, taken in with the weight the voxel has, at most 15:
// what is seen now counts a sixteenth at least.
void colour_voxel(const IntegrateFrame& frame, int u, int v, int weight, Rgb& colour) {
  const int w = std::min(weight, 15);
  Rgb now;
  if (!frame.rgb.empty()) {
    now = frame.rgb.row(v)[u];
  } else {
    const std::uint8_t g = frame.grey.row(v)[u];
    now = {g, g, g};
  }
  const auto mix = [w](std::uint8_t old, std::uint8_t seen) {
    return static_cast<std::uint8_t>((old * w + seen + (w + 1) / 2) / (w + 1));
  };
  colour = {mix(colour.r, now.r), mix(colour.g, now.g), mix(colour.b, now.b)};
}

void integrate_block_here(const IntegrateFrame& frame, int x, int y, int z, std::int16_t* distance,
                          std::uint8_t* weight, Rgb* colour) {
  const F32 f32;
  const I32 i32;
  const I16 i16;
  const U8 u8;
  const float* R = frame.R;
  // What lane i adds to the first voxel of a vector: i steps in x, and a row for each eight.
  HWY_ALIGN float step[3][kLanes];
  for (int i = 0; i < kLanes; ++i) {
    for (int k = 0; k < 3; ++k) {
      step[k][i] = R[3 * k] * static_cast<float>(i % kBlockSide) +
                   R[3 * k + 1] * static_cast<float>(i / kBlockSide);
    }
  }
  const Floats step_x = hn::Load(f32, step[0]), step_y = hn::Load(f32, step[1]),
               step_z = hn::Load(f32, step[2]);
  const Floats fx = set(frame.camera.fx), fy = set(frame.camera.fy);
  const Floats cx = set(frame.camera.cx), cy = set(frame.camera.cy);
  const auto width = hn::Set(i32, frame.depth.width), height = hn::Set(i32, frame.depth.height);
  const auto stride = hn::Set(i32, static_cast<std::int32_t>(frame.depth.stride));
  const Floats scale = set(kDistanceUnits / frame.voxel_m);
  const Floats zero = hn::Zero(f32), one = set(1.0F);
  const auto first_x = static_cast<float>(x);
  for (int voxel = 0; voxel < kBlockVoxels; voxel += kLanes) {
    const auto at_x = first_x + static_cast<float>(voxel % kBlockSide);
    const auto at_y = static_cast<float>(y + voxel / kBlockSide % kBlockSide);
    const auto at_z = static_cast<float>(z + voxel / (kBlockSide * kBlockSide));
    const auto coordinate = [&](int k, Floats steps) HWY_ATTR {
      return hn::Add(set(R[3 * k] * at_x + R[3 * k + 1] * at_y + R[3 * k + 2] * at_z + frame.t[k]),
                     steps);
    };
    const Floats X = coordinate(0, step_x), Y = coordinate(1, step_y), Z = coordinate(2, step_z);
    const Floats inverse = hn::Div(one, Z);
    const Floats xn = hn::Mul(X, inverse), yn = hn::Mul(Y, inverse);
    const auto u = hn::NearestInt(hn::MulAdd(xn, fx, cx));
    const auto v = hn::NearestInt(hn::MulAdd(yn, fy, cy));
    auto seen = hn::And(hn::And(hn::Gt(u, hn::Set(i32, -1)), hn::Lt(u, width)),
                        hn::And(hn::Gt(v, hn::Set(i32, -1)), hn::Lt(v, height)));
    seen = hn::And(seen, hn::MaskFromVec(hn::BitCast(i32, hn::VecFromMask(f32, hn::Gt(Z, zero)))));
    if (hn::AllFalse(i32, seen)) continue;
    const auto pixel = hn::IfThenElseZero(seen, hn::Add(hn::Mul(v, stride), u));
    const Floats d = hn::GatherIndex(f32, frame.depth.data, pixel);
    const Floats square = hn::Mul(d, d);
    const Floats three_sigma =
        hn::MulAdd(square, set(3.0F * frame.quadratic_per_m), set(3.0F * frame.constant_m));
    const Floats mu = hn::Min(hn::Max(set(frame.truncation_m), three_sigma),
                              set(kLargestDistance * frame.voxel_m));
    Floats sdf = hn::Sub(d, Z);
    if (frame.along_ray) {
      sdf = hn::Mul(sdf, hn::Sqrt(hn::MulAdd(xn, xn, hn::MulAdd(yn, yn, one))));
    }
    const auto counts = hn::And(hn::RebindMask(f32, seen), hn::Ge(sdf, hn::Neg(mu)));
    if (hn::AllFalse(f32, counts)) continue;
    const Floats share = hn::Div(set(frame.reference_m * frame.reference_m), square);
    const Floats w = hn::Max(one, hn::Round(hn::Mul(set(frame.full_weight), hn::Min(one, share))));
    const auto old_distance = hn::Load(i16, distance + voxel);
    const auto old_weight = hn::Load(u8, weight + voxel);
    const Floats F = hn::ConvertTo(f32, hn::PromoteTo(i32, old_distance));
    const Floats W = hn::ConvertTo(f32, hn::PromoteTo(i32, old_weight));
    const Floats seen_distance = hn::Mul(hn::Mul(hn::Min(sdf, mu), scale), w);
    const Floats sum = hn::Add(W, w);
    const Floats mean = hn::Div(hn::MulAdd(F, W, seen_distance), sum);
    const auto new_distance = hn::NearestInt(hn::IfThenElse(counts, mean, F));
    const auto new_weight =
        hn::ConvertTo(i32, hn::IfThenElse(counts, hn::Min(sum, set(frame.most_weight)), W));
    hn::Store(hn::DemoteTo(i16, new_distance), i16, distance + voxel);
    hn::Store(hn::DemoteTo(u8, new_weight), u8, weight + voxel);
    if (colour == nullptr) continue;
    const auto near =
        hn::And(counts, hn::Le(hn::Abs(sdf), hn::Max(set(1.5F * frame.voxel_m), three_sigma)));
    if (hn::AllFalse(f32, near)) continue;
    HWY_ALIGN std::int32_t us[kLanes], vs[kLanes], is_near[kLanes], weights[kLanes];
    hn::Store(u, i32, us);
    hn::Store(v, i32, vs);
    hn::Store(hn::BitCast(i32, hn::VecFromMask(f32, near)), i32, is_near);
    hn::Store(hn::ConvertTo(i32, W), i32, weights);
    for (int i = 0; i < kLanes; ++i) {
      if (is_near[i] != 0) colour_voxel(frame, us[i], vs[i], weights[i], colour[voxel + i]);
    }
  }
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(integrate_block_here);

void integrate_block(const IntegrateFrame& frame, int x, int y, int z, std::int16_t* distance,
                     std::uint8_t* weight, Rgb* colour) {
  HWY_DYNAMIC_DISPATCH(integrate_block_here)(frame, x, y, z, distance, weight, colour);
}
}  // namespace tread
#endif
