// Something of every module, so that a header or library missing from the package is noticed.
#include <iostream>

#include "tread/io/map_files.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/pipeline/rover_mapper.hpp"
#include "tread/plan/planner.hpp"
#include "tread/terrain/features.hpp"

int main() {
  const auto rig = tread::read_rig("bumblebee2-640");
  if (!rig) return 1;
  auto mapper = tread::RoverMapper::make(*rig, {});
  if (!mapper) return 2;
  const tread::Grid<float> ground(tread::GridGeometry{0.1, {0.0, 0.0}, 20, 20}, 0.0F);
  if (tread::terrain_features(ground).slope.values.empty()) return 3;
  const tread::Grid<float> cost(tread::GridGeometry{0.3, {0.0, 0.0}, 20, 20}, 1.0F);
  const tread::Plan plan = tread::plan_waypoints(cost, {0.5, 0.5}, {5.0, 5.0}, {});
  if (plan.status != tread::PlanStatus::kFound) return 4;
  if (tread::load_map("nowhere")) return 5;
  std::cout << "waypoints: " << plan.waypoints.size() << '\n';
  return 0;
}
