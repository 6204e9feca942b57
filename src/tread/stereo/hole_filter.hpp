// The hole filter of paper Q, IV-A.2, word for word: a pixel without disparity takes the previous
// frame's, and if that has none, the median of its 3x3 neighbourhood. What the text leaves open is
// switchable; the defaults are the readings of METHODS 4.
#pragma once

#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/stereo/disparity.hpp"

namespace tread {

struct HoleFilterOptions {
  bool temporal = false;  // fill from the previous frame; only right where the camera hardly moves
  bool spatial = true;    // fill from the neighbourhood
  // (a) Which previous frame: as matched, so that a value lives one frame longer, or as filtered,
  // so that a ghost can live for ever.
  enum class Previous { kRaw, kFiltered } previous = Previous::kRaw;
  // (b) What the median is taken of: all nine values with "no match" as the largest (a hole is
  // filled only if five neighbours are known), or the known ones alone (of an even number the upper
  // of the two in the middle).
  enum class Median { kAll, kKnown } median = Median::kKnown;
  int min_known = 5;  // with kKnown: neighbours that must be known
  // Ours, and not of the paper: neighbours that differ by more lie on both sides of a depth edge,
  // and the hole between them stays one. px; 0: not checked.
  double max_spread_px = 0.75;
  // (c) Whether filled pixels count as known for the pixels after them in the same pass.
  enum class Update { kBuffered, kInPlace } update = Update::kBuffered;
  int passes = 1;  // spatial passes; each shrinks holes by one pixel all around
  [[nodiscard]] bool operator==(const HoleFilterOptions&) const = default;
};
[[nodiscard]] OptionSet describe(HoleFilterOptions& options);

// One a stream: keeps the previous frame.
class HoleFilter {
 public:
  // Fills holes of `disparity` in place. After a change of size there is no previous frame.
  void apply(Image<Disparity>& disparity, const HoleFilterOptions& options,
             const Context& context = {});
  void reset() { previous_ = {}; }

 private:
  void fill_buffered(Image<Disparity>& disparity, const HoleFilterOptions& options,
                     bool from_previous, const Context& context);
  void fill_in_place(Image<Disparity>& disparity, const HoleFilterOptions& options,
                     bool from_previous);

  Image<Disparity> previous_;
  Image<Disparity> raw_;
  Image<Disparity> buffer_;
  std::vector<Disparity> unknown_;                 // a row without any, above and below the image
  std::vector<std::vector<std::uint64_t>> known_;  // by worker: which pixels of three rows are
};

}  // namespace tread
