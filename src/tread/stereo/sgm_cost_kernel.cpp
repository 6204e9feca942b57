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

// Differences of the edges, column by column: of the row last seen, and its sum with the one
// before.
struct EdgeRows {
  std::uint8_t* one;
  std::uint8_t* two;
};

// Edges of a row, laid out for all disparities of all columns.
struct EdgeRow {
  const std::uint32_t* left;
  const std::uint8_t* right;

  EdgeRow(const SgmImages& images, const SgmOptions& options, int y, Arena& arena) {
    const int width = images.left_edges.width, columns = width + 2 * kEdgeColumns;
    const int row = std::clamp(y, 0, images.left_edges.height - 1);
    left = take_spread(arena, images.left_edges.row(row), width, kEdgeColumns);
    right = take_reversed(arena, images.right_edges.row(row), width, kEdgeColumns,
                          options.min_disparity_px, padded_range(options.num_disparities)) +
            columns - 1;
  }
  HWY_INLINE Bytes difference(int column, int d) const {
    const Bytes here = BitCast(U8(), Set(U32(), left[column]));
    const Bytes other = LoadU(U8(), right - column + d);
    return Sub(Max(here, other), Min(here, other));
  }
};

// Before the costs of row y: its differences, and those of the row before.
void begin_edges(const SgmImages& images, const SgmOptions& options, int y, std::uint8_t* memory,
                 const EdgeRows& rows) {
  Arena arena{memory};
  const EdgeRow before(images, options, y - 1, arena), here(images, options, y, arena);
  const int padded = padded_range(options.num_disparities);
  std::ptrdiff_t at = 0;
  for (int c = 0; c < images.left_edges.width + 2 * kEdgeColumns; ++c) {
    for (int d = 0; d < padded; d += kLanes, at += kLanes) {
      const Bytes one = here.difference(c, d);
      Store(one, U8(), rows.one + at);
      Store(SaturatedAdd(before.difference(c, d), one), U8(), rows.two + at);
    }
  }
}

// How many bits are set in three bytes.
HWY_INLINE Bytes differing_bits(Bytes a, Bytes b, Bytes c) {
#if HWY_TARGET == HWY_AVX3_DL
  return Add(Add(PopulationCount(a), PopulationCount(b)), PopulationCount(c));
#else
  // Where counting is dear: of three bits of equal weight, their sum and their carry.
  const Bytes differ = Xor(a, b);
  const Bytes odd = PopulationCount(Xor(differ, c));
  const Bytes twice = PopulationCount(Or(And(a, b), And(differ, c)));
  return Add(odd, Add(twice, twice));
#endif
}

// One row of costs; `rows` moves on to the next one.
void cost_row(const SgmImages& images, const SgmOptions& options, int y, const EdgeRows& rows,
              std::uint8_t* memory, std::uint8_t* out) {
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
  const EdgeRow below(images, options, y + 1, arena);
  const Bytes most = Set(U8(), kSgmLargestEdgeCost);
  for (int d = 0; d < padded; d += kLanes) {
    const Bytes beyond = outside(d / kLanes, range);
    // The sum of three rows of a column; to be asked once for each.
    const auto column_sum = [&](int c) HWY_ATTR {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(c) * padded + d;
      const Bytes next = below.difference(c, d);
      const Bytes sum = SaturatedAdd(Load(U8(), rows.two + at), next);
      Store(SaturatedAdd(Load(U8(), rows.one + at), next), U8(), rows.two + at);
      Store(next, U8(), rows.one + at);
      return sum;
    };
    // The last column, and two neighbours each that begin two, three and four columns back.
    const Bytes first = column_sum(0), second = column_sum(1), third = column_sum(2);
    Bytes last = column_sum(3);
    Bytes two_back = SaturatedAdd(third, last);
    Bytes three_back = SaturatedAdd(second, third);
    Bytes four_back = SaturatedAdd(first, second);
    for (int x = 0; x < width; ++x) {
      const Bytes column = column_sum(x + 2 * kEdgeColumns);
      const Bytes sum = SaturatedAdd(SaturatedAdd(four_back, two_back), column);
      four_back = three_back;
      three_back = two_back;
      two_back = SaturatedAdd(last, column);
      last = column;
      const auto bits = [&](int k) HWY_ATTR {
        return Xor(BitCast(U8(), Set(U32(), census[k][x])), LoadU(U8(), other_census[k] - x + d));
      };
      const Bytes edges = Min(BitCast(U8(), hn::ShiftRight<3>(sum)), most);
      const Bytes total = Add(differing_bits(bits(0), bits(1), bits(2)), edges);
      Store(Or(total, beyond), U8(), out + static_cast<std::ptrdiff_t>(x) * padded + d);
    }
  }
}

void cost_rows(const SgmImages& images, const SgmOptions& options, const SgmBlock& block, int begin,
               int end, std::uint8_t* memory) {
  const std::size_t bytes = difference_bytes(images.left_edges.width, options.num_disparities);
  Arena arena{memory};
  EdgeRows rows{};
  rows.one = arena.take<std::uint8_t>(bytes);
  rows.two = arena.take<std::uint8_t>(bytes);
  begin_edges(images, options, begin, arena.at, rows);
  for (int y = begin; y < end; ++y) {
    cost_row(images, options, y, rows, arena.at, block.cost + (y - block.first) * block.row_stride);
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
