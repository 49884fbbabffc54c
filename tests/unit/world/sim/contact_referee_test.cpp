#include "world/sim/contact_referee.hpp"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/unit/world/sim/at_point.hpp"

namespace hecaton::world {
namespace {

using Eigen::Vector3d;

constexpr auto kArmArm = static_cast<std::size_t>(ContactKind::kArmArm);
constexpr auto kArmObstacle = static_cast<std::size_t>(ContactKind::kArmObstacle);
constexpr auto kArmSelf = static_cast<std::size_t>(ContactKind::kArmSelf);

/// An "arm" of balls of radius 0.1 m, one a link, that tests put where they like. The first does not move.
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

/// Poses of everything, and the referee that judges them.
struct Court {
  Court(const std::vector<ArmBodies>& arms, std::vector<Obstacle> all) : referee(arms), obstacles(std::move(all)) {
    for (const ArmBodies& arm : arms) {
      std::vector<Pose> links;
      // Far from each other until a test says otherwise.
      for (std::size_t i = 0; i < arm.parts.size(); ++i) {
        links.push_back(at_point(100.0 * static_cast<double>(poses.size() + 1), 10.0 * static_cast<double>(i), 0));
      }
      poses.push_back(links);
      known.push_back(true);
    }
    referee.set_obstacles(obstacles);
    states.resize(obstacles.size());
  }

  void judge(double time) {
    std::vector<MeasuredArm> measured;
    for (std::size_t i = 0; i < poses.size(); ++i) measured.push_back({known[i], poses[i]});
    referee.judge(measured, states, time);
  }

  ContactReferee referee;
  std::vector<Obstacle> obstacles;
  std::vector<std::vector<Pose>> poses;
  std::vector<bool> known;
  std::vector<ObstacleState> states;
};

TEST(ContactReferee, WithoutBodiesNothingIsJudged) {
  Court court({ball_arm("arm1", 2)}, {});
  court.judge(0.0);
  EXPECT_FALSE(court.referee.report().judged);
  EXPECT_EQ(court.referee.report().contacts, 0U);
  EXPECT_FALSE(court.referee.nearest(0).has_value());
}

TEST(ContactReferee, UnknownArmsAreNotJudged) {
  Court court({ball_arm("arm1", 2), ball_arm("arm2", 2)}, {ball_obstacle("pallet")});
  court.known = {false, true};
  court.states[0].X_WO = at_point(0, 0, 0);
  court.poses[0][1] = at_point(0, 0, 0);
  court.poses[1][1] = at_point(0, 0, 1.0);
  court.judge(0.0);
  EXPECT_FALSE(court.referee.report().kinds[kArmArm].judged);
  EXPECT_NEAR(court.referee.report().smallest.distance, 0.8, 1e-9);
  EXPECT_FALSE(court.referee.nearest(0).has_value());
  court.known = {true, true};
  court.judge(0.1);
  EXPECT_EQ(court.referee.report().contacts, 1U);
  EXPECT_TRUE(court.referee.report().kinds[kArmArm].judged);
}

TEST(ContactReferee, FindsTheNearestPassAndWhen) {
  // link1 of arm2 flies past link1 of arm1 along x at 1 m/s, offset 0.25 m in y: nearest 0.25 − 0.2 = 0.05 m at 2 s.
  Court court({ball_arm("arm1", 2), ball_arm("arm2", 2)}, {});
  court.poses[0][1] = at_point(0, 0, 1);
  for (int i = 0; i <= 400; ++i) {
    const double time = 0.01 * i;
    court.poses[1][1] = at_point(time - 2.0, 0.25, 1);
    court.judge(time);
  }
  const RefereeReport report = court.referee.report();
  EXPECT_TRUE(report.judged);
  EXPECT_EQ(report.contacts, 0U);
  EXPECT_NEAR(report.smallest.distance, 0.05, 1e-9);
  EXPECT_NEAR(report.smallest.time, 2.0, 1e-9);
  EXPECT_EQ(report.smallest.kind, ContactKind::kArmArm);
  EXPECT_EQ(report.smallest.a, "arm1/link1");
  EXPECT_EQ(report.smallest.b, "arm2/link1");
  EXPECT_FALSE(report.kinds[kArmObstacle].judged);
  EXPECT_FALSE(report.kinds[kArmSelf].judged);
}

TEST(ContactReferee, SplitsByKind) {
  ArmBodies arm = ball_arm("arm1", 4);
  arm.self_pairs = {{1, 3}};
  Court court({arm, ball_arm("arm2", 2)}, {ball_obstacle("pallet", 0.2)});
  court.poses[0][1] = at_point(0, 0, 0);
  court.poses[0][2] = at_point(0, 0, 0.05);    // overlaps link1, but is no self pair
  court.poses[0][3] = at_point(0, 0, 0.3);     // 0.1 from link1
  court.states[0].X_WO = at_point(0, 0, 0.7);  // 0.4 − 0.3 = 0.1 from link3 … moved below
  court.states[0].X_WO = at_point(0, 0, 0.8);  // 0.5 − 0.3 = 0.2 from link3
  court.poses[1][1] = at_point(0.5, 0, 0);     // 0.3 from link1
  court.judge(1.0);
  const RefereeReport report = court.referee.report();
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

TEST(ContactReferee, FixedPartsAreJudgedAgainstObstaclesThatMove) {
  Obstacle rolls = ball_obstacle("rolls");
  rolls.motion = ConveyorMotion{};
  Obstacle falls = ball_obstacle("falls");
  falls.motion = DynamicMotion{};
  Court court({ball_arm("arm1", 2)}, {rolls, falls, ball_obstacle("pedestal")});
  court.poses[0][0] = at_point(0, 0, 0);
  for (auto& state : court.states) state.X_WO = at_point(0.05, 0, 0);
  court.judge(0.0);
  EXPECT_EQ(court.referee.report().kinds[kArmObstacle].contacts, 2U);
}

TEST(ContactReferee, WhatStandsAtAFixedPartIsJudgedAgainstMovingArmsOnly) {
  Court court({ball_arm("arm1", 2), ball_arm("arm2", 2)}, {ball_obstacle("pedestal")});
  court.poses[0][0] = at_point(0, 0, 0);
  court.poses[1][0] = at_point(0.05, 0, 0);
  court.states[0].X_WO = at_point(0, 0, 0.05);
  court.judge(0.0);
  EXPECT_EQ(court.referee.report().contacts, 0U);
  court.poses[1][1] = at_point(-0.05, 0, 0);
  court.judge(0.1);
  const RefereeReport report = court.referee.report();
  EXPECT_EQ(report.kinds[kArmArm].contacts, 1U);
  EXPECT_EQ(report.kinds[kArmObstacle].contacts, 1U);
}

TEST(ContactReferee, CountsAContactOnceUntilItHasParted) {
  Court court({ball_arm("arm1", 2)}, {ball_obstacle("pallet")});
  court.poses[0][1] = at_point(0, 0, 0);
  const auto at_distance = [&](double distance, double time) {
    court.states[0].X_WO = at_point(0.2 + distance, 0, 0);
    court.judge(time);
    return court.referee.report().contacts;
  };
  EXPECT_EQ(at_distance(0.0100, 0.0), 0U);
  EXPECT_EQ(at_distance(0.0005, 0.1), 0U);  // near is no contact
  EXPECT_EQ(at_distance(-0.0010, 0.2), 1U);
  EXPECT_EQ(at_distance(-0.0200, 0.3), 1U);
  EXPECT_EQ(at_distance(0.0005, 0.4), 1U);  // not yet parted
  EXPECT_EQ(at_distance(-0.0001, 0.5), 1U);
  EXPECT_EQ(at_distance(0.0015, 0.6), 1U);   // parted
  EXPECT_EQ(at_distance(-0.0001, 0.7), 2U);  // and again
  const RefereeReport report = court.referee.report();
  EXPECT_NEAR(report.smallest.distance, -0.02, 1e-9);
  EXPECT_NEAR(report.smallest.time, 0.3, 1e-12);
  ASSERT_EQ(report.events.size(), 2U);
  EXPECT_NEAR(report.events[0].distance, -0.001, 1e-9);
  EXPECT_NEAR(report.events[0].time, 0.2, 1e-12);
  EXPECT_NEAR(report.events[1].time, 0.7, 1e-12);
  EXPECT_EQ(report.events[0].b, "pallet");
}

TEST(ContactReferee, AContactIsOfLinksNotOfTheirShapes) {
  ArmBodies arm = ball_arm("arm1", 2);
  arm.parts.push_back({1, "link1", {Sphere{0.1}, at_point(0.05, 0, 0)}, true});
  Obstacle pallet = ball_obstacle("pallet");
  pallet.shapes.push_back({Box{Vector3d(0.1, 0.1, 0.1)}, at_point(0.1, 0, 0)});
  Court court({arm}, {pallet});
  court.poses[0][1] = at_point(0, 0, 0);
  court.states[0].X_WO = at_point(0.1, 0, 0);
  court.judge(0.0);
  EXPECT_EQ(court.referee.report().contacts, 1U);
}

TEST(ContactReferee, ResetBeginsAnew) {
  Court court({ball_arm("arm1", 2)}, {ball_obstacle("pallet")});
  court.poses[0][1] = at_point(0, 0, 0);
  court.states[0].X_WO = at_point(0.1, 0, 0);
  court.judge(0.0);
  court.referee.reset();
  EXPECT_EQ(court.referee.report().contacts, 0U);
  EXPECT_FALSE(court.referee.report().judged);
  EXPECT_TRUE(court.referee.report().events.empty());
  court.judge(0.1);
  EXPECT_EQ(court.referee.report().contacts, 1U);
  EXPECT_NEAR(court.referee.report().smallest.distance, -0.1, 1e-9);
}

TEST(ContactReferee, KeepsAtMostAHundredEventsButCountsAll) {
  Court court({ball_arm("arm1", 2)}, {ball_obstacle("pallet")});
  court.poses[0][1] = at_point(0, 0, 0);
  for (int i = 0; i < 240; ++i) {
    court.states[0].X_WO = at_point(i % 2 == 0 ? 1.0 : 0.1, 0, 0);
    court.judge(i);
  }
  EXPECT_EQ(court.referee.report().contacts, 120U);
  EXPECT_EQ(court.referee.report().events.size(), 100U);
}

TEST(ContactReferee, WhatAnArmCarriesIsPartOfIt) {
  ArmBodies arm = ball_arm("arm1", 4);
  arm.grasp_links = {2, 3};
  Obstacle box = ball_obstacle("box");
  box.attachment = Attachment{"arm1", Pose::Identity()};
  Court court({arm, ball_arm("arm2", 2)}, {box, ball_obstacle("pallet")});
  court.poses[0][2] = at_point(0, 0, 0.05);
  court.poses[0][3] = at_point(0, 0, 0.1);
  court.states[0].X_WO = at_point(0, 0, 0.15);  // in the hand: no contact with links 2 and 3
  court.states[1].X_WO = at_point(0, 0, 0.45);  // pallet: 0.3 − 0.2 above the box
  court.poses[1][1] = at_point(0.5, 0, 0.15);   // arm2: 0.5 − 0.2 beside the box
  court.poses[0][1] = at_point(0, -0.4, 0.15);  // own link1: 0.4 − 0.2 beside the box
  court.judge(0.0);
  const RefereeReport report = court.referee.report();
  EXPECT_EQ(report.contacts, 0U);
  EXPECT_NEAR(report.kinds[kArmObstacle].smallest.distance, 0.1, 1e-9);
  EXPECT_EQ(report.kinds[kArmObstacle].smallest.a, "arm1/box");
  EXPECT_NEAR(report.kinds[kArmArm].smallest.distance, 0.3, 1e-9);
  EXPECT_EQ(report.kinds[kArmArm].smallest.b, "arm1/box");
  EXPECT_EQ(report.kinds[kArmArm].smallest.a, "arm2/link1");
  EXPECT_NEAR(report.kinds[kArmSelf].smallest.distance, 0.2, 1e-9);
}

TEST(ContactReferee, WhatChangesHandsIsExcusedUntilItParts) {
  ArmBodies arm = ball_arm("arm1", 2);
  arm.grasp_links = {1};
  Court court({arm}, {ball_obstacle("table"), ball_obstacle("box")});
  court.poses[0][1] = at_point(0, 0, 0.41);
  court.states[0].X_WO = at_point(0, 0, 0.0);
  court.states[1].X_WO = at_point(0, 0, 0.2);  // rests on the table
  court.judge(0.0);
  EXPECT_EQ(court.referee.report().contacts, 0U);
  const double before = court.referee.report().smallest.distance;
  EXPECT_NEAR(before, 0.01, 1e-9);

  court.obstacles[1].attachment = Attachment{"arm1", at_point(0, 0, -0.21)};
  court.referee.set_obstacles(court.obstacles, "box");
  court.judge(0.1);
  EXPECT_EQ(court.referee.report().contacts, 0U) << "lying on the table is no contact of the arm";
  court.states[1].X_WO = at_point(0, 0, 0.25);
  court.judge(0.2);
  EXPECT_NEAR(court.referee.report().smallest.distance, 0.01, 1e-9);
  court.states[1].X_WO = at_point(0, 0, 0.19);
  court.judge(0.3);
  EXPECT_EQ(court.referee.report().contacts, 1U) << "once lifted, it must not hit the table";

  // Let go inside the hand: nothing to count until the hand has left and comes back.
  court.states[1].X_WO = at_point(0, 0, 0.35);
  court.obstacles[1].attachment.reset();
  court.referee.set_obstacles(court.obstacles, "box");
  court.judge(0.4);
  EXPECT_EQ(court.referee.report().contacts, 1U);
  court.poses[0][1] = at_point(0, 0, 0.6);
  court.judge(0.5);
  court.poses[0][1] = at_point(0, 0, 0.5);
  court.judge(0.6);
  EXPECT_EQ(court.referee.report().contacts, 2U);
}

TEST(ContactReferee, AnExcuseIsNoLicenceToPressHarder) {
  ArmBodies arm = ball_arm("arm1", 2);
  arm.grasp_links = {1};
  Court court({arm}, {ball_obstacle("table"), ball_obstacle("box")});
  court.poses[0][1] = at_point(0, 0, 0.5);
  court.states[1].X_WO = at_point(0, 0, 0.2);
  court.obstacles[1].attachment = Attachment{"arm1", at_point(0, 0, -0.3)};
  court.referee.set_obstacles(court.obstacles, "box");
  court.judge(0.0);
  court.states[1].X_WO = at_point(0, 0, 0.1995);
  court.judge(0.1);
  EXPECT_EQ(court.referee.report().contacts, 0U);
  court.states[1].X_WO = at_point(0, 0, 0.198);
  court.judge(0.2);
  EXPECT_EQ(court.referee.report().contacts, 1U);
}

TEST(ContactReferee, AContactThatLastsSurvivesEdits) {
  Court court({ball_arm("arm1", 2)}, {ball_obstacle("pallet")});
  court.poses[0][1] = at_point(0, 0, 0);
  court.states[0].X_WO = at_point(0.1, 0, 0);
  court.judge(0.0);
  court.obstacles.insert(court.obstacles.begin(), ball_obstacle("crate"));
  court.referee.set_obstacles(court.obstacles);
  court.states.insert(court.states.begin(), ObstacleState{at_point(50, 0, 0), {}, 0.0});
  court.judge(0.1);
  EXPECT_EQ(court.referee.report().contacts, 1U);
  EXPECT_EQ(court.referee.report().smallest.b, "pallet");
}

TEST(ContactReferee, NearestIsTheCurrentSeparationOfOneArm) {
  Court court({ball_arm("arm1", 2), ball_arm("arm2", 2)}, {ball_obstacle("pallet")});
  court.poses[0][1] = at_point(0, 0, 0);
  court.states[0].X_WO = at_point(0.5, 0, 0);
  court.judge(0.0);
  court.states[0].X_WO = at_point(1.0, 0, 0);
  court.judge(0.1);
  EXPECT_NEAR(court.referee.report().smallest.distance, 0.3, 1e-9);
  ASSERT_TRUE(court.referee.nearest(0).has_value());
  EXPECT_NEAR(court.referee.nearest(0)->distance, 0.8, 1e-9);
  EXPECT_EQ(court.referee.nearest(0)->b, "pallet");
  EXPECT_NEAR(court.referee.nearest(0)->time, 0.1, 1e-12);
}

TEST(ContactReferee, BadSelfPairsAndMissingPosesThrow) {
  ArmBodies arm = ball_arm("arm1", 2);
  arm.self_pairs = {{0, 2}};
  EXPECT_THROW(ContactReferee({arm}), std::invalid_argument);
  ContactReferee referee({ball_arm("arm1", 2)});
  EXPECT_THROW(referee.judge({}, {}, 0.0), std::invalid_argument);
  const std::vector<Pose> one_link(1, Pose::Identity());
  const MeasuredArm measured{true, one_link};
  EXPECT_THROW(referee.judge(std::span(&measured, 1), {}, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace hecaton::world
