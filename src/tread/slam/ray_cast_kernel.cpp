#include "tread/slam/ray_cast_kernel.hpp"

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/slam/ray_cast_kernel.cpp"
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
using Lanes = hn::Mask<F32>;

HWY_INLINE Floats set(float v) {
  return hn::Set(F32(), v);
}
HWY_INLINE Ints set_int(int v) {
  return hn::Set(I32(), v);
}

// Masks as vectors, to be kept from step to step.
HWY_INLINE Lanes both(Lanes a, Lanes b) {
  return hn::And(a, b);
}
HWY_INLINE Lanes but(Lanes a, Lanes b) {
  return hn::AndNot(b, a);
}

// What a place in the volume needs for all lanes.
class Sampler {
 public:
  explicit Sampler(const VolumeView& volume, const RayRow& rays)
      : volume_(volume),
        rays_(rays),
        mask_(set_int((1 << volume.log2_side) - 1)),
        last_(set(static_cast<float>(kBlockSide << volume.log2_side) - 1.0F)) {}

  // Distances at depth z of the rays, NaN as sample_distance.
  HWY_INLINE Floats at(const Floats* direction, Floats z, Lanes wanted) const {
    Floats p[3];
    Lanes good = wanted;
    for (int k = 0; k < 3; ++k) {
      p[k] = hn::MulAdd(z, direction[k], set(rays_.origin[k]));
      good = both(good, both(hn::Ge(p[k], hn::Zero(F32())), hn::Lt(p[k], last_)));
    }
    Ints voxel[3];
    Floats share[3];
    for (int k = 0; k < 3; ++k) {
      const Floats safe = hn::IfThenElseZero(good, p[k]);
      voxel[k] = hn::ConvertTo(I32(), safe);
      share[k] = hn::Sub(safe, hn::ConvertTo(F32(), voxel[k]));
    }
    Floats corner[8];
    for (int i = 0; i < 8; ++i) corner[i] = read(voxel, i & 1, i >> 1 & 1, i >> 2, good);
    const auto mix = [](Floats a, Floats b, Floats f)
                         HWY_ATTR { return hn::MulAdd(hn::Sub(b, a), f, a); };
    const Floats near =
        mix(mix(corner[0], corner[1], share[0]), mix(corner[2], corner[3], share[0]), share[1]);
    const Floats far =
        mix(mix(corner[4], corner[5], share[0]), mix(corner[6], corner[7], share[0]), share[1]);
    return hn::IfThenElse(good, hn::Mul(mix(near, far, share[2]), set(1.0F / kDistanceUnits)),
                          set(std::numeric_limits<float>::quiet_NaN()));
  }

 private:
  HWY_INLINE Floats read(const Ints* voxel, int dx, int dy, int dz, Lanes& good) const {
    const Ints x = hn::Add(voxel[0], set_int(dx)), y = hn::Add(voxel[1], set_int(dy)),
               z = hn::Add(voxel[2], set_int(dz));
    const auto wrapped = [&](Ints v, int origin) HWY_ATTR {
      return hn::And(hn::Add(hn::ShiftRight<3>(v), set_int(origin)), mask_);
    };
    const Ints row = hn::Or(hn::ShiftLeftSame(wrapped(z, volume_.origin[2]), volume_.log2_side),
                            wrapped(y, volume_.origin[1]));
    const Ints slot =
        hn::Or(hn::ShiftLeftSame(row, volume_.log2_side), wrapped(x, volume_.origin[0]));
    const Ints block = hn::GatherIndex(I32(), volume_.slots, slot);
    good = but(good, hn::RebindMask(F32(), hn::Lt(block, hn::Zero(I32()))));
    const Ints seven = set_int(7);
    Ints at = hn::Or(hn::ShiftLeft<3>(hn::And(z, seven)), hn::And(y, seven));
    at = hn::Or(hn::ShiftLeft<3>(at), hn::And(x, seven));
    at = hn::Add(hn::ShiftLeft<9>(block), at);
    at = hn::IfThenElseZero(hn::RebindMask(I32(), good), at);
    const Ints weight =
        hn::And(hn::GatherOffset(I32(), reinterpret_cast<const std::int32_t*>(volume_.weight), at),
                set_int(0xFF));
    good = but(good, hn::RebindMask(F32(), hn::Eq(weight, hn::Zero(I32()))));
    const Ints distance = hn::GatherOffset(
        I32(), reinterpret_cast<const std::int32_t*>(volume_.distance), hn::Add(at, at));
    return hn::ConvertTo(F32(), hn::ShiftRight<16>(hn::ShiftLeft<16>(distance)));
  }

  const VolumeView& volume_;
  const RayRow& rays_;
  Ints mask_;
  Floats last_;
};

// cast_ray, all lanes in step; those that need its scan go there one by one.
void cast_row_here(const VolumeView& volume, const RayRow& rays, const float* seeds, int width,
                   float band, float* out) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr int kSteps = 7;
  const F32 f32;
  const int lanes = static_cast<int>(hn::Lanes(f32));
  const Sampler sampler(volume, rays);
  const Floats zero = hn::Zero(f32), near = set(0.01F);
  const Floats voxel_m = set(volume.voxel_m), most = set(4.0F * volume.voxel_m);
  HWY_ALIGN float ends[hn::MaxLanes(F32())], scan[hn::MaxLanes(F32())];
  for (int x = 0; x < width; x += lanes) {
    const bool whole = x + lanes <= width;
    if (!whole) {
      std::fill(std::copy(seeds + x, seeds + width, ends), ends + lanes, kNan);
    }
    const Floats seed = whole ? hn::LoadU(f32, seeds + x) : hn::Load(f32, ends);
    const Lanes seeded = hn::Gt(seed, zero);
    Floats result = set(kNan);
    if (!hn::AllFalse(f32, seeded)) {
      const Floats column = hn::ConvertTo(f32, hn::Iota(I32(), x));
      Floats direction[3];
      for (int k = 0; k < 3; ++k) {
        direction[k] = hn::MulAdd(column, set(rays.step[k]), set(rays.first[k]));
      }
      Floats z = seed, s = sampler.at(direction, z, seeded);
      const Lanes known = both(seeded, hn::Eq(s, s));
      Floats step = hn::Mul(hn::IfThenElse(hn::Lt(hn::Abs(s), set(0.1F)), set(0.5F), s), voxel_m);
      Floats between = zero, end_z = zero, end = zero;
      Lanes open = known, bracketed = hn::Lt(zero, zero);
      for (int i = 0; i < kSteps && !hn::AllFalse(f32, open); ++i) {
        const Floats next_z = hn::IfThenElse(bracketed, between, hn::Add(z, step));
        const Floats next = sampler.at(direction, next_z, open);
        const Lanes seen = hn::Eq(next, next);
        // Between two samples on both sides of the surface: once more, and done.
        const Lanes last = both(open, bracketed);
        const Lanes other_side = hn::Xor(hn::Gt(next, zero), hn::Gt(end, zero));
        const Floats to_z = hn::IfThenElse(other_side, end_z, z);
        const Floats to = hn::IfThenElse(other_side, end, s);
        const Floats refined =
            hn::Sub(next_z, hn::Div(hn::Mul(next, hn::Sub(to_z, next_z)), hn::Sub(to, next)));
        result = hn::IfThenElse(last, hn::IfThenElse(seen, refined, between), result);
        open = but(open, last);
        // The others take their step.
        const Lanes inside = both(seen, hn::Le(hn::Abs(hn::Sub(next_z, seed)), set(band)));
        open = both(open, inside);
        const Floats slope = hn::Div(hn::Sub(next, s), hn::Sub(next_z, z));
        const Lanes front = hn::Lt(slope, zero);
        const Floats crossing = hn::Sub(next_z, hn::Div(next, slope));
        const Lanes there = both(open, hn::Lt(hn::Abs(next), near));
        result = hn::IfThenElse(both(there, front), crossing, result);
        open = but(open, there);
        const Lanes crossed = both(open, hn::Lt(hn::Mul(next, s), zero));
        open = but(open, but(crossed, front));  // from behind
        const Lanes brackets = both(crossed, front);
        between = hn::IfThenElse(brackets, crossing, between);
        end_z = hn::IfThenElse(brackets, next_z, end_z);
        end = hn::IfThenElse(brackets, next, end);
        const Lanes moves = but(open, brackets);
        z = hn::IfThenElse(moves, next_z, z);
        s = hn::IfThenElse(moves, next, s);
        const Floats secant = hn::Max(hn::Min(hn::Neg(hn::Div(next, slope)), most), hn::Neg(most));
        step = hn::IfThenElse(front, secant, hn::Mul(next, voxel_m));
        bracketed = brackets;
      }
      const Lanes unknown = but(seeded, known);
      if (!hn::AllFalse(f32, unknown)) {
        hn::Store(result, f32, scan);
        HWY_ALIGN float wanted[hn::MaxLanes(F32())];
        hn::Store(hn::IfThenElseZero(unknown, seed), f32, wanted);
        for (int i = 0; i < lanes; ++i) {
          if (!(wanted[i] > 0.0F)) continue;
          const auto c = static_cast<float>(x + i);
          const Ray ray{{rays.origin[0], rays.origin[1], rays.origin[2]},
                        {rays.first[0] + c * rays.step[0], rays.first[1] + c * rays.step[1],
                         rays.first[2] + c * rays.step[2]}};
          scan[i] = cast_ray(volume, ray, wanted[i], band);
        }
        result = hn::Load(f32, scan);
      }
    }
    if (whole) {
      hn::StoreU(result, f32, out + x);
    } else {
      hn::Store(result, f32, ends);
      std::copy(ends, ends + (width - x), out + x);
    }
  }
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(cast_row_here);

void cast_row(const VolumeView& volume, const RayRow& rays, const float* seeds, int width,
              float band, float* out) {
  HWY_DYNAMIC_DISPATCH(cast_row_here)(volume, rays, seeds, width, band, out);
}
}  // namespace tread
#endif
