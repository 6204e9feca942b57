#include "tread/pipeline/odometry_source.hpp"

#include <cmath>

#include "tread/geometry/rectification.hpp"
#include "tread/slam/inertial_start.hpp"

namespace tread {
namespace {

class OdometrySource final : public StereoSource {
 public:
  OdometrySource(std::unique_ptr<StereoSource> pairs, const OdometryOptions& options,
                 const Context& context)
      : pairs_(std::move(pairs)), options_(options), context_(context) {}

  [[nodiscard]] Status prepare() {
    const StereoRig& of = pairs_->rig();
    if (of.rectified) {
      const auto rectified = rectified_rig(of);
      if (!rectified) return forward(rectified);
      rectified_ = *rectified;
    } else {
      auto made = make_rectification(of);
      if (!made) return forward(made);
      rectification_ = std::move(*made);
      rectified_ = rectification_->rig;
      T_left_rectified_.linear() = rectification_->R_rectified_left.transpose();
    }
    return {};
  }

  [[nodiscard]] const StereoRig& rig() const override { return pairs_->rig(); }
  [[nodiscard]] int frame_count() const override { return pairs_->frame_count(); }
  [[nodiscard]] bool has_poses() const override { return true; }
  [[nodiscard]] bool has_imu() const override { return pairs_->has_imu(); }
  [[nodiscard]] const std::vector<Error>& problems() const override { return pairs_->problems(); }
  [[nodiscard]] std::string kind() const override {
    return pairs_->kind() + ", placed by visual odometry";
  }

  [[nodiscard]] Result<std::optional<StereoFrame>> next() override {
    auto frame = pairs_->next();
    if (!frame || !*frame) return frame;
    StereoFrame& pair = **frame;
    ImageView<const std::uint8_t> left = pair.left, right = pair.right;
    if (rectification_) {
      left_.resize(pair.left.width, pair.left.height);
      right_.resize(pair.right.width, pair.right.height);
      remap(pair.left, rectification_->left, left_, context_);
      remap(pair.right, rectification_->right, right_, context_);
      left = left_;
      right = right_;
    }
    if (!odometry_) start(pair);
    const auto state =
        odometry_->track({pair.stamp_ns, left, right, std::nullopt, pair.imu}, context_);
    if (!state) return forward(state);
    pair.T_world_left.reset();
    if (state->placed()) pair.T_world_left = state->T_world_camera * T_left_rectified_.inverse();
    return frame;
  }

 private:
  void start(const StereoFrame& first) {
    Isometry3d T_world_left = Isometry3d::Identity();
    T_world_left.linear() = R_body_optical();
    if (rig().mount) T_world_left = rig().mount->T_body_left;
    Isometry3d T_world_rectified = T_world_left * T_left_rectified_;
    std::optional<Imu> imu;
    if (rig().imu && pairs_->has_imu()) {
      imu = rig().imu;
      imu->T_imu_left = imu->T_imu_left * T_left_rectified_;
      // The IMU knows better how the camera leans; where forward is, the mount.
      if (const auto level = level_camera(first.imu, imu->T_imu_left.inverse())) {
        const double yaw = yaw_of(T_world_rectified.linear()) - yaw_of(*level);
        T_world_rectified.linear() =
            Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * *level;
      }
    }
    odometry_.emplace(rectified_, options_, T_world_rectified, imu);
  }
  // Where the optical axis points, from above; where it points down, the upper edge of the image.
  [[nodiscard]] static double yaw_of(const Eigen::Matrix3d& R_world_camera) {
    const Eigen::Vector3d ahead = R_world_camera.col(2) - R_world_camera.col(1);
    return std::atan2(ahead.y(), ahead.x());
  }

  std::unique_ptr<StereoSource> pairs_;
  OdometryOptions options_;
  Context context_;
  RectifiedRig rectified_;
  std::optional<Rectification> rectification_;
  Isometry3d T_left_rectified_ = Isometry3d::Identity();
  std::optional<VisualOdometry> odometry_;
  Image<std::uint8_t> left_, right_;
};

}  // namespace

bool is_placed_by_odometry(const StereoSource& source) {
  return dynamic_cast<const OdometrySource*>(&source) != nullptr;
}

Result<std::unique_ptr<StereoSource>> with_odometry(std::unique_ptr<StereoSource> pairs,
                                                    const OdometryOptions& options,
                                                    const Context& context) {
  auto source = std::make_unique<OdometrySource>(std::move(pairs), options, context);
  if (Status s = source->prepare(); !s) return forward(s);
  return source;
}

}  // namespace tread
