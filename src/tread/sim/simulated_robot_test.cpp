#include "tread/sim/simulated_robot.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>

#include "tread/sim/named_courses.hpp"
#include "tread/sim/route_driver.hpp"
#include "tread/sim/rover_body.hpp"
#include "tread/sim/simulated_source.hpp"
#include "tread/sim/walker_body.hpp"

namespace tread {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

Course course_of(const std::string& body) {
  const auto course =
      parse_course("tread_course: 1\nsize_m: [16, 8]\norigin_m: [-3, -4]\n" + body, "made.yaml");
  EXPECT_TRUE(course) << course.error().message();
  return *course;
}

RobotSetup small(RobotSetup setup) {
  for (StereoHeadOptions* head : {&setup.head, &setup.second_head}) {
    head->width_px = 96;
    head->height_px = 72;
    head->focal_px = 60.0;
  }
  return setup;
}

std::unique_ptr<SimulatedRobot> robot_on(const Course& course, const RobotSetup& setup,
                                         const SimulationOptions& options = {}, int threads = 1) {
  auto robot = SimulatedRobot::make(course, setup, options, Context{threads, nullptr});
  EXPECT_TRUE(robot) << robot.error().message();
  return robot ? std::move(*robot) : nullptr;
}

SensorBatch run(SimulatedRobot& robot, double duration_s, std::int64_t step_ns = 50'000'000) {
  SensorBatch all;
  const auto until = robot.time_ns() + static_cast<std::int64_t>(duration_s * 1e9);
  while (robot.time_ns() < until) {
    auto batch = robot.advance(std::min(step_ns, until - robot.time_ns()));
    EXPECT_TRUE(batch) << batch.error().message();
    if (!batch) break;
    all.now_ns = batch->now_ns;
    const auto append = [](auto& to, auto& from) {
      for (auto& sample : from) to.push_back(std::move(sample));
    };
    append(all.frames, batch->frames);
    append(all.imu, batch->imu);
    append(all.gnss, batch->gnss);
    append(all.wheels, batch->wheels);
    append(all.legs, batch->legs);
    append(all.head, batch->head);
    append(all.bumps, batch->bumps);
  }
  return all;
}

// All bytes of what a robot sent, in one number.
std::uint64_t hash_of(const SensorBatch& batch) {
  std::uint64_t h = 1469598103934665603ULL;
  const auto add = [&](std::uint64_t v) { h = (h ^ v) * 1099511628211ULL; };
  const auto number = [&](double v) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &v, sizeof bits);
    add(bits);
  };
  for (const HeadFrame& f : batch.frames) {
    add(static_cast<std::uint64_t>(f.frame.stamp_ns));
    for (const auto* image : {&f.frame.left, &f.frame.right}) {
      for (int y = 0; y < image->height; ++y) {
        for (int x = 0; x < image->width; ++x) add((*image)(x, y));
      }
    }
  }
  for (const ImuSample& s : batch.imu) {
    add(static_cast<std::uint64_t>(s.stamp_ns));
    for (int i = 0; i < 3; ++i) {
      number(s.gyro_rad_per_s(i));
      number(s.accel_m_per_s2(i));
    }
  }
  for (const GnssFix& s : batch.gnss) {
    add(static_cast<std::uint64_t>(s.stamp_ns));
    for (int i = 0; i < 3; ++i) number(s.position_m(i));
  }
  for (const WheelSample& s : batch.wheels) {
    add(static_cast<std::uint64_t>(s.stamp_ns));
    for (const double v : {s.left_rad, s.right_rad, s.left_current_a, s.right_current_a}) number(v);
  }
  for (const LegSample& s : batch.legs) {
    for (int i = 0; i < kLegJoints; ++i) {
      const auto joint = static_cast<std::size_t>(i);
      for (const double v :
           {s.position_rad[joint], s.velocity_rad_per_s[joint], s.torque_nm[joint]}) {
        number(v);
      }
    }
  }
  for (const HeadState& s : batch.head) number(s.pan_rad);
  for (const BumpEvent& s : batch.bumps)
    add(2 * static_cast<std::uint64_t>(s.stamp_ns) + s.pressed);
  return h;
}

TEST(SimulatedRobot, SameBytesForAnyThreadsAndStepsAndOtherBytesForAnotherSeed) {
  const Course course = course_of(
      "ground: {relief: [{noise: {rms_m: 0.02, longest_m: 3}}]}\n"
      "objects: [{rocks: {count: 20}}, {person: {path_m: [[3, -2], [3, 2]]}}]\n");
  const auto bytes = [&](std::uint64_t seed, int threads, std::int64_t step_ns) {
    SimulationOptions options;
    options.seed = seed;
    const auto robot = robot_on(course, small(rover_setup()), options, threads);
    EXPECT_TRUE(robot->command({.drive = DriveCommand{0.6, 0.2}}));
    return hash_of(run(*robot, 1.2, step_ns));
  };
  const std::uint64_t once = bytes(1, 1, 50'000'000);
  EXPECT_EQ(once, bytes(1, 2, 50'000'000));
  EXPECT_EQ(once, bytes(1, 1, 7'000'000));
  EXPECT_NE(once, bytes(2, 1, 50'000'000));
}

// A second in the meadow is what it has always been, but for what compilers and processors round
// differently: where the robot gets, and the mean grey of each twelfth of its first picture.
TEST(SimulatedRobot, ASecondInTheMeadowIsWhatItHasAlwaysBeen) {
  const auto course = find_course("meadow");
  ASSERT_TRUE(course) << course.error().message();
  RobotSetup setup = rover_setup();
  setup.heads = 1;
  setup.head.width_px = 160;
  setup.head.height_px = 120;
  setup.head.focal_px = 120.0;
  const auto robot = robot_on(*course, setup);
  ASSERT_TRUE(robot->command({.drive = DriveCommand{0.6, 0.1}}));
  const SensorBatch batch = run(*robot, 1.0);
  const Eigen::Vector3d p = robot->motion().T_world_body.translation();
  EXPECT_LT((p - Eigen::Vector3d(0.486282, 0.010005, 0.207854)).norm(), 0.003) << p.transpose();
  EXPECT_NEAR(batch.wheels.back().left_rad, 2.991, 0.02);
  EXPECT_NEAR(batch.wheels.back().right_rad, 3.215, 0.02);
  const std::array<double, 12> greys{135.54, 125.47, 119.38, 111.82, 106.70, 103.98,
                                     108.85, 101.06, 101.19, 102.39, 101.46, 93.54};
  const Image<std::uint8_t>& picture = batch.frames.front().frame.left;
  for (int block = 0; block < 12; ++block) {
    double sum = 0.0;
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 40; ++x) sum += picture(40 * (block % 4) + x, 40 * (block / 4) + y);
    }
    EXPECT_NEAR(sum / 1600.0, greys[static_cast<std::size_t>(block)], 0.7) << block;
  }
}

TEST(SimulatedRobot, BothRobotsCanStartOnEveryShippedCourse) {
  for (const std::string& name : course_names()) {
    const auto course = find_course(name);
    ASSERT_TRUE(course) << course.error().message();
    const World& world = *course->world;
    const auto rover = RoverBody::place(world, {}, world.start);
    EXPECT_TRUE(rover) << name << ": " << rover.error().message();
    const auto walker = WalkerBody::place(world, {}, world.start);
    EXPECT_TRUE(walker) << name << ": " << walker.error().message();
  }
}

TEST(SimulatedRobot, SensorsComeAtTheirRates) {
  const auto robot = robot_on(course_of(""), small(rover_setup()));
  const SensorBatch batch = run(*robot, 3.0);
  EXPECT_NEAR(static_cast<double>(batch.imu.size()), 600.0, 2.0);
  EXPECT_NEAR(static_cast<double>(batch.wheels.size()), 150.0, 2.0);
  EXPECT_NEAR(static_cast<double>(batch.frames.size()), 60.0, 2.0);  // of two heads
  EXPECT_NEAR(static_cast<double>(batch.gnss.size()), 3.0, 1.0);
  EXPECT_TRUE(batch.legs.empty());
  EXPECT_TRUE(batch.head.empty());
  for (const HeadFrame& frame : batch.frames) {
    EXPECT_FALSE(frame.frame.T_world_left) << "hardware does not know";
  }
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : batch.imu) force += sample.accel_m_per_s2;
  EXPECT_NEAR((force / static_cast<double>(batch.imu.size())).norm(), 9.81, 0.3);
}

TEST(SimulatedRobot, DrivesAlongTheRouteAndItsSensorsAgree) {
  const Course course = course_of("ground: {surface: concrete}\nroute_m: [[4, 0], [7, 2]]\n");
  SimulationOptions options;
  options.cameras = false;
  const auto robot = robot_on(course, rover_setup(), options);
  RouteDriver driver(robot->world(), {});
  SensorBatch last;
  double turned_rad = 0.0;
  while (!driver.done() && robot->time_ns() < 60 * kSecond) {
    const double now_s = 1e-9 * static_cast<double>(robot->time_ns());
    ASSERT_TRUE(robot->command({.drive = driver.drive(now_s, robot->motion().T_world_body)}));
    auto batch = robot->advance(20'000'000);
    ASSERT_TRUE(batch);
    for (const ImuSample& sample : batch->imu) turned_rad += 0.005 * sample.gyro_rad_per_s.z();
    if (!batch->wheels.empty()) last = std::move(*batch);
  }
  EXPECT_TRUE(driver.arrived());
  const Eigen::Vector3d end = robot->motion().T_world_body.translation();
  EXPECT_NEAR((end.head<2>() - Eigen::Vector2d(7, 2)).norm(), 0.0, 0.4);
  const double way = 0.5 * (last.wheels.back().left_rad + last.wheels.back().right_rad) *
                     rover_setup().rover.wheel_radius_m;
  EXPECT_NEAR(way, 4.0 + std::sqrt(13.0), 0.5);
  const Eigen::Vector3d ahead = robot->motion().T_world_body.linear().col(0);
  EXPECT_NEAR(turned_rad, std::atan2(ahead.y(), ahead.x()), 0.3);  // bias 0.005 rad/s and scale
}

TEST(SimulatedRobot, BumpsIntoABox) {
  const Course course = course_of("objects: [{box: {at_m: [1.5, 0], size_m: [0.4, 2, 0.5]}}]\n");
  SimulationOptions options;
  options.cameras = false;
  const auto robot = robot_on(course, rover_setup(), options);
  ASSERT_TRUE(robot->command({.drive = DriveCommand{0.5, 0.0}}));
  const SensorBatch batch = run(*robot, 5.0);
  ASSERT_FALSE(batch.bumps.empty());
  EXPECT_TRUE(batch.bumps.front().pressed);
  EXPECT_LT(robot->motion().T_world_body.translation().x(), 1.3);
}

TEST(SimulatedRobot, TheWalkerStandsAndItsHeadTurns) {
  const auto robot = robot_on(course_of(""), small(walker_setup()));
  const double tilt = robot->head().tilt_rad;
  EXPECT_NEAR(tilt, walker_setup().head_start.tilt_rad, 1e-9);
  ASSERT_TRUE(robot->command({.head = HeadCommand{0.5, 0.1}}));
  const SensorBatch batch = run(*robot, 1.0);
  EXPECT_NEAR(robot->head().pan_rad, 0.5, 0.01);
  ASSERT_FALSE(batch.legs.empty());
  ASSERT_FALSE(batch.head.empty());
  EXPECT_NEAR(batch.head.back().pan_rad, 0.5, 0.01);
  double weight = 0.0;
  for (const Eigen::Vector3d& force : batch.legs.back().foot_force_n) weight += force.z();
  EXPECT_NEAR(weight, 9.81 * walker_mass_kg({}), 60.0);  // each foot is some newtons off
  // The body is on the ground, whatever is measured where inside.
  EXPECT_NEAR(robot->motion().T_world_body.translation().z(), 0.0, 0.02);
}

// What the camera sees is what the rig and the truth say it must.
TEST(SimulatedRobot, DepthAndPoseOfAFrameAreThoseOfTheGround) {
  RobotSetup setup = small(rover_setup());
  SimulationOptions options;
  options.carried = true;
  const auto robot = robot_on(course_of("route_m: [[4, 0]]\n"), setup, options);
  int checked = 0;
  robot->on_frame([&](FrameTruth&& truth) {
    const StereoRig& rig = robot->heads()[static_cast<std::size_t>(truth.head)];
    const PinholeCamera camera = pinhole_of(rig.left);
    for (int v = 40; v < 72; v += 8) {
      for (int u = 4; u < 96; u += 8) {
        const double z = static_cast<double>(truth.depth(u, v));
        if (std::isnan(z)) continue;
        const Eigen::Vector3d p((u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z,
                                z);
        EXPECT_NEAR((truth.T_world_left * p).z(), 0.0, 1e-5);
        ++checked;
      }
    }
  });
  (void)run(*robot, 2.0);
  EXPECT_GT(checked, 500);
}

TEST(SimulatedRobot, FaultsOfTheCourseAreCarriedOut) {
  const Course course = course_of(
      "faults:\n  - {sensor: imu, kind: dead, from_s: 1, until_s: 2}\n"
      "  - {sensor: camera0, kind: frozen, from_s: 0.45}\n");
  const auto robot = robot_on(course, small(rover_setup()));
  const SensorBatch batch = run(*robot, 3.0);
  for (const ImuSample& sample : batch.imu) {
    const double t = 1e-9 * static_cast<double>(sample.stamp_ns - SimulationOptions{}.epoch_ns);
    EXPECT_TRUE(t < 1.0 || t >= 2.0) << t;
  }
  std::int64_t last = 0;
  for (const HeadFrame& frame : batch.frames) {
    if (frame.head == 0) last = frame.frame.stamp_ns;
  }
  EXPECT_EQ(last - SimulationOptions{}.epoch_ns, 4 * kSecond / 10);
}

TEST(SimulatedRobot, RefusesWhatItCannotDo) {
  const auto robot = robot_on(course_of(""), small(rover_setup()));
  EXPECT_FALSE(robot->command({.joints = JointCommand{}}));
  EXPECT_FALSE(robot->command({.head = HeadCommand{}}));
  EXPECT_FALSE(robot->command({.drive = DriveCommand{std::nan(""), 0.0}}));
  const auto message = [](const std::string& body, RobotSetup setup) {
    const auto made = SimulatedRobot::make(course_of(body), setup, {});
    return made ? std::string("made") : made.error().message();
  };
  RobotSetup blind = rover_setup();
  blind.head.focal_px = 0.0;
  EXPECT_NE(message("", blind).find("head.focal_px"), std::string::npos);
  const std::string rock =
      message("objects: [{rock: {at_m: [-0.3, 0], size_m: 0.8}}]\n", rover_setup());
  EXPECT_NE(rock.find("objects[0].rock (line 4)"), std::string::npos) << rock;
  RobotSetup up = walker_setup();
  up.head_start.tilt_rad = 1.4;
  EXPECT_NE(message("", up).find("head_tilt_rad"), std::string::npos);
  // Carried or not: it must have room.
  SimulationOptions carried;
  carried.carried = true;
  EXPECT_FALSE(SimulatedRobot::make(
      course_of("route_m: [[3, 0]]\nobjects: [{rock: {at_m: [-0.3, 0], size_m: 0.8}}]\n"),
      rover_setup(), carried));
}

TEST(SimulatedSource, ASilentImuIsNotWaitedForAndRepeatedFramesAreLeftOut) {
  const Course course = course_of(
      "route_m: [[1.5, 0]]\nfaults:\n  - {sensor: imu, kind: dead, from_s: 1}\n"
      "  - {sensor: camera0, kind: frozen, from_s: 2.05, until_s: 2.55}\n");
  auto source = open_simulated_source(course, small(rover_setup()), {});
  ASSERT_TRUE(source) << source.error().message();
  std::int64_t last = 0;
  int frames = 0;
  for (auto frame = (*source)->next(); frame && *frame; frame = (*source)->next()) {
    EXPECT_GT((*frame)->stamp_ns, last);
    last = (*frame)->stamp_ns;
    ++frames;
  }
  EXPECT_EQ((*source)->problems().size(), 5U);
  EXPECT_GT(frames, 30);
}

TEST(SimulatedSource, GivesFramesWithPosesAndImu) {
  const Course course = course_of("route_m: [[1.5, 0]]\n");
  auto source = open_simulated_source(course, small(rover_setup()), {});
  ASSERT_TRUE(source) << source.error().message();
  int frames = 0;
  std::int64_t last = 0;
  while (true) {
    auto frame = (*source)->next();
    ASSERT_TRUE(frame) << frame.error().message();
    if (!*frame) break;
    ++frames;
    EXPECT_GT((*frame)->stamp_ns, last);
    ASSERT_TRUE((*frame)->T_world_left);
    for (const ImuSample& sample : (*frame)->imu) {
      EXPECT_GT(sample.stamp_ns, last);
      EXPECT_LE(sample.stamp_ns, (*frame)->stamp_ns);
    }
    if (frames > 1) {
      EXPECT_NEAR(static_cast<double>((*frame)->imu.size()), 20.0, 1.0);
    }
    last = (*frame)->stamp_ns;
  }
  EXPECT_EQ(frames, (*source)->frame_count());
}

}  // namespace
}  // namespace tread
