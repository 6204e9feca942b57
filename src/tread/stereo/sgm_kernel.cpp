#include "tread/stereo/sgm_kernel.hpp"

#include <algorithm>
#include <cstddef>

#include "tread/stereo/sad_kernel.hpp"
#include "tread/stereo/sgm_plain.hpp"

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/stereo/sgm_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "tread/stereo/lanes-inl.hpp"
#include "tread/stereo/winners-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128  // SgmMatcher uses the plain form there
int padded_range(int) {
  return 0;
}
std::size_t above_bytes(int, int) {
  return 0;
}
std::size_t worker_bytes(int, int) {
  return 0;
}
void census_row(ImageView<const std::uint8_t>, int, std::uint8_t*, Image<std::uint8_t>&) {}
void begin_above(int, const SgmOptions&, std::uint8_t*) {}
void cost_rows(const SgmImages&, const SgmOptions&, const SgmBlock&, int, int, std::uint8_t*) {}
void side_rows(const SgmOptions&, int, const SgmBlock&, int, int) {}
void above_columns(const SgmOptions&, const SgmBlock&, int, int, std::uint8_t*) {}
void finish_rows(const SgmOptions&, int, const SgmBlock&, int, int, std::uint8_t*,
                 const MatchOutput&) {}
#else

constexpr int kPixels = 16;      // looked at before their results are
constexpr int kEdgeColumns = 2;  // beside a pixel that count for its edge cost
constexpr std::uint32_t kFourTimes = 0x01010101U;

int padded_range(int num_disparities) {
  return (num_disparities + kLanes - 1) / kLanes * kLanes;
}

// A pixel's path from above lies between vectors of 255, so that neighbours can be loaded.
std::ptrdiff_t above_stride(int padded) {
  return padded + kLanes;
}

std::size_t above_bytes(int width, int num_disparities) {
  return static_cast<std::size_t>(above_stride(padded_range(num_disparities)) * width + kLanes);
}

// Of a row's differences.
std::size_t difference_bytes(int width, int num_disparities) {
  return static_cast<std::size_t>(width + 2 * kEdgeColumns) *
         static_cast<std::size_t>(padded_range(num_disparities));
}

std::size_t worker_bytes(int width, int num_disparities) {
  const auto row = static_cast<std::size_t>(width + 2 * kEdgeColumns + 64);
  const auto padded = static_cast<std::size_t>(padded_range(num_disparities));
  const std::size_t costs = 6 * (4 * row + row + padded + 64) + 8 * padded +
                            3 * (difference_bytes(width, num_disparities) + 64);
  const std::size_t winners = kPixels * (padded + 2 * 64);
  return std::max({costs, winners, 4 * row, 5 * row}) + 1024;
}

// Hands out parts of a worker's memory.
struct Arena {
  std::uint8_t* at;
  template <class T>
  T* take(std::size_t count) {
    T* here = reinterpret_cast<T*>(at);
    at += (count * sizeof(T) + 63) / 64 * 64;
    return here;
  }
};

void census_row(ImageView<const std::uint8_t> image, int y, std::uint8_t* memory,
                Image<std::uint8_t>& census) {
  const int width = image.width;
  Arena arena{memory};
  std::uint8_t* rows[5];
  for (int j = 0; j < 5; ++j) {
    const std::uint8_t* from = image.row(std::clamp(y + j - 2, 0, image.height - 1));
    std::uint8_t* row = arena.take<std::uint8_t>(static_cast<std::size_t>(width) + 4 + kLanes);
    std::fill(row, row + 2, from[0]);
    std::fill(std::copy(from, from + width, row + 2), row + width + 4 + kLanes, from[width - 1]);
    rows[j] = row + 2;
  }
  for (int x = 0; x < width; x += kLanes) {
    const Bytes centre = LoadU(U8(), rows[2] + x);
    int bit = 0;
    Bytes byte = Zero(U8());
    for (int j = 0; j < 5; ++j) {
      for (int i = -2; i <= 2; ++i) {
        if (i == 0 && j == 2) continue;
        const Bytes neighbour = LoadU(U8(), rows[j] + x + i);
        const Bytes not_darker = VecFromMask(U8(), Eq(Max(neighbour, centre), neighbour));
        // Twice the byte, and one more where the neighbour is darker: minus minus one.
        byte = Sub(Add(byte, byte), Not(not_darker));
        if (++bit % 8 != 0) continue;
        std::uint8_t* out = census.row(3 * y + bit / 8 - 1) + x;
        if (x + kLanes <= width) {
          StoreU(byte, U8(), out);
        } else {
          HWY_ALIGN std::uint8_t last[hn::MaxLanes(U8())];
          Store(byte, U8(), last);
          std::copy(last, last + (width - x), out);
        }
        byte = Zero(U8());
      }
    }
  }
}

void begin_above(int width, const SgmOptions& options, std::uint8_t* above) {
  const int padded = padded_range(options.num_disparities);
  std::fill(above, above + above_bytes(width, options.num_disparities), std::uint8_t{255});
  for (int x = 0; x < width; ++x) {
    std::uint8_t* path = above + kLanes + x * above_stride(padded);
    std::fill(path, path + padded, std::uint8_t{0});
  }
}

// Each pixel of a row four times, with the nearest ones beyond the ends.
std::uint32_t* spread_row(Arena& arena, const std::uint8_t* from, int width, int beside) {
  auto* out = arena.take<std::uint32_t>(static_cast<std::size_t>(width + 2 * beside) + 16);
  for (int x = 0; x < beside; ++x) {
    out[x] = from[0] * kFourTimes;
    out[beside + width + x] = from[width - 1] * kFourTimes;
  }
  const hn::Rebind<std::uint8_t, U32> pixels;
  const int lanes = static_cast<int>(Lanes(U32()));
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    const auto four = Mul(PromoteTo(U32(), LoadU(pixels, from + x)), Set(U32(), kFourTimes));
    StoreU(four, U32(), out + beside + x);
  }
  for (; x < width; ++x) out[beside + x] = from[x] * kFourTimes;
  return out;
}

// A row of the right image reversed: entry k is column width - 1 + beside - min_disparity - k, so
// that the disparities of column x begin at entry width - 1 + beside - x.
std::uint8_t* reverse_row(Arena& arena, const std::uint8_t* from, int width, int beside,
                          int min_disparity, int padded) {
  const int length = width + 2 * beside + padded;
  auto* out = arena.take<std::uint8_t>(static_cast<std::size_t>(length) + kLanes);
  const int shift = beside - min_disparity;
  const int begin = std::clamp(shift, 0, length), end = std::clamp(shift + width, begin, length);
  const int skipped = begin - shift;
  std::fill(out, out + begin, from[width - 1]);
  std::reverse_copy(from + width - skipped - (end - begin), from + width - skipped, out + begin);
  std::fill(out + end, out + length + kLanes, from[0]);
  return out;
}

// 255 in the lanes of vector i that are not among the first `range`.
HWY_INLINE Bytes outside(int i, int range) {
  const int inside = std::clamp(range - i * kLanes, 0, kLanes);
  return hn::IfThenElseZero(hn::Not(hn::FirstN(U8(), static_cast<std::size_t>(inside))),
                            Set(U8(), 255));
}

// The differences of the edges of one row, which three rows of costs share.
void difference_row(const SgmImages& images, const SgmOptions& options, int y, std::uint8_t* memory,
                    std::uint8_t* out) {
  const int width = images.left_edges.width;
  const int padded = padded_range(options.num_disparities);
  const int row = std::clamp(y, 0, images.left_edges.height - 1);
  Arena arena{memory};
  const std::uint32_t* left = spread_row(arena, images.left_edges.row(row), width, kEdgeColumns);
  const int columns = width + 2 * kEdgeColumns;
  const std::uint8_t* right = reverse_row(arena, images.right_edges.row(row), width, kEdgeColumns,
                                          options.min_disparity_px, padded) +
                              columns - 1;
  for (int c = 0; c < columns; ++c) {
    const Bytes here = BitCast(U8(), Set(U32(), left[c]));
    for (int d = 0; d < padded; d += kLanes) {
      const Bytes other = LoadU(U8(), right - c + d);
      Store(Sub(Max(here, other), Min(here, other)), U8(), out);
      out += kLanes;
    }
  }
}

// One row of costs. differences: of the row above, this one and the one below.
void cost_row(const SgmImages& images, const SgmOptions& options, int y,
              const std::uint8_t* const* differences, std::uint8_t* memory, std::uint8_t* out) {
  const int width = images.left_edges.width;
  const int range = options.num_disparities, padded = padded_range(range);
  Arena arena{memory};
  const std::uint32_t* census[3];
  const std::uint8_t* other_census[3];
  for (int k = 0; k < 3; ++k) {
    census[k] = spread_row(arena, images.left_census.row(3 * y + k), width, 0);
    other_census[k] = reverse_row(arena, images.right_census.row(3 * y + k), width, 0,
                                  options.min_disparity_px, padded) +
                      width - 1;
  }
  // The sums of three rows of the last five columns.
  constexpr int kWindow = 2 * kEdgeColumns + 1;
  auto* ring = arena.take<std::uint8_t>(static_cast<std::size_t>(kWindow * padded));
  int slot = 0;
  const Bytes most = Set(U8(), kSgmLargestEdgeCost);
  const Bytes beyond = outside(padded / kLanes - 1, range);
  for (int c = 0; c < width + 2 * kEdgeColumns; ++c) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(c) * padded;
    std::uint8_t* column = ring + slot * padded;
    slot = slot + 1 == kWindow ? 0 : slot + 1;
    for (int d = 0; d < padded; d += kLanes) {
      const Bytes two =
          SaturatedAdd(Load(U8(), differences[0] + at + d), Load(U8(), differences[1] + at + d));
      Store(SaturatedAdd(two, Load(U8(), differences[2] + at + d)), U8(), column + d);
    }
    const int x = c - 2 * kEdgeColumns;
    if (x < 0) continue;
    std::uint8_t* cost = out + static_cast<std::ptrdiff_t>(x) * padded;
    for (int d = 0; d < padded; d += kLanes) {
      const std::uint8_t* s = ring + d;
      const Bytes sum = SaturatedAdd(
          SaturatedAdd(SaturatedAdd(Load(U8(), s), Load(U8(), s + padded)),
                       SaturatedAdd(Load(U8(), s + 2 * padded), Load(U8(), s + 3 * padded))),
          Load(U8(), s + 4 * padded));
      // Three bits of equal weight: their sum and their carry.
      Bytes bits[3];
      for (int k = 0; k < 3; ++k) {
        bits[k] =
            Xor(BitCast(U8(), Set(U32(), census[k][x])), LoadU(U8(), other_census[k] - x + d));
      }
      const Bytes differ = Xor(bits[0], bits[1]);
      const Bytes odd = PopulationCount(Xor(differ, bits[2]));
      const Bytes twice = PopulationCount(Or(And(bits[0], bits[1]), And(differ, bits[2])));
      const Bytes total = Add(Add(odd, Add(twice, twice)), Min(hn::ShiftRight<3>(sum), most));
      Store(d + kLanes > range ? Or(total, beyond) : total, U8(), cost + d);
    }
  }
}

void cost_rows(const SgmImages& images, const SgmOptions& options, const SgmBlock& block, int begin,
               int end, std::uint8_t* memory) {
  const std::size_t bytes = difference_bytes(images.left_edges.width, options.num_disparities);
  Arena arena{memory};
  std::uint8_t* ring[3];
  for (std::uint8_t*& row : ring) row = arena.take<std::uint8_t>(bytes);
  const auto row = [&](int y) { return ring[(y + 3) % 3]; };
  difference_row(images, options, begin - 1, arena.at, row(begin - 1));
  difference_row(images, options, begin, arena.at, row(begin));
  for (int y = begin; y < end; ++y) {
    difference_row(images, options, y + 1, arena.at, row(y + 1));
    const std::uint8_t* const differences[] = {row(y - 1), row(y), row(y + 1)};
    cost_row(images, options, y, differences, arena.at,
             block.cost + (y - block.first) * block.row_stride);
  }
}

// A pixel's path from `path`, that of the pixel before with its least taken off, to its own costs
// on it; `path` becomes that with its least taken off.
template <int kVectors>
HWY_INLINE void step(Bytes* path, int vectors, const std::uint8_t* cost, Bytes p1, Bytes p2,
                     std::uint8_t* out) {
  const Bytes top = Set(U8(), 255);
  Bytes now[kVectors > 0 ? kVectors : kMaxVectors];
  for (int i = 0; i < vectors; ++i) {
    const Bytes lower = from_lower(path[i], i > 0 ? path[i - 1] : top);
    const Bytes upper = from_upper(path[i], i + 1 < vectors ? path[i + 1] : top);
    const Bytes stay = Min(path[i], p2);
    now[i] =
        SaturatedAdd(Load(U8(), cost + i * kLanes), Min(stay, SaturatedAdd(Min(lower, upper), p1)));
    Store(now[i], U8(), out + i * kLanes);
  }
  Bytes least = top;
  for (int i = 0; i < vectors; ++i) least = Min(least, now[i]);
  least = spread_byte(least_byte_of(U8(), least));
  for (int i = 0; i < vectors; ++i) path[i] = Sub(now[i], least);
}

// Both paths of kRows rows, turn by turn: each is one long chain of dependent instructions.
template <int kVectors, int kRows>
HWY_NOINLINE void side_paths(const SgmOptions& options, int width, const SgmBlock& block, int row) {
  const int vectors = kVectors > 0 ? kVectors : padded_range(options.num_disparities) / kLanes;
  const std::ptrdiff_t padded = static_cast<std::ptrdiff_t>(vectors) * kLanes;
  constexpr int kStore = kVectors > 0 ? kVectors : kMaxVectors;
  Bytes right[kRows][kStore], left[kRows][kStore];
  for (int r = 0; r < kRows; ++r) {
    for (int i = 0; i < vectors; ++i) right[r][i] = left[r][i] = Zero(U8());
  }
  const Bytes p1 = Set(U8(), static_cast<std::uint8_t>(options.p1));
  const Bytes p2 = Set(U8(), static_cast<std::uint8_t>(options.p2));
  const std::ptrdiff_t first = (row - block.first) * block.row_stride;
  for (int x = 0; x < width; ++x) {
    const std::ptrdiff_t ahead = first + x * padded, back = first + (width - 1 - x) * padded;
    for (int r = 0; r < kRows; ++r) {
      const std::ptrdiff_t at = r * block.row_stride;
      step<kVectors>(right[r], vectors, block.cost + at + ahead, p1, p2,
                     block.from_left + at + ahead);
      step<kVectors>(left[r], vectors, block.cost + at + back, p1, p2,
                     block.from_right + at + back);
    }
  }
}

template <int kVectors>
void side_rows_of(const SgmOptions& options, int width, const SgmBlock& block, int begin, int end) {
  int y = begin;
  for (; y + 2 <= end; y += 2) side_paths<kVectors, 2>(options, width, block, y);
  if (y < end) side_paths<kVectors, 1>(options, width, block, y);
}

void side_rows(const SgmOptions& options, int width, const SgmBlock& block, int begin, int end) {
  switch (padded_range(options.num_disparities) / kLanes) {
    case 1:
      return side_rows_of<1>(options, width, block, begin, end);
    case 2:
      return side_rows_of<2>(options, width, block, begin, end);
    case 4:
      return side_rows_of<4>(options, width, block, begin, end);
    default:
      return side_rows_of<0>(options, width, block, begin, end);
  }
}

// What one look at the sums of a pixel finds.
struct SumScan {
  std::uint64_t equal;  // kBits: lanes that cost the least; else the first of them
  std::uint64_t close;  // kBits: lanes nearly as cheap; else how many there are
  std::uint32_t least;
};

// The path from above to a pixel, and the sum of all three, left in `sums`.
template <int kVectors, bool kBits>
HWY_INLINE SumScan sum_paths(std::uint8_t* above, int vectors, const std::uint8_t* cost,
                             const std::uint8_t* from_left, const std::uint8_t* from_right, int fit,
                             std::uint32_t margin_factor, Bytes p1, Bytes p2, std::uint8_t* sums) {
  constexpr int kStore = kVectors > 0 ? kVectors : kMaxVectors;
  Bytes now[kStore], sum[kStore];
  for (int i = 0; i < vectors; ++i) {
    const std::uint8_t* path = above + i * kLanes;
    const Bytes beside = Min(LoadU(U8(), path - 1), LoadU(U8(), path + 1));
    const Bytes stay = Min(Load(U8(), path), p2);
    now[i] = SaturatedAdd(Load(U8(), cost + i * kLanes), Min(stay, SaturatedAdd(beside, p1)));
    sum[i] = SaturatedAdd(now[i], SaturatedAdd(Load(U8(), from_left + i * kLanes),
                                               Load(U8(), from_right + i * kLanes)));
    if (fit < (i + 1) * kLanes) sum[i] = Or(sum[i], outside(i, fit));
    Store(sum[i], U8(), sums + i * kLanes);
  }
  Bytes least = Set(U8(), 255), cheapest = least;
  for (int i = 0; i < vectors; ++i) {
    least = Min(least, now[i]);
    cheapest = Min(cheapest, sum[i]);
  }
  least = spread_byte(least_byte_of(U8(), least));
  for (int i = 0; i < vectors; ++i) Store(Sub(now[i], least), U8(), above + i * kLanes);

  const auto lane = least_byte_of(U8(), cheapest);
  const Bytes all = spread_byte(lane);
  SumScan found{0, 0, static_cast<std::uint32_t>(GetLane(lane))};
  const auto margin = static_cast<std::uint8_t>(found.least * margin_factor >> 16);
  const Bytes limit = Set(U8(), margin);
  for (int i = vectors - 1; i >= 0; --i) {
    const Bytes excess = Sub(sum[i], all);
    const std::uint64_t equal = bits_of(Eq(excess, Zero(U8())));
    const std::uint64_t close = bits_at_most(excess, limit);
    if constexpr (kBits) {
      found.equal |= equal << (i * kLanes);
      found.close |= close << (i * kLanes);
    } else {
      if (equal != 0) found.equal = static_cast<std::uint64_t>(i * kLanes) + lowest_bit(equal);
      found.close += hwy::PopCount(close);
    }
  }
  return found;
}

template <bool kBits>
HWY_INLINE PixelResult settle(const SumScan& found, const std::uint8_t* sums,
                              std::uint32_t margin_factor) {
  const std::uint32_t index =
      kBits ? lowest_bit(found.equal) : static_cast<std::uint32_t>(found.equal);
  const std::uint32_t before = sums[static_cast<std::ptrdiff_t>(index) - 1];
  const std::uint32_t behind = sums[index + 1];
  bool ambiguous = false;
  if constexpr (kBits) {
    const std::uint64_t best = found.equal & (~found.equal + 1);
    ambiguous = (found.close & ~(best | best << 1 | best >> 1)) != 0;
  } else {
    const std::uint32_t limit = found.least + (found.least * margin_factor >> 16);
    const std::uint64_t own = 1U + (before <= limit ? 1U : 0U) + (behind <= limit ? 1U : 0U);
    ambiguous = found.close != own;
  }
  return {found.least << 16 | index, before | behind << 16 | (ambiguous ? kAmbiguous : 0U)};
}

template <int kVectors>
HWY_NOINLINE void above_columns_of(const SgmOptions& options, const SgmBlock& block, int begin,
                                   int end, std::uint8_t* memory) {
  const int range = options.num_disparities;
  const int vectors = kVectors > 0 ? kVectors : padded_range(range) / kLanes;
  constexpr bool kBits = kVectors > 0 && kVectors * kLanes <= 64;
  const std::ptrdiff_t padded = static_cast<std::ptrdiff_t>(vectors) * kLanes;
  const std::ptrdiff_t stride = padded + 2 * kLanes;
  std::fill(memory, memory + kPixels * stride, std::uint8_t{kSgmNoCost});
  const std::uint32_t factor = uniqueness_factor(options.uniqueness_percent);
  const Bytes p1 = Set(U8(), static_cast<std::uint8_t>(options.p1));
  const Bytes p2 = Set(U8(), static_cast<std::uint8_t>(options.p2));
  for (int y = block.first; y < block.last; ++y) {
    const std::ptrdiff_t row = (y - block.first) * block.row_stride;
    auto* pixels =
        reinterpret_cast<PixelResult*>(block.pixels + (y - block.first) * block.pixel_stride);
    SumScan scans[kPixels];
    for (int first = begin; first < end; first += kPixels) {
      const int count = std::min(kPixels, end - first);
      std::uint8_t* sums = memory + kLanes;
      for (int i = 0; i < count; ++i, sums += stride) {
        const int x = first + i;
        const std::ptrdiff_t at = row + x * padded;
        // At least one, so that the sums of the first columns have a least, which nobody asks for.
        const int fit = std::clamp(x - options.min_disparity_px + 1, 1, range);
        scans[i] = sum_paths<kVectors, kBits>(block.above + kLanes + x * (padded + kLanes), vectors,
                                              block.cost + at, block.from_left + at,
                                              block.from_right + at, fit, factor, p1, p2, sums);
      }
      sums = memory + kLanes;
      for (int i = 0; i < count; ++i, sums += stride) {
        pixels[first + i] = settle<kBits>(scans[i], sums, factor);
      }
    }
  }
}

void above_columns(const SgmOptions& options, const SgmBlock& block, int begin, int end,
                   std::uint8_t* memory) {
  switch (padded_range(options.num_disparities) / kLanes) {
    case 1:
      return above_columns_of<1>(options, block, begin, end, memory);
    case 2:
      return above_columns_of<2>(options, block, begin, end, memory);
    case 4:
      return above_columns_of<4>(options, block, begin, end, memory);
    default:
      return above_columns_of<0>(options, block, begin, end, memory);
  }
}

void finish_rows(const SgmOptions& options, int width, const SgmBlock& block, int begin, int end,
                 std::uint8_t* memory, const MatchOutput& output) {
  auto* owners = reinterpret_cast<std::uint32_t*>(memory);
  RefineJob job;
  job.begin = std::min(options.min_disparity_px, width);
  job.width = width;
  job.no_cost = kSgmNoCost;
  job.min_disparity_px = options.min_disparity_px;
  job.sub_pixel = options.sub_pixel;
  job.strict_sub_pixel = options.strict_sub_pixel;
  job.check_unique = options.uniqueness_percent > 0;
  job.left_right_tolerance_px = options.left_right_tolerance_px;
  for (int y = begin; y < end; ++y) {
    const auto* pixels =
        reinterpret_cast<const PixelResult*>(block.pixels + (y - block.first) * block.pixel_stride);
    std::fill(owners, owners + width, ~std::uint32_t{0});
    for (int x = job.begin; x < width; ++x) {
      claim(owners + x - job.min_disparity_px, pixels[x].winner);
    }
    Disparity* out = output.disparity.row(y);
    std::fill(out, out + job.begin, kNoMatch);
    std::uint8_t* residual = output.residual.empty() ? nullptr : output.residual.row(y);
    if (residual != nullptr) std::fill(residual, residual + job.begin, kNoResidual);
    refine(pixels, owners, job, out, residual);
  }
}
#endif

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(padded_range);
HWY_EXPORT(above_bytes);
HWY_EXPORT(worker_bytes);
HWY_EXPORT(census_row);
HWY_EXPORT(begin_above);
HWY_EXPORT(cost_rows);
HWY_EXPORT(side_rows);
HWY_EXPORT(above_columns);
HWY_EXPORT(finish_rows);

int sgm_padded_range(int num_disparities) {
  return HWY_DYNAMIC_DISPATCH(padded_range)(num_disparities);
}
std::size_t sgm_above_bytes(int width, int num_disparities) {
  return HWY_DYNAMIC_DISPATCH(above_bytes)(width, num_disparities);
}
std::size_t sgm_worker_bytes(int width, int num_disparities) {
  return HWY_DYNAMIC_DISPATCH(worker_bytes)(width, num_disparities);
}
void sgm_census_row(ImageView<const std::uint8_t> image, int y, std::uint8_t* memory,
                    Image<std::uint8_t>& census) {
  HWY_DYNAMIC_DISPATCH(census_row)(image, y, memory, census);
}
void sgm_begin(int width, const SgmOptions& options, std::uint8_t* above) {
  HWY_DYNAMIC_DISPATCH(begin_above)(width, options, above);
}
void sgm_cost_rows(const SgmImages& images, const SgmOptions& options, const SgmBlock& block,
                   int begin, int end, std::uint8_t* memory) {
  HWY_DYNAMIC_DISPATCH(cost_rows)(images, options, block, begin, end, memory);
}
void sgm_side_rows(const SgmOptions& options, int width, const SgmBlock& block, int begin,
                   int end) {
  HWY_DYNAMIC_DISPATCH(side_rows)(options, width, block, begin, end);
}
void sgm_above_columns(const SgmOptions& options, const SgmBlock& block, int begin, int end,
                       std::uint8_t* memory) {
  HWY_DYNAMIC_DISPATCH(above_columns)(options, block, begin, end, memory);
}
void sgm_finish_rows(const SgmOptions& options, int width, const SgmBlock& block, int begin,
                     int end, std::uint8_t* memory, const MatchOutput& output) {
  HWY_DYNAMIC_DISPATCH(finish_rows)(options, width, block, begin, end, memory, output);
}
}  // namespace tread
#endif
