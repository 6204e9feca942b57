// The parts of semi-global matching, vectorised (sgm_matcher.hpp has the definition). A block of
// rows goes through four steps: the costs, the two paths along each row, the path from above with
// the choice of the winner, the disparities. The first, second and fourth are apart for each row,
// the third for each column. With four or eight paths, the third becomes three: the paths down all
// of the image; then, from the last row up, those up, and the winners.
#pragma once

#include "tread/stereo/sgm_matcher.hpp"

namespace tread {

inline constexpr int kSgmLargestCensus = 24;
inline constexpr int kSgmLargestEdgeCost = 11;
inline constexpr int kSgmLargestP2 = 49;
inline constexpr int kSgmNoCost = 255;         // above every sum
inline constexpr int kSgmRowsAtOnce = 4;       // the rows of a block in memory are a multiple of it
inline constexpr int kSgmNoWideCost = 0x7FFF;  // above every sum of eight paths
static_assert(3 * (kSgmLargestCensus + kSgmLargestEdgeCost + kSgmLargestP2) < kSgmNoCost);

struct SgmImages {
  ImageView<const std::uint8_t> left_edges;
  ImageView<const std::uint8_t> right_edges;
  ImageView<const std::uint8_t> left_census;  // three rows for each of the image: 24 bits a pixel
  ImageView<const std::uint8_t> right_census;
};

// Rows first to last - 1 of what lies in memory for a block of rows; row y's begins at
// (y - first) * row_stride of each array.
struct SgmBlock {
  int first = 0;
  int last = 0;
  std::ptrdiff_t row_stride = 0;  // bytes: width * padded range
  std::uint8_t* cost = nullptr;
  std::uint8_t* sides = nullptr;    // sum of the paths from the left and from the right
  std::uint8_t* above = nullptr;    // sgm_above_bytes, kept from block to block
  std::uint64_t* pixels = nullptr;  // what is found out about each pixel
  std::ptrdiff_t pixel_stride = 0;  // of a row, at least width + 64
};

// The range padded to whole vectors of the instruction set in use.
[[nodiscard]] int sgm_padded_range(int num_disparities);
// The bytes of `above` for so many columns, and of the memory of one worker.
[[nodiscard]] std::size_t sgm_above_bytes(int width, int num_disparities);
[[nodiscard]] std::size_t sgm_worker_bytes(int width, int num_disparities);

// 24 bits in three rows of `census` from row 3 y on: which of the 5x5 neighbours are darker. Beyond
// the border lie the nearest pixels.
void sgm_census_row(ImageView<const std::uint8_t> image, int y, std::uint8_t* memory,
                    Image<std::uint8_t>& census);
// Before the first row: nothing has come from above yet.
void sgm_begin(int width, const SgmOptions& options, std::uint8_t* above);
// Costs of the rows [begin, end) of the block.
void sgm_cost_rows(const SgmImages& images, const SgmOptions& options, const SgmBlock& block,
                   int begin, int end, std::uint8_t* memory);
// Both paths along the rows [begin, end), and on up to a multiple of kSgmRowsAtOnce rows.
void sgm_side_rows(const SgmOptions& options, int width, const SgmBlock& block, int begin, int end);
// The path from above and the winners, columns [begin, end) of all rows of the block.
void sgm_above_columns(const SgmOptions& options, int width, const SgmBlock& block, int begin,
                       int end, std::uint8_t* memory);
// The disparities of the rows [begin, end). no_cost: what stands for no disparity in the sums.
void sgm_finish_rows(const SgmOptions& options, int width, const SgmBlock& block, int no_cost,
                     int begin, int end, std::uint8_t* memory, const MatchOutput& output);

// One row on the way down or up the image. A front holds the paths that have come that far.
struct SgmFront {
  const std::uint8_t* cost = nullptr;    // of the row
  const std::uint8_t* before = nullptr;  // the front one row back
  std::uint8_t* here = nullptr;          // becomes the front of this row
  std::uint8_t* sum = nullptr;           // becomes the sum of the row's paths
  int paths = 1;                         // straight on; 3: and both diagonals
};
[[nodiscard]] std::size_t sgm_front_bytes(int width, int num_disparities);
// Outside the image nothing has come yet.
void sgm_begin_front(int width, const SgmOptions& options, std::uint8_t* front);
// Columns [begin, end).
void sgm_front_row(const SgmOptions& options, int width, const SgmFront& front, int begin, int end);

// The sums of a row's paths, in three parts.
struct SgmSums {
  const std::uint8_t* down = nullptr;
  const std::uint8_t* up = nullptr;
  const std::uint8_t* sides = nullptr;
};
// The winners of columns [begin, end), left in `pixels`.
void sgm_full_winners(const SgmOptions& options, const SgmSums& sums, int begin, int end,
                      std::uint8_t* memory, std::uint64_t* pixels);

}  // namespace tread
