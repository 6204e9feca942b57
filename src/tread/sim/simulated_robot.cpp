#include "tread/sim/simulated_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tread/sim/moving_body.hpp"
#include "tread/sim/stereo_camera.hpp"

namespace tread {
namespace {

using internal::MovingBody;
using internal::StereoCamera;

constexpr double kSky_m = 60.0;  // as far as a receiver's view of the sky can be blocked

// A sensor that measures at times of its own, and the way of its samples.
template <class Sample>
using Channel = std::optional<SensorChannel<Sample>>;

template <class Sample>
void take(Channel<Sample>& channel, std::int64_t now_ns, std::vector<Sample>& samples) {
  if (channel) samples = channel->arrived(now_ns);
}

// The share of the sky that is open above a place: of rays spread evenly over the upper half.
double open_sky(const Scene& scene, const Eigen::Vector3d& place) {
  constexpr int kRays = 48;
  constexpr double kGolden = 2.399963229728653;
  int open = 0;
  for (int i = 0; i < kRays; ++i) {
    const double up = (i + 0.5) / kRays, out = std::sqrt(1.0 - up * up), turn = kGolden * i;
    const Eigen::Vector3d ray(out * std::cos(turn), out * std::sin(turn), up);
    if (!scene.blocked(place, place + kSky_m * ray)) ++open;
  }
  return static_cast<double>(open) / kRays;
}

// The robot as physics has it, standing at the start. An error names the course.
Result<MovingBody::Kind> place(const World& world, const RobotSetup& setup) {
  const auto named = [&](Error error) {
    error.where = fmt::format("{}: {}", world.name, error.where);
    return tl::unexpected<Error>(std::move(error));
  };
  if (setup.kind == RobotSetup::Kind::kRover) {
    auto body = RoverBody::place(world, setup.rover, world.start, setup.physics);
    if (!body) return named(body.error());
    return MovingBody::Kind(std::move(*body));
  }
  auto body = WalkerBody::place(world, setup.walker, world.start, setup.stand, setup.physics);
  if (!body) return named(body.error());
  return MovingBody::Kind(std::move(*body));
}

Result<MovingBody::Kind> make_body(const World& world, const RobotSetup& setup,
                                   const SimulationOptions& options) {
  auto body = place(world, setup);
  if (!body || !options.carried) return body;
  // One that is carried must have room where it starts, too.
  auto carried = CarriedBody::make(world, options.carry);
  if (!carried) return forward(carried);
  return MovingBody::Kind(std::move(*carried));
}

// Axes of the walker's trunk, in which physics has it, to those of its body on the ground.
Isometry3d T_base_body(const RobotSetup& setup, const SimulationOptions& options) {
  Isometry3d T = Isometry3d::Identity();
  if (!options.carried && setup.kind == RobotSetup::Kind::kWalker) {
    T.translation().z() = -stand_height_m(setup.walker);
  }
  return T;
}

bool finite(const RobotCommand& command) {
  const auto all = [](const auto& values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  };
  if (command.drive && !(std::isfinite(command.drive->speed_m_per_s) &&
                         std::isfinite(command.drive->yaw_rate_rad_per_s))) {
    return false;
  }
  if (command.joints &&
      !(all(command.joints->position_rad) && all(command.joints->velocity_rad_per_s) &&
        all(command.joints->torque_nm) && all(command.joints->stiffness_nm_per_rad) &&
        all(command.joints->damping_nm_s_per_rad))) {
    return false;
  }
  return !command.head ||
         (std::isfinite(command.head->pan_rad) && std::isfinite(command.head->tilt_rad));
}

}  // namespace

struct SimulatedRobot::Parts {
  // What a sensor is due to measure, in order of time within a step.
  struct Due {
    std::int64_t time_ns;
    std::function<void(std::int64_t)> measure;
  };

  Parts(const Course& the_course, const RobotSetup& the_setup, const SimulationOptions& the_options,
        MovingBody the_body, Scene the_scene, const Context& the_context)
      : course(the_course),
        setup(the_setup),
        options(the_options),
        context(the_context),
        body(std::move(the_body)),
        scene(std::move(the_scene)),
        head(setup.pan_tilt, setup.head_start),
        imu_sensor(setup.imu, Isometry3d::Identity(), options.seed),
        gnss_sensor(setup.gnss, pose_of(setup.antenna_mount).translation(), options.seed),
        wheel_sensor(setup.wheels, options.seed),
        leg_sensor(setup.legs, options.seed),
        bump_sensor(setup.bump) {
    if (setup.has_imu) open(imu, "imu", setup.imu.channel, imu_sensor.full_scale());
    if (setup.has_gnss) open(gnss, "gnss", setup.gnss.channel);
    if (setup.head_turns) open(head_states, "head", head_channel());
    if (body.rover() != nullptr) {
      open(wheels, "wheels", setup.wheels.channel, wheel_sensor.full_scale());
      open(bumps, "bump", setup.bump.channel);
    }
    if (body.walker() != nullptr) open(legs, "legs", setup.legs.channel, leg_sensor.full_scale());
    for (int i = 0; i < setup.heads; ++i) rigs.push_back(rig_of(setup, i));
  }

  // The unit tells where it is at each tick.
  [[nodiscard]] SensorChannelOptions head_channel() const {
    SensorChannelOptions channel;
    channel.rate_hz = setup.pan_tilt.rate_hz;
    channel.latency_s = 0.002;
    return channel;
  }

  template <class Sample>
  void open(Channel<Sample>& channel, const std::string& name, const SensorChannelOptions& how,
            Sample full_scale = {}) {
    channel.emplace(how, SensorChannelSetup{name, options.seed, course.faults, options.epoch_ns},
                    std::move(full_scale));
  }

  [[nodiscard]] Status make_cameras() {
    for (int i = 0; options.cameras && i < setup.heads; ++i) {
      auto camera = StereoCamera::make(
          rigs[static_cast<std::size_t>(i)], setup.camera,
          Random(options.seed).stream("camera").stream(static_cast<std::uint64_t>(i)), context);
      if (!camera) return forward(camera);
      cameras.push_back(std::move(*camera));
      Channel<StereoFrame> channel;
      open(channel, fmt::format("camera{}", i), setup.camera.channel);
      frames.push_back(std::move(*channel));
    }
    return {};
  }

  // All that is due within the step behind, sorted; sensors of the same time in the order below.
  [[nodiscard]] std::vector<Due> due_now() {
    std::vector<Due> all;
    const auto ask = [&](auto& channel, const auto& measure) {
      if (!channel) return;
      while (const auto time = channel->due(body.time_ns())) all.push_back({*time, measure});
    };
    ask(imu, [this](std::int64_t t) { imu->push(t, imu_sensor.measure(t, felt(t))); });
    ask(wheels,
        [this](std::int64_t t) { wheels->push(t, wheel_sensor.measure(body.rover()->wheels())); });
    ask(legs,
        [this](std::int64_t t) { legs->push(t, leg_sensor.measure(t, body.walker()->legs())); });
    ask(bumps, [this](std::int64_t t) {
      if (const auto event = bump_sensor.look(t, body.rover()->bumper_pressed()))
        bumps->push(t, *event);
    });
    ask(head_states, [this](std::int64_t t) { head_states->push(t, head.measure()); });
    ask(gnss, [this](std::int64_t t) { measure_gnss(t); });
    for (std::size_t i = 0; i < frames.size(); ++i) {
      while (const auto time = frames[i].due(body.time_ns())) {
        all.push_back({*time, [this, i](std::int64_t t) { take_frame(i, t); }});
      }
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Due& a, const Due& b) { return a.time_ns < b.time_ns; });
    return all;
  }

  // The motion at the IMU. Physics has jolts that are shorter than a sample: accelerations and
  // rates are then the means since the last one, as a unit with a filter has them, so that they sum
  // up to the motion.
  [[nodiscard]] BodyMotion felt(std::int64_t t) {
    BodyMotion motion = at_mount(body.motion_at(t), pose_of(setup.imu_mount));
    if (body.carried() != nullptr) return motion;
    const BodyMotion before = std::exchange(felt_last, motion).value_or(motion);
    const double passed_s = 1e-9 * static_cast<double>(t - std::exchange(felt_ns, t));
    if (passed_s <= 0.0) return motion;
    motion.acceleration_m_per_s2 = (motion.velocity_m_per_s - before.velocity_m_per_s) / passed_s;
    motion.rate_rad_per_s =
        so3_log(before.T_world_body.linear().transpose() * motion.T_world_body.linear()) / passed_s;
    return motion;
  }

  void measure_gnss(std::int64_t t) {
    const Isometry3d T = body.motion_at(t).T_world_body;
    scene.set_time(1e-9 * static_cast<double>(t));
    const Eigen::Vector3d antenna = T * pose_of(setup.antenna_mount).translation();
    if (const auto fix = gnss_sensor.measure(t, T, open_sky(scene, antenna))) gnss->push(t, *fix);
  }

  void take_frame(std::size_t i, std::int64_t t) {
    const int number = static_cast<int>(i);
    const HeadCommand angles{head.pan_rad(), head.tilt_rad()};
    const HeadCommand rates{head.pan_rate_rad_per_s(), head.tilt_rate_rad_per_s()};
    const BodyMotion motion = body.motion_at(t);
    const auto T_world_left = [&](double later_s) -> Isometry3d {
      const HeadCommand then{angles.pan_rad + later_s * rates.pan_rad,
                             angles.tilt_rad + later_s * rates.tilt_rad};
      return pose_after(motion, later_s) * T_body_left(setup, number, then);
    };
    scene.set_time(1e-9 * static_cast<double>(t));
    FrameTruth truth{number, options.epoch_ns + t, T_world_left(0.0), {}};
    auto frame = cameras[i].take(scene, T_world_left, truth.depth);
    if (!frame) {
      if (!failure) failure = frame.error();
      return;
    }
    frame->name = fmt::format("{:06}", frame_numbers[i]++);
    if (options.frames_know_pose) frame->T_world_left = truth.T_world_left;
    if (listener) listener(std::move(truth));
    frames[i].push(t, std::move(*frame));
  }

  Course course;
  RobotSetup setup;
  SimulationOptions options;
  Context context;
  MovingBody body;
  Scene scene;
  PanTilt head;
  std::vector<StereoRig> rigs;
  std::vector<StereoCamera> cameras;
  std::array<int, 2> frame_numbers{};
  std::vector<SensorChannel<StereoFrame>> frames;
  ImuSensor imu_sensor;  // in its own axes: felt() brings the motion there
  std::optional<BodyMotion> felt_last;
  std::int64_t felt_ns = 0;
  GnssSensor gnss_sensor;
  WheelSensor wheel_sensor;
  LegSensor leg_sensor;
  BumpSensor bump_sensor;
  Channel<ImuSample> imu;
  Channel<GnssFix> gnss;
  Channel<WheelSample> wheels;
  Channel<LegSample> legs;
  Channel<HeadState> head_states;
  Channel<BumpEvent> bumps;
  std::function<void(FrameTruth&&)> listener;
  std::optional<Error> failure;
  std::int64_t asked_ns = 0;  // until when advance() was called for
};

SimulatedRobot::SimulatedRobot(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
SimulatedRobot::~SimulatedRobot() = default;

Result<std::unique_ptr<SimulatedRobot>> SimulatedRobot::make(const Course& course,
                                                             const RobotSetup& setup,
                                                             const SimulationOptions& options,
                                                             const Context& context) {
  if (Status s = check_options(setup); !s) return forward(s);
  auto scene = Scene::make(course.world);
  if (!scene) return forward(scene);
  auto kind = make_body(*course.world, setup, options);
  if (!kind) return forward(kind);
  auto parts = std::make_unique<Parts>(course, setup, options,
                                       MovingBody(std::move(*kind), T_base_body(setup, options)),
                                       std::move(*scene), context);
  if (Status s = parts->make_cameras(); !s) return forward(s);
  return std::unique_ptr<SimulatedRobot>(new SimulatedRobot(std::move(parts)));
}

const std::vector<StereoRig>& SimulatedRobot::heads() const {
  return parts_->rigs;
}

Status SimulatedRobot::command(const RobotCommand& command) {
  const auto refuse = [](const std::string& field, const std::string& what) {
    return fail(ErrorCode::kBadArgument, what, "command." + field, "Send what this robot has");
  };
  if (!finite(command)) return refuse("value", "a value is not finite");
  Parts& parts = *parts_;
  if (command.drive && parts.body.rover() == nullptr)
    return refuse("drive", "it has no wheels to drive");
  if (command.joints && parts.body.walker() == nullptr)
    return refuse("joints", "it has no legs to move");
  if (command.head && !parts.setup.head_turns) return refuse("head", "its head does not turn");
  if (command.drive) {
    if (Status s = parts.body.rover()->command(*command.drive); !s) return s;
  }
  if (command.joints) {
    if (Status s = parts.body.walker()->command(*command.joints); !s) return s;
  }
  if (command.head) parts.head.command(*command.head);
  return {};
}

Result<SensorBatch> SimulatedRobot::advance(std::int64_t duration_ns) {
  Parts& parts = *parts_;
  parts.asked_ns += std::max<std::int64_t>(duration_ns, 0);
  const ScopedTimer timer(parts.context, "sim");
  while (true) {
    for (const Parts::Due& due : parts.due_now()) {
      parts.head.advance(due.time_ns);
      due.measure(due.time_ns);
    }
    if (parts.failure) return tl::unexpected<Error>(*parts.failure);
    if (parts.body.time_ns() >= parts.asked_ns) break;
    const ScopedTimer physics(parts.context, "sim/physics");
    if (Status s = parts.body.step(); !s) return forward(s);
  }
  const std::int64_t now = parts.body.time_ns();
  parts.head.advance(now);
  SensorBatch batch;
  batch.now_ns = parts.options.epoch_ns + now;
  take(parts.imu, now, batch.imu);
  take(parts.gnss, now, batch.gnss);
  take(parts.wheels, now, batch.wheels);
  take(parts.legs, now, batch.legs);
  take(parts.head_states, now, batch.head);
  take(parts.bumps, now, batch.bumps);
  for (std::size_t i = 0; i < parts.frames.size(); ++i) {
    for (StereoFrame& frame : parts.frames[i].arrived(now)) {
      batch.frames.push_back({static_cast<int>(i), std::move(frame)});
    }
  }
  return batch;
}

std::int64_t SimulatedRobot::time_ns() const {
  return parts_->body.time_ns();
}
const BodyMotion& SimulatedRobot::motion() const {
  return parts_->body.motion();
}
HeadCommand SimulatedRobot::head() const {
  return {parts_->head.pan_rad(), parts_->head.tilt_rad()};
}
const Eigen::Vector3d& SimulatedRobot::gyro_bias_rad_per_s() const {
  return parts_->imu_sensor.gyro_bias_rad_per_s();
}
const Eigen::Vector3d& SimulatedRobot::accel_bias_m_per_s2() const {
  return parts_->imu_sensor.accel_bias_m_per_s2();
}
const World& SimulatedRobot::world() const {
  return *parts_->course.world;
}
std::optional<double> SimulatedRobot::duration_s() const {
  const CarriedBody* carried = parts_->body.carried();
  return carried != nullptr ? std::optional(carried->duration_s()) : std::nullopt;
}
void SimulatedRobot::on_frame(std::function<void(FrameTruth&&)> listener) {
  parts_->listener = std::move(listener);
}

}  // namespace tread
