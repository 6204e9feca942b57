#include "tread/slam/keyframe_bank.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace tread {
namespace {

constexpr double kNearM = 0.25, kNearRad = 15.0 * std::numbers::pi / 180.0;
constexpr double kLeastLikeness = 0.3;

// Half the coarsest level, smoothed, without its mean, of length one.
std::vector<float> thumbnail_of(const Image<float>& grey) {
  const int width = grey.width / 2 - 1, height = grey.height / 2 - 1;
  std::vector<float> thumbnail;
  if (width <= 0 || height <= 0) return thumbnail;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float sum = 0.0F;
      for (int j = 0; j < 4; ++j) {
        const float* row = grey.row(2 * y + j) + 2 * x;
        sum += row[0] + row[1] + row[2] + row[3];
      }
      thumbnail.push_back(sum);
    }
  }
  const float mean = std::accumulate(thumbnail.begin(), thumbnail.end(), 0.0F) /
                     static_cast<float>(thumbnail.size());
  float square = 1e-6F;
  for (float& v : thumbnail) {
    v -= mean;
    square += v * v;
  }
  for (float& v : thumbnail) v /= std::sqrt(square);
  return thumbnail;
}

double likeness_of(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() ? std::inner_product(a.begin(), a.end(), b.begin(), 0.0) : -1.0;
}

}  // namespace

void KeyframeBank::add(const AlignFrame& frame, const DepthLevel& depth,
                       const Isometry3d& T_world_camera, std::int64_t anchor) {
  if (!frame.has_grey()) return;
  for (const View& view : views_) {
    const Isometry3d between = view.T_world_camera.inverse() * T_world_camera;
    if (between.translation().norm() < kNearM && so3_log(between.linear()).norm() < kNearRad)
      return;
  }
  if (views_.size() >= kMost) thin_out();
  const Image<float>& grey = frame.grey[2].intensity;
  views_.push_back({grey, depth.depth, depth.camera, T_world_camera, thumbnail_of(grey), anchor});
}

void KeyframeBank::move(const std::function<Isometry3d(std::int64_t anchor)>& correction) {
  for (View& view : views_) view.T_world_camera = correction(view.anchor) * view.T_world_camera;
}

// The first view of all stays.
void KeyframeBank::thin_out() {
  const std::size_t older = views_.size() / 2;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (i < older && i % 2 == 1) continue;
    if (kept != i) views_[kept] = std::move(views_[i]);
    ++kept;
  }
  views_.resize(kept);
}

std::vector<KeyframeBank::Candidate> KeyframeBank::find(const AlignFrame& frame,
                                                        std::size_t most) const {
  std::vector<Candidate> found;
  if (!frame.has_grey()) return found;
  const std::vector<float> thumbnail = thumbnail_of(frame.grey[2].intensity);
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const double likeness = likeness_of(thumbnail, views_[i].thumbnail);
    if (likeness >= kLeastLikeness) order.emplace_back(-likeness, i);
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(order.size(), most));
  for (const auto& [unlikeness, i] : order) {
    const View& view = views_[i];
    const GreyLevel grey = with_slopes(view.grey);
    Candidate candidate;
    candidate.likeness = -unlikeness;
    candidate.anchor = view.anchor;
    candidate.T_world_camera = view.T_world_camera;
    candidate.T_world_camera.linear() =
        view.T_world_camera.linear() * align_rotation(grey, frame.grey[2], view.camera);
    DepthLevel depth;
    depth.camera = view.camera;
    depth.depth = view.depth;
    choose_photo_points(grey, depth, 2.0, 4000, candidate.key.points[2]);
    candidate.key.T_world_camera = view.T_world_camera;
    candidate.key.camera[2] = view.camera;
    found.push_back(std::move(candidate));
  }
  return found;
}

}  // namespace tread
