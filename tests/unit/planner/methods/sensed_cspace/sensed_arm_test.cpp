// What an arm that plans through its C-space says of itself.
#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/methods/sensed_cspace/cspace_method.hpp"
#include "planner/methods/sensed_cspace/sensed_planner.hpp"
#include "planner/model/urdf_loader.hpp"

namespace hecaton::planner {
namespace {

// Next to a blocked cell not even the way to the goal on which the arm stands is wide open.
TEST(SensedArm, ReachesAGoalBesideASensedObstacle) {
  Arm arm;
  arm.name = "arm";
  arm.model = load_urdf(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/planar_2r.urdf");
  arm.limits = arm.model->limits;
  arm.limits.acceleration = Eigen::Vector2d(8.0, 8.0);
  LocalParameters parameters;
  cspace::SensedCspace method;
  method.parameters = {.cells = 360, .margin = 0.03, .remember = Remember::kAlways};
  parameters.method = std::make_shared<cspace::SensedCspace>(method);
  ArmController controller(CellGeometry(std::vector<Arm>{arm}, 0), parameters, 0.01, 1);
  JointVector q = Eigen::Vector2d(-0.8, 0.0);
  const JointVector still = JointVector::Zero(2);
  controller.sense({0, 0, q, {{{}, 0.75, true}}});
  controller.set_goal(q);
  (void)controller.step(MeasuredState{q, still}, {}, {}, false);

  const cspace::SensedMap& map = dynamic_cast<const cspace::SensedPlanner&>(*controller.guide()).map();
  while (map.straight_path_free(q, q, true)) q[0] += 1e-3;
  ASSERT_TRUE(map.straight_path_free(q, q));
  controller.set_goal(q);
  controller.forget_setpoint();
  EXPECT_EQ(controller.step(MeasuredState{q, still}, {}, {}, false).status, TickStatus::kReached);
}

}  // namespace
}  // namespace hecaton::planner
