#include "world/sim/contact_monitor.hpp"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/unit/world/sim/small_worlds.hpp"

namespace hecaton::world {
namespace {

using Eigen::Vector3d;

/// An arm of free balls of radius 0.1 m, one per link. Link 0 is fixed.
ArmBodies ball_arm(const std::string& name, int links) {
  ArmBodies arm;
  arm.name = name;
  for (int i = 0; i < links; ++i) {
    arm.parts.push_back({i, "link" + std::to_string(i), {Sphere{0.1}, Pose::Identity()}, i > 0});
  }
  return arm;
}

Obstacle ball_obstacle(const std::string& name, double radius = 0.1) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.shapes.emplace_back().shape = Sphere{radius};
  return obstacle;
}

/// Poses of all bodies, and their monitor.
struct Situation {
  Situation(const std::vector<ArmBodies>& arms, std::vector<Obstacle> all) : monitor(arms), obstacles(std::move(all)) {
    for (const ArmBodies& arm : arms) {
      std::vector<Pose> links;
      // Far apart by default.
      for (std::size_t i = 0; i < arm.parts.size(); ++i) {
        links.push_back(at_point(100.0 * static_cast<double>(poses.size() + 1), 10.0 * static_cast<double>(i), 0));
      }
      poses.push_back(links);
      known.push_back(true);
    }
    monitor.set_obstacles(obstacles);
    states.resize(obstacles.size());
  }

  void update(double time) {
    std::vector<MeasuredArm> measured;
    for (std::size_t i = 0; i < poses.size(); ++i) measured.push_back({known[i], poses[i]});
    monitor.update(measured, states, time);
  }

  ContactMonitor monitor;
  std::vector<Obstacle> obstacles;
  std::vector<std::vector<Pose>> poses;
  std::vector<bool> known;
  std::vector<ObstacleState> states;
};

TEST(ContactMonitor, ReportsNothingWithoutPairs) {
  Situation situation({ball_arm("arm1", 2)}, {});
  situation.update(0.0);
  EXPECT_FALSE(situation.monitor.report().has_smallest);
  EXPECT_EQ(situation.monitor.report().contacts, 0U);
  EXPECT_FALSE(situation.monitor.nearest(0).has_value());
}

TEST(ContactMonitor, SkipsUnknownArms) {
  Situation situation({ball_arm("arm1", 2), ball_arm("arm2", 2)}, {ball_obstacle("pallet")});
  situation.known = {false, true};
  situation.states[0].X_WO = at_point(0, 0, 0);
  situation.poses[0][1] = at_point(0, 0, 0);
  situation.poses[1][1] = at_point(0, 0, 1.0);
  situation.update(0.0);
  EXPECT_FALSE(situation.monitor.report().kinds[kArmArm].has_smallest);
  EXPECT_NEAR(situation.monitor.report().smallest.distance, 0.8, 1e-9);
  EXPECT_FALSE(situation.monitor.nearest(0).has_value());
  situation.known = {true, true};
  situation.update(0.1);
  EXPECT_EQ(situation.monitor.report().contacts, 1U);
  EXPECT_TRUE(situation.monitor.report().kinds[kArmArm].has_smallest);
}

TEST(ContactMonitor, LeavesOutFixedPartsBetweenArmsOfOneRobot) {
  std::vector<ArmBodies> arms{ball_arm("left", 2), ball_arm("right", 2)};
  for (ArmBodies& arm : arms) arm.robot = 0;
  Situation situation(arms, {});
  situation.poses[0][0] = at_point(0, 0, 0);
  situation.poses[1][1] = at_point(0, 0, 0.1);
  situation.poses[0][1] = at_point(0, 0, 0.6);
  situation.update(0.0);
  EXPECT_EQ(situation.monitor.report().contacts, 0U);
  EXPECT_NEAR(situation.monitor.report().smallest.distance, 0.3, 1e-9);
  situation.poses[0][1] = at_point(0, 0, 0.2);
  situation.update(0.1);
  EXPECT_EQ(situation.monitor.report().contacts, 1U);
}

TEST(ContactMonitor, FindsSmallestDistanceAndItsTime) {
  // link1 of arm2 flies past link1 of arm1 along x at 1 m/s, offset 0.25 m in y: nearest 0.25 − 0.2 = 0.05 m at 2 s.
  Situation situation({ball_arm("arm1", 2), ball_arm("arm2", 2)}, {});
  situation.poses[0][1] = at_point(0, 0, 1);
  for (int i = 0; i <= 400; ++i) {
    const double time = 0.01 * i;
    situation.poses[1][1] = at_point(time - 2.0, 0.25, 1);
    situation.update(time);
  }
  const ContactReport report = situation.monitor.report();
  EXPECT_TRUE(report.has_smallest);
  EXPECT_EQ(report.contacts, 0U);
  EXPECT_NEAR(report.smallest.distance, 0.05, 1e-9);
  EXPECT_NEAR(report.smallest.time, 2.0, 1e-9);
  EXPECT_EQ(report.smallest.kind, ContactKind::kArmArm);
  EXPECT_EQ(report.smallest.a, "arm1/link1");
  EXPECT_EQ(report.smallest.b, "arm2/link1");
  EXPECT_FALSE(report.kinds[kArmObstacle].has_smallest);
  EXPECT_FALSE(report.kinds[kArmSelf].has_smallest);
}

TEST(ContactMonitor, ReportsEachKindOfPair) {
  ArmBodies arm = ball_arm("arm1", 4);
  arm.self_pairs = {{1, 3}};
  Situation situation({arm, ball_arm("arm2", 2)}, {ball_obstacle("pallet", 0.2)});
  situation.poses[0][1] = at_point(0, 0, 0);
  situation.poses[0][2] = at_point(0, 0, 0.05);    // overlaps link1, but is no self pair
  situation.poses[0][3] = at_point(0, 0, 0.3);     // 0.1 from link1
  situation.states[0].X_WO = at_point(0, 0, 0.8);  // 0.5 − 0.3 = 0.2 from link3
  situation.poses[1][1] = at_point(0.5, 0, 0);     // 0.3 from link1
  situation.update(1.0);
  const ContactReport report = situation.monitor.report();
  EXPECT_NEAR(report.kinds[kArmSelf].smallest.distance, 0.1, 1e-9);
  EXPECT_EQ(report.kinds[kArmSelf].smallest.a, "arm1/link1");
  EXPECT_EQ(report.kinds[kArmSelf].smallest.b, "arm1/link3");
  EXPECT_NEAR(report.kinds[kArmObstacle].smallest.distance, 0.2, 1e-9);
  EXPECT_EQ(report.kinds[kArmObstacle].smallest.a, "arm1/link3");
  EXPECT_EQ(report.kinds[kArmObstacle].smallest.b, "pallet");
  EXPECT_NEAR(report.kinds[kArmArm].smallest.distance, 0.3, 1e-9);
  EXPECT_NEAR(report.smallest.distance, 0.1, 1e-9);
  EXPECT_EQ(report.smallest.kind, ContactKind::kArmSelf);
  EXPECT_EQ(report.contacts, 0U);
}

TEST(ContactMonitor, ChecksFixedPartsAgainstMovingObstacles) {
  Obstacle rolls = ball_obstacle("rolls");
  rolls.motion = ConveyorMotion{};
  Obstacle falls = ball_obstacle("falls");
  falls.motion = DynamicMotion{};
  Situation situation({ball_arm("arm1", 2)}, {rolls, falls, ball_obstacle("pedestal")});
  situation.poses[0][0] = at_point(0, 0, 0);
  for (auto& state : situation.states) state.X_WO = at_point(0.05, 0, 0);
  situation.update(0.0);
  EXPECT_EQ(situation.monitor.report().kinds[kArmObstacle].contacts, 2U);
}

TEST(ContactMonitor, ChecksStaticObstacleAgainstMovingPartsOnly) {
  Situation situation({ball_arm("arm1", 2), ball_arm("arm2", 2)}, {ball_obstacle("pedestal")});
  situation.poses[0][0] = at_point(0, 0, 0);
  situation.poses[1][0] = at_point(0.05, 0, 0);
  situation.states[0].X_WO = at_point(0, 0, 0.05);
  situation.update(0.0);
  EXPECT_EQ(situation.monitor.report().contacts, 0U);
  situation.poses[1][1] = at_point(-0.05, 0, 0);
  situation.update(0.1);
  const ContactReport report = situation.monitor.report();
  EXPECT_EQ(report.kinds[kArmArm].contacts, 1U);
  EXPECT_EQ(report.kinds[kArmObstacle].contacts, 1U);
}

TEST(ContactMonitor, CountsContactOnceUntilParted) {
  Situation situation({ball_arm("arm1", 2)}, {ball_obstacle("pallet")});
  situation.poses[0][1] = at_point(0, 0, 0);
  const auto at_distance = [&](double distance, double time) {
    situation.states[0].X_WO = at_point(0.2 + distance, 0, 0);
    situation.update(time);
    return situation.monitor.report().contacts;
  };
  EXPECT_EQ(at_distance(0.0100, 0.0), 0U);
  EXPECT_EQ(at_distance(0.0005, 0.1), 0U);  // near is no contact
  EXPECT_EQ(at_distance(-0.0010, 0.2), 1U);
  EXPECT_EQ(at_distance(-0.0200, 0.3), 1U);
  EXPECT_EQ(at_distance(0.0005, 0.4), 1U);  // not yet parted
  EXPECT_EQ(at_distance(-0.0001, 0.5), 1U);
  EXPECT_EQ(at_distance(0.0015, 0.6), 1U);   // parted
  EXPECT_EQ(at_distance(-0.0001, 0.7), 2U);  // and again
  const ContactReport report = situation.monitor.report();
  EXPECT_NEAR(report.smallest.distance, -0.02, 1e-9);
  EXPECT_NEAR(report.smallest.time, 0.3, 1e-12);
  ASSERT_EQ(report.events.size(), 2U);
  EXPECT_NEAR(report.events[0].distance, -0.001, 1e-9);
  EXPECT_NEAR(report.events[0].time, 0.2, 1e-12);
  EXPECT_NEAR(report.events[1].time, 0.7, 1e-12);
  EXPECT_EQ(report.events[0].b, "pallet");
}

TEST(ContactMonitor, CountsOneContactForSeveralShapesOfALink) {
  ArmBodies arm = ball_arm("arm1", 2);
  arm.parts.push_back({1, "link1", {Sphere{0.1}, at_point(0.05, 0, 0)}, true});
  Obstacle pallet = ball_obstacle("pallet");
  pallet.shapes.push_back({Box{Vector3d(0.1, 0.1, 0.1)}, at_point(0.1, 0, 0)});
  Situation situation({arm}, {pallet});
  situation.poses[0][1] = at_point(0, 0, 0);
  situation.states[0].X_WO = at_point(0.1, 0, 0);
  situation.update(0.0);
  EXPECT_EQ(situation.monitor.report().contacts, 1U);
}

TEST(ContactMonitor, ResetClearsTotals) {
  Situation situation({ball_arm("arm1", 2)}, {ball_obstacle("pallet")});
  situation.poses[0][1] = at_point(0, 0, 0);
  situation.states[0].X_WO = at_point(0.1, 0, 0);
  situation.update(0.0);
  situation.monitor.reset();
  EXPECT_EQ(situation.monitor.report().contacts, 0U);
  EXPECT_FALSE(situation.monitor.report().has_smallest);
  EXPECT_TRUE(situation.monitor.report().events.empty());
  situation.update(0.1);
  EXPECT_EQ(situation.monitor.report().contacts, 1U);
  EXPECT_NEAR(situation.monitor.report().smallest.distance, -0.1, 1e-9);
}

TEST(ContactMonitor, CountsAllContactsAndKeepsOneHundredEvents) {
  Situation situation({ball_arm("arm1", 2)}, {ball_obstacle("pallet")});
  situation.poses[0][1] = at_point(0, 0, 0);
  for (int i = 0; i < 240; ++i) {
    situation.states[0].X_WO = at_point(i % 2 == 0 ? 1.0 : 0.1, 0, 0);
    situation.update(i);
  }
  EXPECT_EQ(situation.monitor.report().contacts, 120U);
  EXPECT_EQ(situation.monitor.report().events.size(), 100U);
}

TEST(ContactMonitor, CarriedObstacleIsPartOfArm) {
  ArmBodies arm = ball_arm("arm1", 4);
  arm.grasp_links = {2, 3};
  Obstacle box = ball_obstacle("box");
  box.attachment = Attachment{"arm1", Pose::Identity()};
  Situation situation({arm, ball_arm("arm2", 2)}, {box, ball_obstacle("pallet")});
  situation.poses[0][2] = at_point(0, 0, 0.05);
  situation.poses[0][3] = at_point(0, 0, 0.1);
  situation.states[0].X_WO = at_point(0, 0, 0.15);  // in the hand: no contact with links 2 and 3
  situation.states[1].X_WO = at_point(0, 0, 0.45);  // pallet: 0.3 − 0.2 above the box
  situation.poses[1][1] = at_point(0.5, 0, 0.15);   // arm2: 0.5 − 0.2 beside the box
  situation.poses[0][1] = at_point(0, -0.4, 0.15);  // own link1: 0.4 − 0.2 beside the box
  situation.update(0.0);
  const ContactReport report = situation.monitor.report();
  EXPECT_EQ(report.contacts, 0U);
  EXPECT_NEAR(report.kinds[kArmObstacle].smallest.distance, 0.1, 1e-9);
  EXPECT_EQ(report.kinds[kArmObstacle].smallest.a, "arm1/box");
  EXPECT_NEAR(report.kinds[kArmArm].smallest.distance, 0.3, 1e-9);
  EXPECT_EQ(report.kinds[kArmArm].smallest.b, "arm1/box");
  EXPECT_EQ(report.kinds[kArmArm].smallest.a, "arm2/link1");
  EXPECT_NEAR(report.kinds[kArmSelf].smallest.distance, 0.2, 1e-9);
}

TEST(ContactMonitor, ToleratesContactOfHandledObstacleUntilParted) {
  ArmBodies arm = ball_arm("arm1", 2);
  arm.grasp_links = {1};
  Situation situation({arm}, {ball_obstacle("table"), ball_obstacle("box")});
  situation.poses[0][1] = at_point(0, 0, 0.41);
  situation.states[0].X_WO = at_point(0, 0, 0.0);
  situation.states[1].X_WO = at_point(0, 0, 0.2);  // rests on the table
  situation.update(0.0);
  EXPECT_EQ(situation.monitor.report().contacts, 0U);
  const double before = situation.monitor.report().smallest.distance;
  EXPECT_NEAR(before, 0.01, 1e-9);

  situation.obstacles[1].attachment = Attachment{"arm1", at_point(0, 0, -0.21)};
  situation.monitor.set_obstacles(situation.obstacles, "box");
  situation.update(0.1);
  EXPECT_EQ(situation.monitor.report().contacts, 0U) << "the table's contact with the box is tolerated";
  situation.states[1].X_WO = at_point(0, 0, 0.25);
  situation.update(0.2);
  EXPECT_NEAR(situation.monitor.report().smallest.distance, 0.01, 1e-9);
  situation.states[1].X_WO = at_point(0, 0, 0.19);
  situation.update(0.3);
  EXPECT_EQ(situation.monitor.report().contacts, 1U) << "a contact after lifting counts";

  // Detached inside the hand: no contact until the hand has left and returned.
  situation.states[1].X_WO = at_point(0, 0, 0.35);
  situation.obstacles[1].attachment.reset();
  situation.monitor.set_obstacles(situation.obstacles, "box");
  situation.update(0.4);
  EXPECT_EQ(situation.monitor.report().contacts, 1U);
  situation.poses[0][1] = at_point(0, 0, 0.6);
  situation.update(0.5);
  situation.poses[0][1] = at_point(0, 0, 0.5);
  situation.update(0.6);
  EXPECT_EQ(situation.monitor.report().contacts, 2U);
}

TEST(ContactMonitor, CountsToleratedPairThatOverlapsDeeper) {
  ArmBodies arm = ball_arm("arm1", 2);
  arm.grasp_links = {1};
  Situation situation({arm}, {ball_obstacle("table"), ball_obstacle("box")});
  situation.poses[0][1] = at_point(0, 0, 0.5);
  situation.states[1].X_WO = at_point(0, 0, 0.2);
  situation.obstacles[1].attachment = Attachment{"arm1", at_point(0, 0, -0.3)};
  situation.monitor.set_obstacles(situation.obstacles, "box");
  situation.update(0.0);
  situation.states[1].X_WO = at_point(0, 0, 0.1995);
  situation.update(0.1);
  EXPECT_EQ(situation.monitor.report().contacts, 0U);
  situation.states[1].X_WO = at_point(0, 0, 0.198);
  situation.update(0.2);
  EXPECT_EQ(situation.monitor.report().contacts, 1U);
}

TEST(ContactMonitor, LastingContactSurvivesEdits) {
  Situation situation({ball_arm("arm1", 2)}, {ball_obstacle("pallet")});
  situation.poses[0][1] = at_point(0, 0, 0);
  situation.states[0].X_WO = at_point(0.1, 0, 0);
  situation.update(0.0);
  situation.obstacles.insert(situation.obstacles.begin(), ball_obstacle("crate"));
  situation.monitor.set_obstacles(situation.obstacles);
  situation.states.insert(situation.states.begin(), ObstacleState{at_point(50, 0, 0), {}, 0.0});
  situation.update(0.1);
  EXPECT_EQ(situation.monitor.report().contacts, 1U);
  EXPECT_EQ(situation.monitor.report().smallest.b, "pallet");
}

TEST(ContactMonitor, NearestIsPresentSeparationOfArm) {
  Situation situation({ball_arm("arm1", 2), ball_arm("arm2", 2)}, {ball_obstacle("pallet")});
  situation.poses[0][1] = at_point(0, 0, 0);
  situation.states[0].X_WO = at_point(0.5, 0, 0);
  situation.update(0.0);
  situation.states[0].X_WO = at_point(1.0, 0, 0);
  situation.update(0.1);
  EXPECT_NEAR(situation.monitor.report().smallest.distance, 0.3, 1e-9);
  ASSERT_TRUE(situation.monitor.nearest(0).has_value());
  EXPECT_NEAR(situation.monitor.nearest(0)->distance, 0.8, 1e-9);
  EXPECT_EQ(situation.monitor.nearest(0)->b, "pallet");
  EXPECT_NEAR(situation.monitor.nearest(0)->time, 0.1, 1e-12);
}

TEST(ContactMonitor, ThrowsOnBadSelfPairsAndMissingPoses) {
  ArmBodies arm = ball_arm("arm1", 2);
  arm.self_pairs = {{0, 2}};
  EXPECT_THROW(ContactMonitor({arm}), std::invalid_argument);
  ContactMonitor monitor({ball_arm("arm1", 2)});
  EXPECT_THROW(monitor.update({}, {}, 0.0), std::invalid_argument);
  const std::vector<Pose> one_link(1, Pose::Identity());
  const MeasuredArm measured{true, one_link};
  EXPECT_THROW(monitor.update(std::span(&measured, 1), {}, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace hecaton::world
