// The second half of matching, which the SAD and the semi-global kernel share: what is left of a
// row's pixels after their costs have been looked at, and how disparities come of it. Included once
// for each instruction set.
#if defined(TREAD_STEREO_WINNERS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef TREAD_STEREO_WINNERS_INL_HPP
#undef TREAD_STEREO_WINNERS_INL_HPP
#else
#define TREAD_STEREO_WINNERS_INL_HPP
#endif

#include <algorithm>

#include "tread/stereo/lanes-inl.hpp"
#include "tread/stereo/sad_matcher.hpp"

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {
#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128

// What the columns of one row leave for its second pass.
struct PixelResult {
  std::uint32_t winner;      // its cost << 16 | its index: disparity - min_disparity
  std::uint32_t neighbours;  // cost of one disparity less | of one more << 16, kNoCost where the
                             // range ends; kAmbiguous besides if others are nearly as cheap
};
constexpr std::uint32_t kAmbiguous = 0x80000000U;
constexpr std::uint32_t kIndexMask = 0xFFFFU;

// A pixel of the other image belongs to the cheapest of those that chose it, of equal ones to the
// one with the smaller disparity. `zero` is the one at no disparity.
HWY_INLINE void claim(std::uint32_t* zero, std::uint32_t winner) {
  std::uint32_t& owner = *(zero - (winner & kIndexMask));
  // The lesser of both. A compiler that sees a minimum moves both through vector registers.
  const std::int64_t less = std::int64_t{winner} - std::int64_t{owner};
  owner += static_cast<std::uint32_t>(less & (less >> 63));
}

// A row's pixels from `begin` on become disparities by these rules; with `residual`, also how well
// each fits (disparity.hpp).
struct RefineJob {
  int begin = 0;
  int width = 0;
  int no_cost = 0;  // stands for a neighbour that the range does not have
  int min_disparity_px = 0;
  SubPixel sub_pixel = SubPixel::kSymmetricV;
  int sub_pixel_steps = kDisparityScale;
  bool strict_sub_pixel = true;
  bool check_unique = true;
  int left_right_tolerance_px = 0;
};

// The disparities below the pixel: n / m of a step, rounded to the nearest, half to even. Both
// are small enough integers that a float's quotient never rounds to another step than the true
// one.
inline void refine(const PixelResult* pixels, const std::uint32_t* owners, const RefineJob& job,
                   Disparity* out, std::uint8_t* residual) {
  const F32 f32;
  const I32 i32;
  const hn::Rebind<std::uint16_t, I32> u16;
  const hn::Rebind<std::uint8_t, I32> u8;
  const int lanes = static_cast<int>(Lanes(i32));
  const auto no_cost = Set(i32, job.no_cost);
  const auto low = Set(i32, 0xFFFF);
  const auto one = Set(i32, 1);
  const auto steps = Set(f32, static_cast<float>(job.sub_pixel_steps));
  const auto scale = Set(f32, static_cast<float>(kDisparityScale));
  const auto min_disparity = Set(i32, job.min_disparity_px);
  const auto tolerance = Set(i32, job.left_right_tolerance_px);
  const auto last_column = Set(i32, job.width - 1);
  const bool strict = job.strict_sub_pixel;
  const bool check_unique = job.check_unique;
  const bool check_back = job.left_right_tolerance_px >= 0;
  const SubPixel sub_pixel = job.sub_pixel;
  HWY_ALIGN Disparity last[hn::MaxLanes(I32())];
  HWY_ALIGN std::uint8_t last_residual[hn::MaxLanes(I32())];
  auto zero = Sub(Iota(i32, job.begin), min_disparity);  // the column at no disparity
  for (int x = job.begin; x < job.width; x += lanes) {
    hn::Vec<U32> winner, neighbours;
    LoadInterleaved2(U32(), &pixels[x].winner, winner, neighbours);
    const auto c = BitCast(i32, hn::ShiftRight<16>(winner));
    const auto index = And(BitCast(i32, winner), low);
    const auto l = And(BitCast(i32, neighbours), low);
    const auto r = And(BitCast(i32, hn::ShiftRight<16>(neighbours)), no_cost);
    const auto inside = And(Ne(l, no_cost), Ne(r, no_cost));
    auto divisor = Zero(i32);
    if (sub_pixel == SubPixel::kSymmetricV) divisor = Sub(Max(l, r), c);
    if (sub_pixel == SubPixel::kParabola) divisor = Sub(Add(l, r), Add(c, c));
    const auto refined = And(inside, Gt(divisor, Zero(i32)));
    const auto m = ConvertTo(f32, IfThenElse(refined, Add(divisor, divisor), one));
    const auto n = ConvertTo(f32, IfThenElseZero(refined, Sub(l, r)));
    const auto whole_steps = Round(Div(Mul(n, steps), m));
    const auto fraction = ConvertTo(i32, Div(Mul(whole_steps, scale), steps));
    const auto whole = hn::ShiftLeft<6>(Add(index, min_disparity));
    static_assert(kDisparityScale == 1 << 6);
    auto found = Add(whole, fraction);
    const auto reject = [&](auto mask)
                            HWY_ATTR { found = IfThenElse(mask, Set(i32, int{kNoMatch}), found); };
    if (check_unique) reject(Lt(BitCast(i32, neighbours), Zero(i32)));  // kAmbiguous
    if (strict) reject(Not(And(inside, And(Gt(l, c), Gt(r, c)))));
    if (check_back) {
      // Behind the end of the row lies nothing of use, but an index all the same.
      const auto safe = Min(Max(Sub(zero, index), Zero(i32)), last_column);
      const auto owner = hn::GatherIndex(i32, reinterpret_cast<const int*>(owners), safe);
      reject(Gt(Abs(Sub(And(owner, low), index)), tolerance));
    }
    zero = Add(zero, Set(i32, lanes));
    const auto narrow = DemoteTo(u16, found);
    const bool whole_vector = x + lanes <= job.width;
    if (whole_vector) {
      StoreU(narrow, u16, out + x);
    } else {
      Store(narrow, u16, last);
      std::copy(last, last + (job.width - x), out + x);
    }
    if (residual == nullptr) continue;
    const auto slope = Sub(Max(l, r), c);
    const auto known = And(inside, Gt(slope, Zero(i32)));
    const auto ratio = Div(ConvertTo(f32, Mul(c, Set(i32, kResidualScale))),
                           ConvertTo(f32, IfThenElse(known, slope, one)));
    const auto most = Set(i32, int{kLargestResidual});
    const auto rated = IfThenElse(known, Min(ConvertTo(i32, ratio), most), most);
    const auto byte =
        IfThenElse(Eq(found, Set(i32, int{kNoMatch})), Set(i32, int{kNoResidual}), rated);
    if (whole_vector) {
      StoreU(DemoteTo(u8, byte), u8, residual + x);
    } else {
      Store(DemoteTo(u8, byte), u8, last_residual);
      std::copy(last_residual, last_residual + (job.width - x), residual + x);
    }
  }
}

#endif
}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
