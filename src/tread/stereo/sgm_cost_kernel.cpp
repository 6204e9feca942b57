// The first half of the semi-global kernel: the census, and the costs of rows.
#include <algorithm>
#include <cstddef>

#include "tread/stereo/sgm_kernel.hpp"

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/stereo/sgm_cost_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "tread/stereo/rows-inl.hpp"
#include "tread/stereo/sgm-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128  // SgmMatcher uses the plain form there
void census_row(ImageView<const std::uint8_t>, int, std::uint8_t*, Image<std::uint8_t>&) {}
void cost_rows(const SgmImages&, const SgmOptions&, const SgmBlock&, int, int, std::uint8_t*) {}
#else

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

// Both in the worker's memory.
std::uint32_t* take_spread(Arena& arena, const std::uint8_t* from, int width, int beside) {
  auto* out = arena.take<std::uint32_t>(static_cast<std::size_t>(width + 2 * beside) + 16);
  spread_row(from, width, beside, false, out);
  return out;
}

std::uint8_t* take_reversed(Arena& arena, const std::uint8_t* from, int width, int beside,
                            int min_disparity, int padded) {
  const int length = width + 2 * beside + padded + kLanes;
  auto* out = arena.take<std::uint8_t>(static_cast<std::size_t>(length));
  reverse_row(from, width, beside, min_disparity, length, false, out);
  return out;
}

// The differences of the edges of one row, which three rows of costs share.
void difference_row(const SgmImages& images, const SgmOptions& options, int y, std::uint8_t* memory,
                    std::uint8_t* out) {
  const int width = images.left_edges.width;
  const int padded = padded_range(options.num_disparities);
  const int row = std::clamp(y, 0, images.left_edges.height - 1);
  Arena arena{memory};
  const std::uint32_t* left = take_spread(arena, images.left_edges.row(row), width, kEdgeColumns);
  const int columns = width + 2 * kEdgeColumns;
  const std::uint8_t* right = take_reversed(arena, images.right_edges.row(row), width, kEdgeColumns,
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
    census[k] = take_spread(arena, images.left_census.row(3 * y + k), width, 0);
    other_census[k] = take_reversed(arena, images.right_census.row(3 * y + k), width, 0,
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

#endif

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(census_row);
HWY_EXPORT(cost_rows);

void sgm_census_row(ImageView<const std::uint8_t> image, int y, std::uint8_t* memory,
                    Image<std::uint8_t>& census) {
  HWY_DYNAMIC_DISPATCH(census_row)(image, y, memory, census);
}
void sgm_cost_rows(const SgmImages& images, const SgmOptions& options, const SgmBlock& block,
                   int begin, int end, std::uint8_t* memory) {
  HWY_DYNAMIC_DISPATCH(cost_rows)(images, options, block, begin, end, memory);
}
}  // namespace tread
#endif
