#include "tread/slam/frame_path.hpp"

namespace tread {
namespace {

template <class Frame>
void hold(Frame& frame, const Isometry3d& T) {
  Eigen::Map<Eigen::Vector3d>(frame.t.data()) = T.translation();
  Eigen::Map<Eigen::Quaterniond>(frame.q.data()) = Eigen::Quaterniond(T.linear()).normalized();
}

template <class Frame>
Isometry3d held(const Frame& frame) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = Eigen::Map<const Eigen::Vector3d>(frame.t.data());
  T.linear() = Eigen::Map<const Eigen::Quaterniond>(frame.q.data()).toRotationMatrix();
  return T;
}

}  // namespace

void FramePath::add(std::int64_t stamp_ns, std::int64_t anchor, const Isometry3d& T_anchor_camera) {
  if (frames_.size() >= kMost) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (i < kMost / 2 && i % 2 == 1) continue;
      frames_[kept++] = frames_[i];
    }
    frames_.resize(kept);
  }
  Frame frame;
  frame.stamp_ns = stamp_ns;
  frame.anchor = anchor;
  hold(frame, T_anchor_camera);
  frames_.push_back(frame);
}

void FramePath::move_anchor(std::int64_t from, std::int64_t to, const Isometry3d& T_to_from) {
  for (Frame& frame : frames_) {
    if (frame.anchor != from) continue;
    hold(frame, T_to_from * held(frame));
    frame.anchor = to;
  }
}

Trajectory FramePath::poses(
    const std::function<Isometry3d(std::int64_t anchor)>& T_world_anchor) const {
  Trajectory path;
  path.reserve(frames_.size());
  std::int64_t anchor = kWorld;
  Isometry3d T_anchor = Isometry3d::Identity();
  for (const Frame& frame : frames_) {
    if (frame.anchor != anchor) {
      anchor = frame.anchor;
      T_anchor = anchor == kWorld ? Isometry3d::Identity() : T_world_anchor(anchor);
    }
    path.push_back({frame.stamp_ns, T_anchor * held(frame)});
  }
  return path;
}

}  // namespace tread
