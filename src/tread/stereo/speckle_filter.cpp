#include "tread/stereo/speckle_filter.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "tread/core/parallel.hpp"
#include "tread/stereo/filter_kernel.hpp"

namespace tread {
namespace {

constexpr int kBandRows = 60;

int root_of(std::vector<int>& parent, int run) {
  auto at = static_cast<std::size_t>(run);
  while (parent[at] != static_cast<int>(at)) {
    parent[at] = parent[static_cast<std::size_t>(parent[at])];  // halve the way
    at = static_cast<std::size_t>(parent[at]);
  }
  return static_cast<int>(at);
}

void unite(std::vector<int>& parent, int a, int b) {
  a = root_of(parent, a);
  b = root_of(parent, b);
  parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
}

// The bits of three rows of pixels, a word for 64 columns: joined to the left neighbour, to the one
// above, and known at all.
struct LinkBits {
  LinkBits(std::vector<std::uint64_t>& memory, int row_width)
      : width(row_width), words((static_cast<std::size_t>(row_width) + 63) / 64) {
    memory.assign(4 * words, 0);
    known = memory.data();
    left = known + words;
    left_above = left + words;
    above = left_above + words;
  }
  int width;
  std::size_t words;
  std::uint64_t* known;
  std::uint64_t* left;
  std::uint64_t* left_above;
  std::uint64_t* above;
};

// Calls body(column) for every bit that is set.
template <class Body>
void for_each_bit(std::size_t word, std::uint64_t bits, const Body& body) {
  for (; bits != 0; bits &= bits - 1) {
    body(static_cast<int>(word * 64) + std::countr_zero(bits));
  }
}

// Unites the runs of a row with those of the row above that they touch. A touch that continues one
// of the column before is not looked at.
template <class RunOf, class Unite>
void unite_rows(const LinkBits& bits, int upper, int lower, const RunOf& last_of,
                const Unite& join) {
  std::uint64_t carry = 0;  // of the column before
  for (std::size_t w = 0; w < bits.words; ++w) {
    const std::uint64_t above = bits.above[w];
    const std::uint64_t continued = ((above << 1) | carry) & bits.left[w] & bits.left_above[w];
    carry = above >> 63;
    for_each_bit(w, above & ~continued, [&](int x) {
      while (last_of(upper) <= x) ++upper;
      while (last_of(lower) <= x) ++lower;
      join(upper, lower);
    });
  }
}

}  // namespace

OptionSet describe(SpeckleOptions& options) {
  OptionSet set;
  set.add("enabled", options.enabled, "remove small patches");
  set.add("max_size_px", options.max_size_px, "patches up to this many pixels are removed", 0,
          1'000'000);
  set.add("max_difference_px", options.max_difference_px,
          "largest difference between neighbours of one patch, px", 0.0, 64.0);
  return set;
}

// Runs of the rows first to last - 1 and how they hang together.
void SpeckleFilter::cut(ImageView<const Disparity> disparity, int first, int last, int limit,
                        Band& band) {
  // The most runs there can be: memory that is not used costs nothing, and none is asked for later.
  const auto most = static_cast<std::size_t>(disparity.width) * kBandRows;
  band.runs.reserve(most);
  band.parent.reserve(most);
  band.row_begin.reserve(kBandRows + 1);
  band.runs.clear();
  band.parent.clear();
  band.row_begin.assign(1, 0);
  LinkBits bits(band.bits, disparity.width);
  for (int y = first; y < last; ++y) {
    std::swap(bits.left, bits.left_above);
    link_row(y > first ? disparity.row(y - 1) : nullptr, disparity.row(y), disparity.width, limit,
             bits.known, bits.left, bits.above);
    const auto begin = band.runs.size();
    for (std::size_t w = 0; w < bits.words; ++w) {
      for_each_bit(w, bits.known[w] & ~bits.left[w], [&](int x) { band.runs.push_back({x, x}); });
    }
    // As many ends as beginnings: known pixels whose right neighbour is not joined to them.
    std::size_t run = begin;
    for (std::size_t w = 0; w < bits.words; ++w) {
      const std::uint64_t next = w + 1 < bits.words ? bits.left[w + 1] : 0;
      const std::uint64_t joined_right = bits.left[w] >> 1 | next << 63;
      for_each_bit(w, bits.known[w] & ~joined_right, [&](int x) { band.runs[run++].last = x + 1; });
    }
    for (std::size_t i = begin; i < band.runs.size(); ++i) {
      band.parent.push_back(static_cast<int>(i));
    }
    if (y > first) {
      unite_rows(
          bits, band.row_begin.end()[-2], band.row_begin.back(),
          [&](int r) { return band.runs[static_cast<std::size_t>(r)].last; },
          [&](int a, int b) { unite(band.parent, a, b); });
    }
    band.row_begin.push_back(static_cast<int>(band.runs.size()));
  }
}

// One numbering for the runs of all bands, and the patches that reach across.
void SpeckleFilter::sew(ImageView<const Disparity> disparity, int rows, int limit) {
  const auto most =
      static_cast<std::size_t>(disparity.width) * static_cast<std::size_t>(disparity.height);
  parent_.reserve(most);
  size_.reserve(most);
  parent_.clear();
  for (Band& band : bands_) {
    band.offset = static_cast<int>(parent_.size());
    for (const int p : band.parent) parent_.push_back(p + band.offset);
  }
  for (std::size_t b = 1; b < bands_.size(); ++b) {
    Band& upper = bands_[b - 1];
    Band& lower = bands_[b];
    const int y = static_cast<int>(b) * rows;
    LinkBits bits(lower.bits, disparity.width);
    link_row(nullptr, disparity.row(y - 1), disparity.width, limit, bits.known, bits.left_above,
             bits.above);
    link_row(disparity.row(y - 1), disparity.row(y), disparity.width, limit, bits.known, bits.left,
             bits.above);
    const auto last_of = [&](int run) {
      const Band& band = run < lower.offset ? upper : lower;
      return band.runs[static_cast<std::size_t>(run - band.offset)].last;
    };
    unite_rows(bits, upper.offset + upper.row_begin.end()[-2], lower.offset, last_of,
               [&](int a, int c) { unite(parent_, a, c); });
  }
  size_.assign(parent_.size(), 0);
  for (const Band& band : bands_) {
    for (std::size_t i = 0; i < band.runs.size(); ++i) {
      // Parents lie before their children and have been looked at.
      int& p = parent_[static_cast<std::size_t>(band.offset) + i];
      p = parent_[static_cast<std::size_t>(p)];
      size_[static_cast<std::size_t>(p)] += band.runs[i].last - band.runs[i].first;
    }
  }
}

void SpeckleFilter::apply(Image<Disparity>& disparity, const SpeckleOptions& options,
                          const Context& context) {
  if (!options.enabled || disparity.empty()) return;
  const ScopedTimer timer(context, "stereo/speckle");
  const int limit = static_cast<int>(std::lround(options.max_difference_px * kDisparityScale));
  bands_.resize(static_cast<std::size_t>((disparity.height + kBandRows - 1) / kBandRows));
  parallel_chunks(context, 0, disparity.height, kBandRows, [&](int first, int last) {
    cut(disparity, first, last, limit, bands_[static_cast<std::size_t>(first / kBandRows)]);
  });
  sew(disparity, kBandRows, limit);
  parallel_chunks(context, 0, disparity.height, kBandRows, [&](int first, int last) {
    const Band& band = bands_[static_cast<std::size_t>(first / kBandRows)];
    for (int y = first; y < last; ++y) {
      Disparity* row = disparity.row(y);
      const auto begin =
          static_cast<std::size_t>(band.row_begin[static_cast<std::size_t>(y - first)]);
      const auto end =
          static_cast<std::size_t>(band.row_begin[static_cast<std::size_t>(y - first) + 1]);
      for (std::size_t i = begin; i < end; ++i) {
        const int root = parent_[static_cast<std::size_t>(band.offset) + i];
        if (size_[static_cast<std::size_t>(root)] > options.max_size_px) continue;
        std::fill(row + band.runs[i].first, row + band.runs[i].last, kNoMatch);
      }
    }
  });
}

}  // namespace tread
