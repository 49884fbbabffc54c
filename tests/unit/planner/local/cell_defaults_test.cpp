// Postures and task areas of cells that leave them open.
#include "planner/cell_defaults.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/collision/model_filter.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

const std::string kPuma = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf";

Cell cell_of(std::initializer_list<Arm> arms) {
  Cell cell;
  for (const Arm& arm : arms) {
    PlannedArm& planned = cell.arms.emplace_back();
    planned.arm = arm;
    planned.start = arm.home();
  }
  return cell;
}

Arm puma(const std::string& name, double x) {
  Arm arm;
  arm.name = name;
  arm.model = load_arm_model(kPuma);
  arm.limits = arm.model->limits;
  arm.X_WB.translation().x() = x;
  arm.named["home"] = compact_postures(arm).front();
  return arm;
}

double nearest_other(const Cell& cell, int self) {
  CellGeometry geometry(arms_of(cell), self);
  geometry.set_obstacles(cell.scene.obstacles);
  ExactDistance distance(geometry);
  std::vector<Kinematics> arms(cell.arms.size());
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const Arm& arm = cell.arms[i].arm;
    forward_kinematics(*arm.model, arm.X_WB, arm.home(), arms[i]);
  }
  std::vector<world::ObstacleState> obstacles;
  for (const world::Obstacle& obstacle : cell.scene.obstacles) obstacles.push_back({obstacle.X_WO, {}, 0.0});
  std::vector<Clearance> found(1);
  const int count = distance.clearances({&arms[self], arms, obstacles}, {.others = 1.0, .self = 0.0}, found);
  return count == 0 ? 1.0 : found[0].distance;
}

TEST(CellDefaults, CompactPosturesAreWithinLimitsAndClearOfThemselves) {
  const Arm arm = puma("p", 0.0);
  const CellGeometry geometry({arm}, 0);
  ExactDistance distance(geometry);
  std::vector<Kinematics> kinematics(1);
  std::vector<Clearance> found(1);
  const auto postures = compact_postures(arm);
  ASSERT_GT(postures.size(), 10U);
  for (const JointVector& q : postures) {
    EXPECT_TRUE((q.array() >= arm.limits.lower.array()).all() && (q.array() <= arm.limits.upper.array()).all());
    forward_kinematics(*arm.model, arm.X_WB, q, kinematics[0]);
    EXPECT_EQ(distance.clearances({kinematics.data(), kinematics, {}}, {.self = 0.05}, found), 0);
  }
  EXPECT_EQ(compact_postures(arm).front(), postures.front()) << "deterministic";
}

TEST(CellDefaults, ChoosesHomesClearOfOtherArmsAndObstacles) {
  Cell cell = cell_of({puma("left", 0.0), puma("right", 0.8)});
  cell.scene.obstacles = {test::box_obstacle("shelf", {0.4, 0.5, 0.8}, {0.3, 0.1, 0.3})};
  choose_home_poses(cell, std::vector<int>{0, 1});
  for (int arm = 0; arm < 2; ++arm) {
    EXPECT_GE(nearest_other(cell, arm), cell.arms[arm].parameters.damper.security_distance + 0.03);
    EXPECT_EQ(cell.arms[arm].start, cell.arms[arm].arm.home());
  }
}

TEST(CellDefaults, TaskAreaIsWhereAllArmsReach) {
  // Points that slide within ±3 m in x and y of their bases, 4 m apart: both reach x from 1 to 3, the middle is 2.
  Arm right = test::planar_point("right");
  right.X_WB.translation().x() = 4.0;
  const auto area = default_task_area(cell_of({test::planar_point("left"), right}));
  ASSERT_TRUE(area);
  EXPECT_FALSE(area->of_each_arm);
  EXPECT_NEAR(area->centre.x(), 2.0, 0.2);
  EXPECT_NEAR(area->centre.y(), 0.0, 0.2);
  EXPECT_EQ(area->centre.z(), 0.0);
  EXPECT_EQ(area->half_height, 0.0);
  EXPECT_GT(area->radius, 0.5);
}

TEST(CellDefaults, ASmallArmInTheReachOfALargeOneGetsItsWholeReach) {
  Arm small = test::planar_point("small");
  auto model = std::make_shared<RobotModel>(*small.model);
  model->limits.lower = test::joints({-0.1, -0.1});
  model->limits.upper = test::joints({0.1, 0.1});
  small.model = model;
  small.limits = model->limits;
  small.X_WB.translation() = Eigen::Vector3d(1.2, -0.7, 0.0);
  const auto alone = default_task_area(cell_of({small}));
  const auto both = default_task_area(cell_of({test::planar_point("large"), small}));
  ASSERT_TRUE(alone && both);
  EXPECT_FALSE(both->of_each_arm);
  EXPECT_GT(both->radius, 0.9 * alone->radius);
}

TEST(CellDefaults, ArmsOutOfReachOfEachOtherGetAnAreaEach) {
  Arm far = test::planar_point("far");
  far.X_WB.translation().x() = 20.0;
  const auto area = default_task_area(cell_of({test::planar_point("near"), far}));
  ASSERT_TRUE(area);
  EXPECT_TRUE(area->of_each_arm);
  EXPECT_NEAR(area->centre.norm(), 0.0, 0.2);
}

}  // namespace
}  // namespace hecaton::planner
