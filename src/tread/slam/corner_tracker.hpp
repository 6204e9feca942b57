// Corners of a rectified pair: found, followed from image to image, and found again in the right
// image (Shi and Tomasi 1994; Bouguet 2000 for the pyramids).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tread/core/image.hpp"
#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/slam/stereo_sight.hpp"

namespace tread {

struct CornerOptions {
  int most = 400;                  // features at once
  int window_px = 15;              // side of the square that is followed
  int levels = 4;                  // of the pyramid
  double least_corner = 1.5;       // slope in the weaker direction, grey values a pixel
  double most_return_px = 0.7;     // followed there and back a feature must come so near
  double most_row_px = 1.5;        // the right image may differ by so much in its rows
  double least_correlation = 0.8;  // of the two patches
  [[nodiscard]] bool operator==(const CornerOptions&) const = default;
};
[[nodiscard]] OptionSet describe(CornerOptions& options);

class CornerTracker {
 public:
  explicit CornerTracker(const CornerOptions& options);
  ~CornerTracker();
  CornerTracker(CornerTracker&&) noexcept;
  CornerTracker& operator=(CornerTracker&&) noexcept;

  // The pair of now. Both rectified, of one size, which is that of all pairs.
  void see(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
           const Context& context);

  // From now on corners are followed from the left image of now: from keyframe to keyframe, not
  // from image to image, each of which would add its error.
  void keep();

  // Places `from` of the left image kept, as `to` in the one now: in, guesses; out, what was found.
  // found[i] is 0 where it was not.
  void follow(std::span<const Eigen::Vector2d> from, std::span<Eigen::Vector2d> to,
              std::vector<std::uint8_t>& found, const Context& context);

  // u_right of sights in the pair of now; not a number where there is none. In: a guess of it, or
  // not a number, in which case disparities from `first` to `last` are searched.
  void find_right(std::span<StereoSight> sights, double first, double last, const Context& context);

  // New corners of the left image now, strongest first, apart from each other and from `taken`, so
  // that there are not more than options.most with those.
  [[nodiscard]] std::vector<Eigen::Vector2d> detect(std::span<const Eigen::Vector2d> taken,
                                                    const Context& context);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tread
