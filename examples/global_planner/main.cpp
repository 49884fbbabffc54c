// Plans a path of a cell's first arm between two named poses, with a built-in planner or with "straight_line".
//
// usage: example_global_planner CELL.yaml PLANNER FROM TO

#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "examples/global_planner/straight_line.hpp"
#include "planner/global/plan.hpp"
#include "services/config/cell_file.hpp"

namespace {

namespace hp = hecaton::planner;

/// The first arm among the obstacles at their initial poses.
hp::global::Validity validity_of(const hp::Cell& cell) {
  hp::CellGeometry geometry({cell.arms.front().arm}, 0);
  geometry.set_obstacles(cell.scene.obstacles);
  std::vector<hp::Pose> X_WO;
  for (const hecaton::world::Obstacle& obstacle : cell.scene.obstacles) X_WO.push_back(obstacle.X_WO);
  const auto world = hp::global::world_bodies(geometry, X_WO, std::vector<hp::JointVector>(1));
  return hp::global::Validity({geometry}, world);
}

std::vector<double> named_pose(const hp::Arm& arm, const std::string& name) {
  const auto found = arm.named.find(name);
  if (found == arm.named.end()) throw std::invalid_argument("arm " + arm.name + " has no pose named '" + name + "'");
  return {found->second.begin(), found->second.end()};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: %s CELL.yaml PLANNER FROM TO\n", argv[0]);
    return 2;
  }
  try {
    hp::global::PlannerRegistry planners = hp::global::built_in_planners();
    planners.add<example::StraightLine>();
    hp::global::PlanOptions options;
    options.planner = planners.at(argv[2]);
    const hp::Cell cell = hecaton::config::load_cell_file(argv[1]).cell;
    const hp::global::Validity validity = validity_of(cell);
    const hp::Arm& arm = cell.arms.front().arm;
    const hp::global::Plan plan =
        hp::global::plan(validity, named_pose(arm, argv[3]), named_pose(arm, argv[4]), options);
    if (!plan.solved()) {
      std::printf("no path: %s\n", plan.reason.c_str());
      return 1;
    }
    std::printf("%zu points, %.3f rad\n", plan.path.size(), plan.length);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
