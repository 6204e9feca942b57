// A world with a robot in it as MuJoCo computes it (Todorov, Erez, Tassa 2012): the model, its
// state, and what touches what. Time goes in steps; between them everything stands still. Same
// world, same commands, same bits.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tread/core/options.hpp"
#include "tread/sim/world.hpp"
#include "tread/sim/world_mjcf.hpp"

// MuJoCo's own, seen in sources only.
struct mjModel_;
struct mjData_;

namespace tread {

// A walker that stands on steep, hard ground must not creep. MuJoCo's friction is soft: at a slope
// of 15 degrees feet creep 0.07 mm/s with `sticking` 100 alone, and not 1 um/s with the passes over
// friction that follow, which cost a tenth of the time.
struct PhysicsOptions {
  double step_s = 0.002;
  double contact_s = 0.01;    // in which a contact that is pressed in springs back
  double sticking = 100.0;    // how much stiffer contacts are along the ground than across it
  int noslip_iterations = 3;  // passes that take away what friction still creeps
  [[nodiscard]] bool operator==(const PhysicsOptions&) const = default;
};
[[nodiscard]] OptionSet describe(PhysicsOptions& options);

// Where the robot touches something that is not itself.
struct Touch {
  int part = 0;                                       // of the robot
  int other = 0;                                      // what it touches
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();  // world axes
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // out of the other
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // on the robot, world axes
  double depth_m = 0.0;                               // how far they are pressed into each other
};

// A part of the robot that it stands or rolls on: it holds as well as what is under it allows.
struct Tread {
  int part = 0;
  Footing footing;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // of all that it touches, world axes
  double load_n = 0.0;                                // of that, across what it touches
};

class PhysicsModel {
 public:
  // `treads` are geoms of the robot. The world must outlive the model. An error if the world cannot
  // be made or MuJoCo refuses it, naming the thing.
  [[nodiscard]] static Result<PhysicsModel> make(const World& world, const RobotMjcf& robot,
                                                 const PhysicsOptions& options,
                                                 const std::vector<std::string>& treads);
  PhysicsModel(PhysicsModel&&) noexcept;
  PhysicsModel& operator=(PhysicsModel&&) noexcept;
  ~PhysicsModel();

  // One step of time in two halves, between which forces may be put on what is known by then: where
  // everything is and how fast it moves. An error if the motion has no finite answer; the model is
  // of no use then.
  [[nodiscard]] Status begin_step();
  [[nodiscard]] Status end_step();
  // Finds what touches what after the state was set from outside; no time goes by.
  [[nodiscard]] Status refresh();
  [[nodiscard]] double step_s() const { return options_.step_s; }
  [[nodiscard]] double time_s() const;
  // It is now this time: people are where they are then.
  [[nodiscard]] Status set_time(double time_s);

  // Puts the robot's body, the first that is free, at rest to a pose; its joints stay.
  [[nodiscard]] Status set_robot_pose(const Isometry3d& T_world_body);

  [[nodiscard]] std::vector<Touch> touches() const;
  [[nodiscard]] const std::vector<Tread>& treads() const { return treads_; }
  // Of what is touched.
  [[nodiscard]] Footing footing(const Touch& touch) const;
  // "the ground", "pallets[1]", "the rover's bumper"
  // "the ground", "pallets[1]", "bumper"
  [[nodiscard]] const std::string& name_of(int part) const { return things_[index(part)].name; }
  // Whether a part is one of the world's solids, not ground, a person or the robot.
  [[nodiscard]] bool is_solid(int part) const { return things_[index(part)].kind == Kind::kSolid; }
  [[nodiscard]] bool is_robot(int part) const { return things_[index(part)].kind == Kind::kRobot; }

  struct Hit {
    double distance_m = 0.0;
    int part = 0;
  };
  // The first thing on a ray, if there is any. `direction` has unit length.
  [[nodiscard]] std::optional<Hit> cast_ray(const Eigen::Vector3d& origin_m,
                                            const Eigen::Vector3d& direction) const;

  [[nodiscard]] const World& world() const { return *world_; }
  [[nodiscard]] mjModel_& model() { return *model_; }
  [[nodiscard]] const mjModel_& model() const { return *model_; }
  [[nodiscard]] mjData_& data() { return *data_; }
  [[nodiscard]] const mjData_& data() const { return *data_; }

 private:
  PhysicsModel() = default;
  enum class Kind { kRobot, kGround, kSolid, kPerson };
  struct Thing {
    Kind kind = Kind::kRobot;
    std::string name;
    Material material;  // not of the ground, which has many
  };
  [[nodiscard]] static std::size_t index(int part) { return static_cast<std::size_t>(part); }
  [[nodiscard]] static Result<PhysicsModel> build(const World& world, const RobotMjcf& robot,
                                                  const PhysicsOptions& options,
                                                  const std::vector<std::string>& treads);
  [[nodiscard]] const Material& material_of(int part, const Eigen::Vector3d& place) const;
  void name_things();
  [[nodiscard]] Status check_numbers() const;
  void move_people();
  void choose_near_solids();
  void update_treads();

  struct Deleter {
    void operator()(mjModel_* model) const;
    void operator()(mjData_* data) const;
  };
  const World* world_ = nullptr;
  PhysicsOptions options_;
  std::unique_ptr<mjModel_, Deleter> model_;
  std::unique_ptr<mjData_, Deleter> data_;
  std::vector<Tread> treads_;
  std::vector<Thing> things_;  // a geom each
  std::vector<int> solids_;    // which of them are solids
  // Where the robot was when solids near it were last chosen.
  std::optional<Eigen::Vector3d> chosen_at_m_;
};

}  // namespace tread
