// Places by what they look like from any near angle and distance: corners with binary descriptors
// (ORB: Rublee and others 2011) whose points in space are known, so that a place that is recognised
// also says from where it is seen. A frame is compared with all places by groups of bits that their
// descriptors share (as Norouzi, Punjani, Fleet 2012 look for near codes), with the likeliest ones
// corner by corner, and what is believed must agree in space both ways: a false place is worse than
// none.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "tread/core/image.hpp"
#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/slam/depth_level.hpp"
#include "tread/slam/fit_motion.hpp"

namespace tread {

struct PlaceOptions {
  int corners = 400;         // of a view, at most; 48 bytes each
  int most_bits = 64;        // of 256 that differ between descriptors of one corner
  double ratio = 0.85;       // of the bits to the second best: as good is no match
  int least_inliers = 25;    // corners that agree in space, both ways
  double least_share = 0.5;  // of those matched
  int least_cells = 6;       // of 8 x 6 that the image is cut into, with such corners in each view
  double corner_px = 1.0;    // how far off a corner may be, one standard deviation
  [[nodiscard]] bool operator==(const PlaceOptions&) const = default;
};
[[nodiscard]] OptionSet describe(PlaceOptions& options);

// What one image shows.
struct PlaceView {
  struct Corner {
    float u = 0.0F, v = 0.0F;  // pixels
    float depth_m = 0.0F;      // NaN where unknown, or at the edge of something
  };
  using Descriptor = std::array<std::uint64_t, 4>;
  Pinhole camera;
  int width = 0, height = 0;
  std::vector<Corner> corners;
  std::vector<Descriptor> descriptors;  // one a corner
};

// Corners of an image, spread over it, with their depth from the same camera. Some 4 ms for 320 x
// 240. No corners for an image that is too small or empty.
[[nodiscard]] PlaceView view_place(ImageView<const std::uint8_t> grey, ImageView<const float> depth,
                                   const Pinhole& camera, const PlaceOptions& options,
                                   const Context& context = {});

struct PlaceMatch {
  bool found = false;
  std::int64_t id = 0;
  Isometry3d T_place_query = Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of a twist in axes of the query's camera
  int matched = 0, inliers = 0;
  double rms_px = 0.0;
};

class PlaceMemory {
 public:
  explicit PlaceMemory(const PlaceOptions& options = {}) : options_(options) {}

  static constexpr std::size_t kMost = 1000;  // places

  // False, and nothing is kept, with kMost places, an id that is known, or no corners. What makes
  // room is remove(): who keeps places knows which to spare.
  bool add(std::int64_t id, PlaceView view);
  void remove(std::int64_t id) { places_.erase(id); }

  struct Candidate {
    std::int64_t id = 0;
    int matched = 0;  // corners
  };
  // Up to `most` of the places that `may_be` says yes to, those with the most matches first. Some
  // 15 ms with a thousand places, 1 ms of it for each that is asked for.
  [[nodiscard]] std::vector<Candidate> find(const PlaceView& query, std::size_t most,
                                            const std::function<bool(std::int64_t)>& may_be,
                                            const Context& context = {}) const;

  // From where the query sees the place. `T_place_query` is a guess, which helps but need not be
  // near.
  [[nodiscard]] PlaceMatch verify(std::int64_t id, const PlaceView& query,
                                  const Isometry3d& T_place_query = Isometry3d::Identity(),
                                  const Context& context = {}) const;

  // What was added by that id; null if nothing was.
  [[nodiscard]] const PlaceView* view(std::int64_t id) const {
    const auto at = places_.find(id);
    return at == places_.end() ? nullptr : &at->second;
  }
  [[nodiscard]] std::size_t size() const { return places_.size(); }
  // Of all places: at most kMost times `corners` times what one takes.
  [[nodiscard]] std::size_t bytes() const;

 private:
  PlaceOptions options_;
  std::map<std::int64_t, PlaceView> places_;
};

}  // namespace tread
