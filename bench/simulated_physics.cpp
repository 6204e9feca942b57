// How much faster than time the simulated robots run, on one core: the rover driving over rough
// ground strewn with rocks, the walker standing on ground of every kind; and how still it stands.
// Usage: simulated_physics [--json] [--seconds N]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "physics_worlds.hpp"
#include "times.hpp"
#include "tread/sim/rover_body.hpp"
#include "tread/sim/walker_body.hpp"

namespace {

using namespace tread;

struct Row {
  std::string name;
  double place_ms = 0.0;  // reading the world, putting the robot on it, letting it settle
  double step_us = 0.0;
  double real_time = 0.0;  // seconds simulated in one of the processor
  double contacts = 0.0;   // mean
  double creep_mm = 0.0;   // of a foot that should stand still
  double force_off = 0.0;  // of the sum of contact forces from the weight, parts of it
};

constexpr double kGravity = 9.81;

// Runs a robot and looks at it after every step, outside the time taken.
template <class Robot>
void run(Robot& robot, double seconds, Row& row, const std::function<void()>& look) {
  const int steps = static_cast<int>(std::lround(seconds / robot.step_s()));
  double ms = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double start_ms = bench::cpu_ms();
    const Status done = robot.step();
    ms += bench::cpu_ms() - start_ms;
    if (!done) {
      fmt::print(stderr, "{}: {}\n", row.name, done.error().message());
      return;
    }
    row.contacts += static_cast<double>(robot.touches().size()) / steps;
    look();
  }
  row.step_us = 1e3 * ms / steps;
  row.real_time = 1e3 * seconds / ms;
}

Row drive(const std::string& name, const World& world, double seconds) {
  Row row{name};
  const double start_ms = bench::cpu_ms();
  const auto rover = RoverBody::place(world, {}, {});
  row.place_ms = bench::cpu_ms() - start_ms;
  if (!rover) {
    fmt::print(stderr, "{}: {}\n", name, rover.error().message());
    return row;
  }
  if ((*rover)->command({1.0, 0.15})) run(**rover, seconds, row, [] {});
  return row;
}

Row stand(const std::string& name, const World& world, double seconds) {
  Row row{name};
  const double start_ms = bench::cpu_ms();
  const auto placed = WalkerBody::place(world, {}, {});
  row.place_ms = bench::cpu_ms() - start_ms;
  if (!placed) {
    fmt::print(stderr, "{}: {}\n", name, placed.error().message());
    return row;
  }
  WalkerBody& walker = **placed;
  std::vector<Eigen::Vector3d> feet;
  for (int leg = 0; leg < kLegs; ++leg) feet.push_back(walker.foot_m(leg));
  const double weight = walker_mass_kg(walker.options()) * kGravity;
  run(walker, seconds, row, [&] {
    const Eigen::Vector3d off = walker.contact_force_n() - weight * Eigen::Vector3d::UnitZ();
    row.force_off = std::max(row.force_off, off.norm() / weight);
  });
  for (int leg = 0; leg < kLegs; ++leg) {
    const double moved = (walker.foot_m(leg) - feet[static_cast<std::size_t>(leg)]).norm();
    row.creep_mm = std::max(row.creep_mm, 1e3 * moved);
  }
  return row;
}

World rough_ground() {
  return test::ground_world(50.0, 0.1, Surface::kGravel, test::rough_height);
}

World rough_with_rocks() {
  World world = rough_ground();
  test::strew(world, 100, 24.0, 5);
  return world;
}

World eight_hundred_boxes() {
  World world = test::flat_world(Surface::kConcrete, 30.0);
  Random dice(3);
  for (int i = 0; i < 800; ++i) {
    world.solids.push_back(test::block(dice.uniform(-14.0, 14.0), dice.uniform(-14.0, 14.0),
                                       dice.uniform(0.1, 0.4), dice.uniform(0.1, 0.4),
                                       dice.uniform(0.02, 0.12), "box"));
  }
  return world;
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  int seconds = 10;
  bench::Arguments arguments("simulated_physics");
  arguments.flag("--json", json).number("--seconds", seconds, 1);
  if (const auto status = arguments.read(argc, argv)) return *status;
  const double s = seconds;
  const std::vector<Row> rows = {
      drive("rover, flat", test::flat_world(Surface::kConcrete, 50.0), s),
      drive("rover, rough 501x501", rough_ground(), s),
      drive("rover, rough, 100 rocks", rough_with_rocks(), s),
      stand("walker, flat", test::flat_world(), s),
      stand("walker, slope 15 deg", test::slope_world(0.2618, Surface::kConcrete), s),
      stand("walker, stones", test::stones_world(), s),
      stand("walker, stairs", test::stairs_world(), s),
      stand("walker, rough 501x501", rough_ground(), s),
      stand("walker, 800 boxes", eight_hundred_boxes(), s),
  };
  nlohmann::ordered_json cases = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    cases.push_back({{"case", row.name},
                     {"place_ms", row.place_ms},
                     {"step_us", row.step_us},
                     {"real_time", row.real_time},
                     {"contacts", row.contacts},
                     {"creep_mm", row.creep_mm},
                     {"force_off", row.force_off}});
  }
  if (json) {
    const nlohmann::ordered_json all = {{"bench", "simulated_physics"},
                                        {"seconds", seconds},
                                        {"step_s", PhysicsOptions().step_s},
                                        {"cases", cases}};
    fmt::print("{}\n", all.dump(2));
    return 0;
  }
  fmt::print("{} s simulated in steps of {:g} ms, one core\n\n", seconds,
             1e3 * PhysicsOptions().step_s);
  fmt::print("{:<26}{:>10}{:>10}{:>12}{:>10}{:>11}{:>12}\n", "case", "place ms", "step us",
             "real time", "contacts", "creep mm", "force off");
  for (const Row& r : rows) {
    fmt::print("{:<26}{:>10.1f}{:>10.1f}{:>11.1f}x{:>10.1f}{:>11.4f}{:>11.4f}%\n", r.name,
               r.place_ms, r.step_us, r.real_time, r.contacts, r.creep_mm, 100.0 * r.force_off);
  }
  return 0;
}
