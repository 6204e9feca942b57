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

}  // namespace

OptionSet describe(SgmOptions& options) {
  OptionSet set;
  set.add_choice("paths", options.paths, "along how many paths costs are smoothed",
                 {{"3", SgmPaths::kThree}, {"4", SgmPaths::kFour}, {"8", SgmPaths::kEight}});
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

// One pair, and where its rows lie in memory.
struct SgmMatcher::Job {
  const SgmImages& images;
  const SgmOptions& options;
  const MatchOutput& output;
  const Context& context;
  int width;
  int height;
  int padded;  // range
  int workers;
  std::vector<Image<std::uint8_t>>& memory;
  SgmBlock block;

  [[nodiscard]] std::uint8_t* memory_of(int worker) const {
    return memory[static_cast<std::size_t>(worker)].row(0);
  }
  [[nodiscard]] int block_rows() const { return kBlockRows * workers; }
  // Calls body(first, last, worker) for some rows of the block each.
  template <class Body>
  void for_rows(const SgmBlock& rows, const Body& body) const {
    parallel_chunks(context, rows.first, rows.last, kBlockRows, body);
  }
  template <class Body>
  void for_columns(const Body& body) const {
    parallel_chunks(context, 0, width, (width / workers + 63) / 64 * 64 + 64, body);
  }
};

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

  Job job{images,  options, output, context, width, height, padded, worker_count(context),
          memory_, {}};
  memory_.resize(std::max(memory_.size(), static_cast<std::size_t>(job.workers)));
  for (Image<std::uint8_t>& memory : memory_) {
    memory.resize(static_cast<int>(sgm_worker_bytes(width, options.num_disparities)), 1);
  }
  parallel_chunks(context, 0, height, 32, [&](int first, int last, int worker) {
    for (int y = first; y < last; ++y) {
      sgm_census_row(left, y, job.memory_of(worker), left_census_);
      sgm_census_row(right, y, job.memory_of(worker), right_census_);
    }
  });
  costs_.resize(width * padded, 2 * job.block_rows());
  job.block.row_stride = costs_.stride;
  job.block.cost = costs_.row(0);
  job.block.sides = costs_.row(job.block_rows());
  pixels_.resize((width + 64) * 8, job.block_rows());
  job.block.pixels = reinterpret_cast<std::uint64_t*>(pixels_.row(0));
  job.block.pixel_stride = pixels_.stride / 8;
  if (options.paths == SgmPaths::kThree) {
    match_streaming(job);
  } else {
    match_full(job);
  }
}

void SgmMatcher::match_streaming(const Job& job) {
  const SgmOptions& options = job.options;
  SgmBlock block = job.block;
  above_.resize(static_cast<int>(sgm_above_bytes(job.width, options.num_disparities)), 1);
  block.above = above_.row(0);
  sgm_begin(job.width, options, block.above);
  for (block.first = 0; block.first < job.height; block.first = block.last) {
    block.last = std::min(job.height, block.first + job.block_rows());
    job.for_rows(block, [&](int first, int last, int worker) {
      sgm_cost_rows(job.images, options, block, first, last, job.memory_of(worker));
      sgm_side_rows(options, job.width, block, first, last);
    });
    job.for_columns([&](int first, int last, int worker) {
      sgm_above_columns(options, job.width, block, first, last, job.memory_of(worker));
    });
    job.for_rows(block, [&](int first, int last, int worker) {
      sgm_finish_rows(options, job.width, block, kSgmNoCost, first, last, job.memory_of(worker),
                      job.output);
    });
  }
}

void SgmMatcher::match_full(const Job& job) {
  const SgmOptions& options = job.options;
  const int width = job.width;
  SgmBlock block = job.block;
  const auto front_bytes = static_cast<int>(sgm_front_bytes(width, options.num_disparities));
  fronts_.resize(std::max(front_bytes, width * job.padded), 3);
  down_.resize(width * job.padded, job.height);
  SgmFront front;
  front.paths = options.paths == SgmPaths::kEight ? 3 : 1;
  const auto begin_fronts = [&] {
    for (const int i : {0, 1}) sgm_begin_front(width, options, fronts_.row(i));
    front.before = fronts_.row(0);
    front.here = fronts_.row(1);
  };
  const auto place_row = [&](int y, std::uint8_t* sum) {
    front.cost = block.cost + (y - block.first) * block.row_stride;
    front.sum = sum;
  };
  const auto next_row = [&] {
    std::uint8_t* const here = front.here;
    front.here = fronts_.row(here == fronts_.row(1) ? 0 : 1);
    front.before = here;
  };

  begin_fronts();
  for (block.first = 0; block.first < job.height; block.first = block.last) {
    block.last = std::min(job.height, block.first + job.block_rows());
    job.for_rows(block, [&](int first, int last, int worker) {
      sgm_cost_rows(job.images, options, block, first, last, job.memory_of(worker));
    });
    for (int y = block.first; y < block.last; ++y, next_row()) {
      place_row(y, down_.row(y));
      job.for_columns(
          [&](int first, int last, int) { sgm_front_row(options, width, front, first, last); });
    }
  }

  begin_fronts();
  for (block.last = job.height; block.last > 0; block.last = block.first) {
    block.first = std::max(0, block.last - job.block_rows());
    job.for_rows(block, [&](int first, int last, int worker) {
      sgm_cost_rows(job.images, options, block, first, last, job.memory_of(worker));
      sgm_side_rows(options, width, block, first, last);
    });
    for (int y = block.last - 1; y >= block.first; --y, next_row()) {
      place_row(y, fronts_.row(2));
      const std::ptrdiff_t row = y - block.first;
      const SgmSums sums{down_.row(y), front.sum, block.sides + row * block.row_stride};
      job.for_columns([&](int first, int last, int worker) {
        sgm_front_row(options, width, front, first, last);
        sgm_full_winners(options, sums, first, last, job.memory_of(worker),
                         block.pixels + row * block.pixel_stride);
      });
    }
    job.for_rows(block, [&](int first, int last, int worker) {
      sgm_finish_rows(options, width, block, kSgmNoWideCost, first, last, job.memory_of(worker),
                      job.output);
    });
  }
}

}  // namespace tread
