#include "tread/sim/robot_setup.hpp"

#include <cmath>
#include <numbers>

namespace tread {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

const StereoHeadOptions& head_of(const RobotSetup& setup, int head) {
  return head == 0 ? setup.head : setup.second_head;
}

bool within_limits(const RobotSetup& setup) {
  const PanTilt unit(setup.pan_tilt, setup.head_start);
  return std::abs(unit.pan_rad() - setup.head_start.pan_rad) < 1e-9 &&
         std::abs(unit.tilt_rad() - setup.head_start.tilt_rad) < 1e-9;
}

Isometry3d turned(double yaw_rad, double pitch_rad) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = rotation_from_yaw_pitch_roll(yaw_rad, pitch_rad, 0.0);
  return T;
}

}  // namespace

OptionSet describe(MountOptions& options) {
  OptionSet set;
  set.add("forward_m", options.forward_m, "from the origin of the body", -10.0, 10.0);
  set.add("left_m", options.left_m, "from the origin of the body", -10.0, 10.0);
  set.add("up_m", options.up_m, "from the origin of the body", -10.0, 10.0);
  set.add("yaw_rad", options.yaw_rad, "looks to the left by", -4.0, 4.0);
  set.add("pitch_rad", options.pitch_rad, "looks down by", -1.6, 1.6);
  return set;
}

OptionSet describe(StereoHeadOptions& options) {
  OptionSet set;
  set.add("width_px", options.width_px, "width of the images", 16, 4096);
  set.add("height_px", options.height_px, "height of the images", 16, 4096);
  set.add("focal_px", options.focal_px, "focal length", 1.0, 1e5);
  set.add("baseline_m", options.baseline_m, "between the two cameras", 0.001, 10.0);
  using Lens = StereoHeadOptions::Lens;
  set.add_choice("lens", options.lens, "pinhole: the images come rectified",
                 {{"pinhole", Lens::kPinhole},
                  {"brown", Lens::kBrown},
                  {"kannala_brandt", Lens::kKannalaBrandt}});
  set.add("k1", options.k1, "distortion, unless pinhole: OpenCV's k1 of either lens", -1.0, 1.0);
  set.add("k2", options.k2, "OpenCV's k2", -1.0, 1.0);
  set.add("k3", options.k3, "OpenCV's p1 of brown, k3 of kannala_brandt", -1.0, 1.0);
  set.add("k4", options.k4, "OpenCV's p2 of brown, k4 of kannala_brandt", -1.0, 1.0);
  set.add_group("mount", describe(options.mount));
  return set;
}

OptionSet describe(CameraSetup& options) {
  OptionSet set;
  set.add_group("channel", describe(options.channel));
  set.add("readout_s", options.readout_s, "from the first row to the last; 0: global shutter", 0.0,
          1.0);
  set.add_group("render", describe(options.render));
  set.add_group("sensor", describe(options.sensor));
  return set;
}

OptionSet describe(RobotSetup& setup) {
  OptionSet set;
  set.add_choice("kind", setup.kind, "which body it has",
                 {{"rover", RobotSetup::Kind::kRover}, {"walker", RobotSetup::Kind::kWalker}});
  set.add_group("rover", describe(setup.rover));
  set.add_group("walker", describe(setup.walker));
  set.add_group("stand", describe(setup.stand));
  set.add_group("physics", describe(setup.physics));
  set.add("heads", setup.heads, "stereo heads", 1, 2);
  set.add_group("head", describe(setup.head));
  set.add_group("second_head", describe(setup.second_head));
  set.add("head_turns", setup.head_turns, "the first head is on a pan-tilt unit");
  set.add_group("pan_tilt", describe(setup.pan_tilt));
  set.add("head_pan_rad", setup.head_start.pan_rad, "where the unit looks at the start", -4.0, 4.0);
  set.add("head_tilt_rad", setup.head_start.tilt_rad, "where the unit looks at the start", -1.6,
          1.6);
  set.require({"head_pan_rad", "head_tilt_rad"}, "the unit must be able to look there",
              [&setup] { return !setup.head_turns || within_limits(setup); });
  set.add_group("camera", describe(setup.camera));
  set.add("has_imu", setup.has_imu, "it has an IMU");
  set.add_group("imu", describe(setup.imu));
  set.add_group("imu_mount", describe(setup.imu_mount));
  set.add("has_gnss", setup.has_gnss, "it has a satellite receiver");
  set.add_group("gnss", describe(setup.gnss));
  set.add_group("antenna_mount", describe(setup.antenna_mount));
  set.add_group("wheels", describe(setup.wheels));
  set.add_group("legs", describe(setup.legs));
  set.add_group("bump", describe(setup.bump));
  return set;
}

// LAGR: two Bumblebees on a mast, 12 cm and about 70 degrees each; a quarter of the images sees the
// same ground.
RobotSetup rover_setup() {
  RobotSetup setup;
  setup.kind = RobotSetup::Kind::kRover;
  setup.heads = 2;
  setup.head.focal_px = 490.0;
  setup.head.mount = {-0.10, 0.10, 0.95, 25.0 * kDegree, 20.0 * kDegree};
  setup.second_head = setup.head;
  setup.second_head.mount.left_m = -setup.head.mount.left_m;
  setup.second_head.mount.yaw_rad = -setup.head.mount.yaw_rad;
  setup.imu_mount = {-0.20, 0.0, 0.40, 0.0, 0.0};
  setup.antenna_mount = {-0.40, 0.0, 1.00, 0.0, 0.0};
  return setup;
}

// The camera of paper Q on its unit, 1 m above the ground, looking 55 degrees down.
RobotSetup walker_setup() {
  RobotSetup setup;
  setup.kind = RobotSetup::Kind::kWalker;
  setup.head.mount = {0.60, 0.0, 1.00, 0.0, 15.0 * kDegree};
  setup.head_turns = true;
  setup.head_start.tilt_rad = 40.0 * kDegree;
  setup.imu_mount = {0.0, 0.0, 0.60, 0.0, 0.0};
  setup.antenna_mount = {-0.30, 0.0, 0.75, 0.0, 0.0};
  setup.has_gnss = false;
  return setup;
}

Isometry3d pose_of(const MountOptions& options) {
  Isometry3d T = turned(options.yaw_rad, options.pitch_rad);
  T.translation() << options.forward_m, options.left_m, options.up_m;
  return T;
}

double stand_height_m(const WalkerModelOptions& options) {
  const double foot = foot_position(options, 0, joints_of_leg(home_joints(), 0)).z();
  return options.foot_radius_m - foot;
}

Isometry3d T_body_left(const RobotSetup& setup, int head, const HeadCommand& angles) {
  const StereoHeadOptions& options = head_of(setup, head);
  Isometry3d T = pose_of(options.mount);
  if (head == 0 && setup.head_turns) T = T * turned(angles.pan_rad, angles.tilt_rad);
  T.linear() = T.linear() * R_body_optical();
  T.translation() -= T.linear() * Eigen::Vector3d(0.5 * options.baseline_m, 0.0, 0.0);
  return T;
}

StereoRig rig_of(const RobotSetup& setup, int head) {
  const StereoHeadOptions& options = head_of(setup, head);
  StereoRig rig;
  rig.name = setup.heads > 1 ? (head == 0 ? "head 0" : "head 1") : "head";
  rig.size = {options.width_px, options.height_px};
  const PinholeCamera pinhole{options.focal_px, options.focal_px, 0.5 * (options.width_px - 1),
                              0.5 * (options.height_px - 1), 0.0};
  rig.rectified = options.lens == StereoHeadOptions::Lens::kPinhole;
  rig.left = pinhole;
  if (options.lens == StereoHeadOptions::Lens::kBrown) {
    BrownCamera brown;
    brown.pinhole = pinhole;
    brown.K = {options.k1, options.k2, 0.0, 0.0, 0.0};
    brown.P = {options.k4, options.k3, 0.0, 0.0, 0.0};
    rig.left = brown;
  } else if (options.lens == StereoHeadOptions::Lens::kKannalaBrandt) {
    rig.left = KannalaBrandtCamera{pinhole.fx,
                                   pinhole.fy,
                                   pinhole.cx,
                                   pinhole.cy,
                                   {options.k1, options.k2, options.k3, options.k4}};
  }
  rig.right = rig.left;
  rig.T_left_right.translation().x() = options.baseline_m;
  const Isometry3d T = T_body_left(setup, head, setup.head_start);
  rig.mount = CameraMount{T, false};
  if (setup.has_imu) rig.imu = imu_of(setup.imu, pose_of(setup.imu_mount).inverse() * T);
  return rig;
}

}  // namespace tread
