#include "tread/stereo/sgm_matcher.hpp"

#include <algorithm>
#include <cassert>

#include "tread/core/parallel.hpp"
#include "tread/stereo/sgm_plain.hpp"

namespace tread {
namespace {

// Rows of a block: what is kept of them at once should fit the second level cache.
constexpr int kBlockRows = 4;
static_assert(kBlockRows % kSgmRowsAtOnce == 0);

// The census of a pixel as its definition says, where there are no vectors.
void census_row_plain(ImageView<const std::uint8_t> image, int y, Image<std::uint8_t>& census) {
  for (int x = 0; x < image.width; ++x) {
    unsigned bits = 0;
    for (int j = -2; j <= 2; ++j) {
      for (int i = -2; i <= 2; ++i) {
        if (i == 0 && j == 0) continue;
        const int neighbour =
            image(std::clamp(x + i, 0, image.width - 1), std::clamp(y + j, 0, image.height - 1));
        bits = bits << 1 | (neighbour < image(x, y) ? 1U : 0U);
      }
    }
    for (int k = 0; k < 3; ++k) {
      census(x, 3 * y + k) = static_cast<std::uint8_t>(bits >> (16 - 8 * k));
    }
  }
}

}  // namespace

OptionSet describe(SgmOptions& options) {
  OptionSet set;
  set.add("p1", options.p1, "price of a step of one disparity along a path", 0, kSgmLargestP2);
  set.add("p2", options.p2, "price of a larger step", 0, kSgmLargestP2);
  set.add_choice("sub_pixel", options.sub_pixel, "refinement below the pixel",
                 {{"none", SubPixel::kNone},
                  {"symmetric_v", SubPixel::kSymmetricV},
                  {"parabola", SubPixel::kParabola}});
  set.add("strict_sub_pixel", options.strict_sub_pixel,
          "no match without a minimum inside the range");
  set.add("uniqueness_percent", options.uniqueness_percent,
          "how much dearer all other disparities must be, per cent; 0: not checked", 0, 100);
  set.add("left_right_tolerance_px", options.left_right_tolerance_px,
          "how far the match back may miss, px; -1: not checked", -1, 16);
  set.add_group("holes", describe(options.holes));
  set.add_group("speckle", describe(options.speckle));
  set.require({"p1", "p2"}, "a larger step must not be cheaper than a small one",
              [&options] { return options.p1 <= options.p2; });
  return set;
}

void SgmMatcher::match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                       ImageView<const std::uint8_t> left_edges,
                       ImageView<const std::uint8_t> right_edges, const SgmOptions& options,
                       Image<Disparity>& disparity, Image<std::uint8_t>* residual,
                       const Context& context) {
  assert(same_size(left, right) && !left.empty());
  const ScopedTimer timer(context, "stereo/match");
  const int width = left.width, height = left.height;
  disparity.resize(width, height);
  MatchOutput output{disparity};
  if (residual != nullptr) {
    residual->resize(width, height);
    output.residual = *residual;
  }
  left_census_.resize(width, 3 * height);
  right_census_.resize(width, 3 * height);
  const SgmImages images{left_edges, right_edges, left_census_, right_census_};
  const int padded = sgm_padded_range(options.num_disparities);
  if (padded == 0) {
    for (int y = 0; y < height; ++y) {
      census_row_plain(left, y, left_census_);
      census_row_plain(right, y, right_census_);
    }
    match_sgm_plain(images, options, output);
    return;
  }

  const auto workers = static_cast<std::size_t>(worker_count(context));
  memory_.resize(std::max(memory_.size(), workers));
  for (Image<std::uint8_t>& memory : memory_) {
    memory.resize(static_cast<int>(sgm_worker_bytes(width, options.num_disparities)), 1);
  }
  const auto memory_of = [this](int worker) {
    return memory_[static_cast<std::size_t>(worker)].row(0);
  };
  parallel_chunks(context, 0, height, 32, [&](int first, int last, int worker) {
    for (int y = first; y < last; ++y) {
      sgm_census_row(left, y, memory_of(worker), left_census_);
      sgm_census_row(right, y, memory_of(worker), right_census_);
    }
  });

  const int block_rows = kBlockRows * static_cast<int>(workers);
  SgmBlock block;
  block.row_stride = static_cast<std::ptrdiff_t>(width) * padded;
  block.pixel_stride = width + 64;
  costs_.resize(static_cast<int>(block.row_stride), 2 * block_rows);
  block.row_stride = costs_.stride;
  block.cost = costs_.row(0);
  block.sides = costs_.row(block_rows);
  above_.resize(static_cast<int>(sgm_above_bytes(width, options.num_disparities)), 1);
  block.above = above_.row(0);
  pixels_.resize(static_cast<int>(block.pixel_stride * 8), block_rows);
  block.pixels = reinterpret_cast<std::uint64_t*>(pixels_.row(0));
  block.pixel_stride = pixels_.stride / 8;
  sgm_begin(width, options, block.above);
  const int columns = (width / static_cast<int>(workers) + 63) / 64 * 64 + 64;
  for (block.first = 0; block.first < height; block.first = block.last) {
    block.last = std::min(height, block.first + block_rows);
    parallel_chunks(context, block.first, block.last, kBlockRows,
                    [&](int first, int last, int worker) {
                      sgm_cost_rows(images, options, block, first, last, memory_of(worker));
                      sgm_side_rows(options, width, block, first, last);
                    });
    parallel_chunks(context, 0, width, columns, [&](int first, int last, int worker) {
      sgm_above_columns(options, width, block, first, last, memory_of(worker));
    });
    parallel_chunks(
        context, block.first, block.last, kBlockRows, [&](int first, int last, int worker) {
          sgm_finish_rows(options, width, block, first, last, memory_of(worker), output);
        });
  }
}

}  // namespace tread
