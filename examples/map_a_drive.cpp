// Maps of the ground from a recorded drive, and the waypoints to a goal.
//   map_a_drive FOLDER GOAL_X GOAL_Y
#include <cstdlib>
#include <iostream>

#include "tread/io/map_files.hpp"
#include "tread/io/source.hpp"
#include "tread/pipeline/rover_mapper.hpp"
#include "tread/plan/planner.hpp"

namespace {

int complain(const tread::Error& error) {
  std::cerr << error.message() << '\n';
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: map_a_drive FOLDER GOAL_X GOAL_Y\n";
    return 2;
  }
  const auto source = tread::open_stereo_source(argv[1]);
  if (!source) return complain(source.error());
  auto mapper = tread::RoverMapper::make((*source)->rig(), {});
  if (!mapper) return complain(mapper.error());

  Eigen::Vector2d robot(0.0, 0.0);
  while (true) {
    const auto frame = (*source)->next();
    if (!frame) return complain(frame.error());
    if (!*frame) break;  // the end of the drive
    const auto stages = mapper->add(**frame);
    if (!stages) return complain(stages.error());
    robot = stages->pose.position.head<2>();
  }

  const tread::Plan plan = tread::plan_waypoints(mapper->cost().grid(), robot,
                                                 {std::atof(argv[2]), std::atof(argv[3])}, {});
  if (plan.status != tread::PlanStatus::kFound) std::cout << plan.reason << '\n';
  for (const Eigen::Vector2d& p : plan.waypoints) std::cout << p.x() << " " << p.y() << '\n';

  const auto layers = mapper->layers();
  if (!layers) return complain(layers.error());
  const tread::Status saved = tread::save_map(*layers, "map");
  return saved ? 0 : complain(saved.error());
}
