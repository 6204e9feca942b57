#include "tread/stereo/temporal_filter.hpp"

#include <cmath>
#include <utility>

#include "tread/core/parallel.hpp"
#include "tread/stereo/filter_kernel.hpp"

namespace tread {

OptionSet describe(TemporalOptions& options) {
  OptionSet set;
  set.add("enabled", options.enabled, "ask that frames in a row agree, for video");
  set.add("max_change_px", options.max_change_px,
          "largest change of a disparity between frames, px", 0.0, 8.0);
  set.add("confirm", options.confirm, "a new match waits for the next frame to agree");
  set.add("memory", options.memory, "share of the frames before in the result, sixteenths", 0, 15);
  return set;
}

void TemporalFilter::apply(Image<Disparity>& disparity, const TemporalOptions& options,
                           const Context& context) {
  if (!options.enabled) {
    reset();  // what was seen before this frame is not the frame before a later one
    return;
  }
  const ScopedTimer timer(context, "stereo/temporal");
  if (!same_size(seen_, disparity)) {
    seen_ = result_ = disparity;
    return;
  }
  const TemporalRule rule{
      static_cast<std::uint16_t>(std::lround(options.max_change_px * kDisparityScale)),
      static_cast<std::uint16_t>(options.memory), options.confirm};
  parallel_chunks(context, 0, disparity.height, 64, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      steady_row(disparity.row(y), seen_.row(y), result_.row(y), disparity.width, rule);
    }
  });
  std::swap(seen_, disparity);
  disparity = result_;
}

}  // namespace tread
