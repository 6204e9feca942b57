#include "tread/slam/corner_track.hpp"

#include <limits>

namespace tread {
namespace {

constexpr double kLeastCorrelation = 0.8;
constexpr double kLargestCorrection_px = 2.0;
constexpr double kLargestGrowth = 2.0;  // of the area, before a patch is taken anew

// Moves `warp` to where the patch is; false, and as it was, if that is not near.
bool align_nearby(const CornerPatch& patch, ImageView<const std::uint8_t> image,
                  CornerPatch::Warp& warp) {
  CornerPatch::Warp found = warp;
  const auto correlation = patch.align(image, found);
  if (!correlation || *correlation < kLeastCorrelation ||
      (found.place - warp.place).norm() > kLargestCorrection_px) {
    return false;
  }
  warp = found;
  return true;
}

void align_right(ImageView<const std::uint8_t> right, CornerTrack& track) {
  if (!track.sight.has_right()) return;
  CornerPatch::Warp warp{{track.sight.u_right, track.sight.v}, track.warp.A};
  track.sight.u_right = align_nearby(track.patch, right, warp)
                            ? warp.place.x()
                            : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::optional<CornerTrack> make_corner_track(const StereoView& view, const StereoSight& sight) {
  const auto patch = CornerPatch::take(view.left, {sight.u, sight.v});
  if (!patch) return std::nullopt;
  CornerTrack track;
  track.sight = sight;
  track.patch = *patch;
  track.warp.place = {sight.u, sight.v};
  align_right(view.right, track);
  if (!track.sight.has_right()) return std::nullopt;
  return track;
}

void settle(const StereoView& view, CornerTrack& track) {
  CornerPatch::Warp warp{{track.sight.u, track.sight.v}, track.warp.A};
  const Eigen::Vector2d followed = warp.place;
  if (align_nearby(track.patch, view.left, warp)) {
    const Eigen::Vector2d correction = warp.place - followed;
    track.sight.u += correction.x();
    track.sight.v += correction.y();
    track.sight.u_right += correction.x();
    track.warp = warp;
    align_right(view.right, track);
    const double growth = warp.A.determinant();
    if (growth < kLargestGrowth && growth > 1.0 / kLargestGrowth) return;
  }
  const Eigen::Vector2d place(track.sight.u, track.sight.v);
  if (const auto patch = CornerPatch::take(view.left, place)) {
    track.patch = *patch;
    track.warp = {place, Eigen::Matrix2d::Identity()};
  }
}

}  // namespace tread
