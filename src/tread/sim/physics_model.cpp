#include "tread/sim/physics_model.hpp"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

namespace tread {
namespace {

using Row = Eigen::Matrix<mjtNum, 3, 1>;

// What MuJoCo calls an error ends the program unless a handler does not return. It is written in C
// that may be unwound and has nothing to clean up but the model, which is lost anyway.
struct MujocoError {
  std::string text;
};

[[noreturn]] void raise_error(const char* text) {
  throw MujocoError{text};
}
// Warnings are counted in the data, where they are looked for. By default they are written to a
// file in the current folder.
void keep_silent(const char* /*text*/) {}

// Handlers are MuJoCo's own and of the whole process.
void take_handlers() {
  static const bool kTaken = [] {
    mju_user_error = raise_error;
    mju_user_warning = keep_silent;
    return true;
  }();
  (void)kTaken;
}

constexpr const char* kWhere = "physics";

template <class Body>
Status guarded(const Body& body) {
  try {
    body();
  } catch (const MujocoError& error) {
    return fail(ErrorCode::kUnsupported, "MuJoCo stopped: " + error.text, kWhere,
                "Make the world smaller or the step shorter");
  }
  return {};
}

// Robot parts have friction 0, so that what they touch decides (MuJoCo takes the larger).
std::string common_settings(const PhysicsOptions& options) {
  return fmt::format(
      R"(<compiler angle="radian" autolimits="true"/>
<option timestep="{}" gravity="0 0 -9.81" cone="elliptic" impratio="{}" noslip_iterations="{}"
 solver="Newton" iterations="50" tolerance="1e-10"/>
<size nconmax="300" njmax="1000"/>
<default><geom solref="{} 1" solimp="0.9 0.98 0.001" contype="1" conaffinity="0" condim="3"/></default>
)",
      options.step_s, options.sticking, options.noslip_iterations, options.contact_s);
}

Eigen::Map<const Row> at(const mjtNum* values, int index) {
  return Eigen::Map<const Row>(values + 3 * static_cast<std::ptrdiff_t>(index));
}

// "solid_17" -> 17
int number_after(std::string_view text, std::string_view prefix) {
  int number = 0;
  std::from_chars(text.data() + prefix.size(), text.data() + text.size(), number);
  return number;
}

// MuJoCo's message names geoms and meshes by our numbers: say what the course calls them.
Error refused(const World& world, const std::string& text) {
  Error error{ErrorCode::kUnsupported, "MuJoCo refuses the world: " + text, kWhere,
              "Check the sizes of its solids"};
  const std::size_t found = text.find("solid_");
  if (found != std::string::npos) {
    const int solid = number_after(std::string_view(text).substr(found), "solid_");
    if (solid >= 0 && static_cast<std::size_t>(solid) < world.solids.size()) {
      error.where = world.solids[static_cast<std::size_t>(solid)].name;
    }
  }
  return error;
}

struct VfsDeleter {
  void operator()(mjVFS* files) const {
    mj_deleteVFS(files);
    delete files;
  }
};

Result<mjModel*> compile(const World& world, const std::string& text) {
  constexpr const char* kFile = "world.xml";
  const std::unique_ptr<mjVFS, VfsDeleter> files(new mjVFS);
  mj_defaultVFS(files.get());
  if (text.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()) ||
      mj_makeEmptyFileVFS(files.get(), kFile, static_cast<int>(text.size())) != 0) {
    return fail(ErrorCode::kTooLarge, "the world is too large for MuJoCo", kWhere,
                "Use fewer solids");
  }
  std::memcpy(files->filedata[0], text.data(), text.size());
  std::array<char, 1000> message{};
  mjModel* model = nullptr;
  const Status done = guarded([&] {
    model = mj_loadXML(kFile, files.get(), message.data(), static_cast<int>(message.size()));
  });
  if (!done) return forward(done);
  if (model == nullptr) return tl::unexpected<Error>(refused(world, message.data()));
  return model;
}

}  // namespace

OptionSet describe(PhysicsOptions& options) {
  OptionSet set;
  set.add("step_s", options.step_s, "time between two states", 1e-5, 0.01);
  set.add("contact_s", options.contact_s, "in which a pressed contact springs back", 1e-4, 0.1);
  set.add("sticking", options.sticking, "stiffness of contacts along, in that across", 0.1, 1e4);
  set.add("noslip_iterations", options.noslip_iterations, "against creeping contacts", 0, 100);
  set.require({"contact_s", "step_s"}, "a contact must take two steps at least",
              [&options] { return options.contact_s >= 2.0 * options.step_s; });
  return set;
}

void PhysicsModel::Deleter::operator()(mjModel_* model) const {
  mj_deleteModel(model);
}
void PhysicsModel::Deleter::operator()(mjData_* data) const {
  mj_deleteData(data);
}

PhysicsModel::PhysicsModel(PhysicsModel&&) noexcept = default;
PhysicsModel& PhysicsModel::operator=(PhysicsModel&&) noexcept = default;
PhysicsModel::~PhysicsModel() = default;

Result<PhysicsModel> PhysicsModel::make(const World& world, const RobotMjcf& robot,
                                        const PhysicsOptions& options,
                                        const std::vector<std::string>& treads) {
  if (Status good = check_options(options); !good) return forward(good);
  if (Status good = check_for_physics(world); !good) return forward(good);
  return with_memory_checked(kWhere, "Use a smaller world", [&]() -> Result<PhysicsModel> {
    return build(world, robot, options, treads);
  });
}

Result<PhysicsModel> PhysicsModel::build(const World& world, const RobotMjcf& robot,
                                         const PhysicsOptions& options,
                                         const std::vector<std::string>& treads) {
  take_handlers();
  PhysicsModel physics;
  physics.world_ = &world;
  physics.options_ = options;
  RobotMjcf all = robot;
  all.settings = common_settings(options) + robot.settings;
  const Result<mjModel*> model = compile(world, world_mjcf(world, all));
  if (!model) return forward(model);
  physics.model_.reset(*model);
  const GroundField field = ground_field(world);
  std::copy(field.data.begin(), field.data.end(), physics.model_->hfield_data);
  Status good = guarded([&] { physics.data_.reset(mj_makeData(physics.model_.get())); });
  if (!good) return forward(good);
  physics.name_things();
  for (const std::string& name : treads) {
    const int part = mj_name2id(physics.model_.get(), mjOBJ_GEOM, name.c_str());
    if (part < 0) {
      return fail(ErrorCode::kBadArgument, "the robot has no part of this name", name,
                  "Name one of its geoms");
    }
    physics.treads_.emplace_back().part = part;
  }
  // Nobody has put the robot anywhere yet: where the model has it, it may be deep in the ground and
  // have more contacts than there is room for. That counts from its place on.
  physics.move_people();
  good = guarded([&] { mj_forward(physics.model_.get(), physics.data_.get()); });
  if (!good) return forward(good);
  for (mjWarningStat& warning : physics.data_->warning) warning.number = 0;
  physics.update_treads();
  return physics;
}

void PhysicsModel::name_things() {
  things_.resize(static_cast<std::size_t>(model_->ngeom));
  std::vector<std::vector<Solid>> people;
  for (const Person& person : world_->people) people.push_back(person_parts(person));
  for (int geom = 0; geom < model_->ngeom; ++geom) {
    const char* text = mj_id2name(model_.get(), mjOBJ_GEOM, geom);
    const std::string_view name = text != nullptr ? text : "";
    Thing& thing = things_[index(geom)];
    thing.name = name;
    const Solid* solid = nullptr;
    if (name == "ground") {
      thing = {Kind::kGround, "the ground", {}};
    } else if (name.starts_with("solid_")) {
      solid = &world_->solids[index(number_after(name, "solid_"))];
      thing.kind = Kind::kSolid;
      solids_.push_back(geom);
    } else if (name.starts_with("person_")) {
      const std::string_view part = name.substr(name.rfind('_'));
      solid = &people[index(number_after(name, "person_"))][index(number_after(part, "_"))];
      thing.kind = Kind::kPerson;
    }
    if (solid != nullptr) {
      thing.name = solid->name;
      thing.material = solid->material;
    }
  }
}

const Material& PhysicsModel::material_of(int part, const Eigen::Vector3d& place) const {
  const Thing& thing = things_[index(part)];
  return thing.kind == Kind::kGround ? ground_material(*world_, place.head<2>()) : thing.material;
}

Footing PhysicsModel::footing(const Touch& touch) const {
  return footing_of(material_of(touch.other, touch.place_m).surface);
}

void PhysicsModel::move_people() {
  int body = 0;
  for (const Person& person : world_->people) {
    for (const Isometry3d& T : person_pose(*world_, person, data_->time)) {
      const Eigen::Quaterniond q(T.linear());
      Eigen::Map<Row>(data_->mocap_pos + 3 * static_cast<std::ptrdiff_t>(body)) = T.translation();
      mjtNum* quat = data_->mocap_quat + 4 * static_cast<std::ptrdiff_t>(body);
      quat[0] = q.w();
      Eigen::Map<Row>(quat + 1) = q.vec();
      ++body;
    }
  }
}

// MuJoCo compares every part of the robot with every geom that may touch it, which takes most of
// the time in a world of hundreds of solids: so those that are out of reach may not.
void PhysicsModel::choose_near_solids() {
  constexpr double kReachM = 3.0, kMovedM = 1.0;  // parts of robots are within 2 m of its body
  const Eigen::Vector3d robot = at(data_->qpos, 0);
  if (!(chosen_at_m_ && (robot - *chosen_at_m_).norm() < kMovedM)) {
    chosen_at_m_ = robot;
    for (const int geom : solids_) {
      const double apart = (at(model_->geom_pos, geom) - robot).norm();
      model_->geom_contype[geom] = apart < kReachM + model_->geom_rbound[geom] ? 1 : 0;
    }
  }
}

std::vector<Touch> PhysicsModel::touches() const {
  std::vector<Touch> touches;
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    if (contact.efc_address < 0) continue;
    std::array<mjtNum, 6> force{};
    mj_contactForce(model_.get(), data_.get(), i, force.data());
    // Axes of the contact are rows; x points from geom1 to geom2, and the force is on geom2.
    const bool second = is_robot(contact.geom2);
    const double sign = second ? 1.0 : -1.0;
    Touch touch;
    touch.part = second ? contact.geom2 : contact.geom1;
    touch.other = second ? contact.geom1 : contact.geom2;
    touch.place_m = at(contact.pos, 0);
    touch.normal = sign * at(contact.frame, 0);
    for (int k = 0; k < 3; ++k) touch.force_n += sign * force[index(k)] * at(contact.frame, k);
    touch.depth_m = -contact.dist;
    touches.push_back(touch);
  }
  return touches;
}

// What is under a tread now decides how it holds in the next step.
void PhysicsModel::update_treads() {
  if (treads_.empty()) return;
  const std::vector<Touch> all = touches();
  for (Tread& tread : treads_) {
    tread.force_n.setZero();
    tread.load_n = 0.0;
    double most = -1.0;
    const Material* under = nullptr;
    for (const Touch& touch : all) {
      if (touch.part != tread.part) continue;
      const double load = touch.force_n.dot(touch.normal);
      tread.force_n += touch.force_n;
      tread.load_n += load;
      if (load > most) under = &material_of(touch.other, touch.place_m);
      most = std::max(most, load);
    }
    if (under == nullptr) {
      const Eigen::Vector3d place = at(data_->geom_xpos, tread.part);
      under = &ground_material(*world_, place.head<2>());
    }
    tread.footing = footing_of(under->surface);
    model_->geom_friction[3 * tread.part] = tread.footing.friction;
  }
}

Status PhysicsModel::check_numbers() const {
  for (const int warning : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC, mjWARN_INERTIA}) {
    if (data_->warning[warning].number == 0) continue;
    return fail(ErrorCode::kBadValue,
                fmt::format("the motion has no finite answer at {:.3f} s", data_->time), kWhere,
                "Take shorter steps or softer springs");
  }
  for (const int warning : {mjWARN_CONTACTFULL, mjWARN_CNSTRFULL}) {
    if (data_->warning[warning].number == 0) continue;
    return fail(ErrorCode::kTooLarge, fmt::format("too many contacts at {:.3f} s", data_->time),
                kWhere, "Use ground of larger cells or fewer solids");
  }
  return {};
}

Status PhysicsModel::begin_step() {
  move_people();
  choose_near_solids();
  return guarded([&] { mj_step1(model_.get(), data_.get()); });
}

Status PhysicsModel::end_step() {
  if (Status done = guarded([&] { mj_step2(model_.get(), data_.get()); }); !done) return done;
  update_treads();
  return check_numbers();
}

Status PhysicsModel::refresh() {
  choose_near_solids();
  if (Status done = guarded([&] { mj_forward(model_.get(), data_.get()); }); !done) return done;
  update_treads();
  return check_numbers();
}

double PhysicsModel::time_s() const {
  return data_->time;
}

Status PhysicsModel::set_time(double time_s) {
  data_->time = time_s;
  move_people();
  return refresh();
}

Status PhysicsModel::set_robot_pose(const Isometry3d& T_world_body) {
  const Eigen::Quaterniond q(T_world_body.linear());
  Eigen::Map<Row>(data_->qpos) = T_world_body.translation();
  data_->qpos[3] = q.w();
  Eigen::Map<Row>(data_->qpos + 4) = q.vec();
  std::fill_n(data_->qvel, model_->nv, 0.0);
  return refresh();
}

std::optional<PhysicsModel::Hit> PhysicsModel::cast_ray(const Eigen::Vector3d& origin_m,
                                                        const Eigen::Vector3d& direction) const {
  Hit hit;
  hit.distance_m = mj_ray(model_.get(), data_.get(), origin_m.data(), direction.data(), nullptr, 1,
                          -1, &hit.part);
  return hit.part < 0 ? std::nullopt : std::optional(hit);
}

}  // namespace tread
