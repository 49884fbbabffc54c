#include <gtest/gtest.h>

#include "planner/simulation/arm_in_world.hpp"
#include "services/messages/convert.hpp"
#include "services/world/world_edit.hpp"
#include "services/world/world_topics.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton::services {
namespace {

world::Obstacle ball(const std::string& name) {
  world::Obstacle obstacle;
  obstacle.name = name;
  obstacle.shapes.push_back({world::Sphere{0.1}});
  return obstacle;
}

msg::WorldEditRequest request(msg::EditKind kind, const std::string& name) {
  msg::WorldEditRequest message;
  message.kind(kind);
  message.name(name);
  message.X_WO().qw(1.0);
  return message;
}

class Edit : public testing::Test {
 protected:
  world::BulletWorld world_{world::Scene{{ball("a")}, 0.0, {0, 0, -9.81}}, {}};
  EditedCell cell_;  // without arms
};

TEST_F(Edit, AddsMovesAndRemoves) {
  msg::WorldEditRequest add = request(msg::EditKind::EDIT_ADD, "ignored");
  add.obstacle(messages::to_message(ball("b")));
  EXPECT_EQ(edited_name(add), "b");
  ASSERT_TRUE(apply_edit(world_, cell_, add).done());
  ASSERT_EQ(world_.obstacles().size(), 2U);
  msg::WorldEditRequest move = request(msg::EditKind::EDIT_MOVE, "b");
  move.X_WO().position().y(0.25);
  ASSERT_TRUE(apply_edit(world_, cell_, move).done());
  EXPECT_EQ(world_.snapshot().states[1].X_WO.translation().y(), 0.25);
  ASSERT_TRUE(apply_edit(world_, cell_, request(msg::EditKind::EDIT_REMOVE, "a")).done());
  ASSERT_EQ(world_.obstacles().size(), 1U);
  EXPECT_EQ(world_.obstacles()[0].name, "b");
}

TEST_F(Edit, ReplacesAtOnceOrNotAtAll) {
  const auto replace = [&](const world::Obstacle& obstacle) {
    msg::WorldEditRequest edit = request(msg::EditKind::EDIT_REPLACE, "ignored");
    edit.obstacle(messages::to_message(obstacle));
    EXPECT_EQ(edited_name(edit), obstacle.name);
    return apply_edit(world_, cell_, edit);
  };
  world::Obstacle box = ball("a");
  box.shapes = {{world::Box{{0.1, 0.2, 0.3}}, world::Pose::Identity()}};
  box.X_WO.translation().y() = 0.25;
  const std::uint64_t before = world_.edition();
  ASSERT_TRUE(replace(box).done());
  EXPECT_EQ(world_.edition(), before + 1) << "no edition without the obstacle";
  ASSERT_EQ(world_.obstacles().size(), 1U);
  EXPECT_TRUE(std::holds_alternative<world::Box>(world_.obstacles()[0].shapes.at(0).shape));
  EXPECT_EQ(world_.snapshot().states[0].X_WO.translation().y(), 0.25);

  world::Obstacle far = ball("a");
  far.X_WO.translation().x() = 101.0;
  EXPECT_EQ(replace(far).reason, "obstacle 'a': pose.xyz[0] = 101 m must be between -100 and 100 m");
  world::Obstacle carried = ball("a");
  carried.attachment = {"unknown", world::Pose::Identity()};
  EXPECT_FALSE(replace(carried).done());
  EXPECT_TRUE(std::holds_alternative<world::Box>(world_.obstacles()[0].shapes.at(0).shape));
  EXPECT_EQ(world_.edition(), before + 1);

  ASSERT_TRUE(replace(ball("b")).done()) << "there is none yet";
  EXPECT_EQ(world_.obstacles().size(), 2U);
}

TEST_F(Edit, FollowsWhatAGripperGraspsAndReleases) {
  world::ArmBodies north;
  north.name = "north";
  north.parts.push_back({0, "hand", {world::Sphere{0.05}}});
  world_ = world::BulletWorld(world::Scene{{ball("a")}, 0.0, {0, 0, -9.81}}, {north});
  const std::vector<world::Pose> links{world::Pose::Identity()};
  ASSERT_TRUE(world_.set_arm(0, links, world::Pose::Identity()));
  msg::ToolState tool;
  tool.arm("north");
  EXPECT_FALSE(edit_of(world_, tool));
  tool.grasping("a");
  auto edit = edit_of(world_, tool);
  ASSERT_TRUE(edit);
  EXPECT_EQ(edit->kind(), msg::EditKind::EDIT_ATTACH);
  ASSERT_TRUE(apply_edit(world_, cell_, *edit).done());
  EXPECT_FALSE(edit_of(world_, tool)) << "it is attached already";
  tool.grasping("");
  tool.holding("a");
  EXPECT_FALSE(edit_of(world_, tool));
  tool.holding("");
  EXPECT_FALSE(edit_of(world_, tool)) << "only what is released is detached";
  tool.releasing("a");
  edit = edit_of(world_, tool);
  ASSERT_TRUE(edit);
  EXPECT_EQ(edit->kind(), msg::EditKind::EDIT_DETACH);
  tool.arm("south");
  EXPECT_FALSE(edit_of(world_, tool)) << "another arm carries it";
  ASSERT_TRUE(apply_edit(world_, cell_, *edit).done());
  EXPECT_FALSE(world_.obstacles()[0].attachment);
}

TEST_F(Edit, RefusesUnusableMessagesWithASentence) {
  msg::WorldEditRequest add = request(msg::EditKind::EDIT_ADD, "");
  EXPECT_EQ(apply_edit(world_, cell_, add).reason, "obstacle: name must not be empty");
  msg::WorldEditRequest move = request(msg::EditKind::EDIT_MOVE, "a");
  move.X_WO().qw(0.5);
  const world::EditResult refused = apply_edit(world_, cell_, move);
  EXPECT_FALSE(refused.done());
  EXPECT_NE(refused.reason.find("obstacle \"a\": X_WO: quaternion"), std::string::npos) << refused.reason;
  msg::WorldEditRequest unknown = request(static_cast<msg::EditKind>(77), "a");
  EXPECT_FALSE(apply_edit(world_, cell_, unknown).done());
  EXPECT_EQ(world_.snapshot().edition, world::BulletWorld(world::Scene{{ball("a")}}, {}).snapshot().edition);
}

TEST_F(Edit, AppliesTheRulesOfTheCellFile) {
  const auto refusal = [&](const world::Obstacle& obstacle) {
    msg::WorldEditRequest add = request(msg::EditKind::EDIT_ADD, "");
    add.obstacle(messages::to_message(obstacle));
    return apply_edit(world_, cell_, add).reason;
  };
  EXPECT_EQ(refusal(ball("two words")),
            "obstacle 'two words': name = \"two words\" must be a name of 1 to 64 characters: a to z, A to Z, 0 to 9, "
            "'_', '-' or '.'");
  EXPECT_EQ(refusal(ball("a")), "obstacle 'a': name = a must be unique, but another obstacle has the same name");
  world::Obstacle far = ball("far");
  far.X_WO.translation().x() = 101.0;
  EXPECT_EQ(refusal(far), "obstacle 'far': pose.xyz[0] = 101 m must be between -100 and 100 m");
  msg::WorldEditRequest move = request(msg::EditKind::EDIT_MOVE, "a");
  move.X_WO().position().z(-100.5);
  EXPECT_EQ(apply_edit(world_, cell_, move).reason,
            "obstacle 'a': pose.xyz[2] = -100.5 m must be between -100 and 100 m");
  EXPECT_EQ(world_.obstacles().size(), 1U);
  EXPECT_EQ(world_.snapshot().states[0].X_WO.translation().z(), 0.0);
}

TEST(TakenRequestsTest, TellRepeatedRequestsFromNewOnes) {
  TakenRequests taken;
  msg::WorldEditRequest one;
  one.client("a");
  EXPECT_TRUE(taken.take(one));
  EXPECT_TRUE(taken.take(one)) << "without a number";
  one.request_id(1);
  EXPECT_TRUE(taken.take(one));
  EXPECT_FALSE(taken.take(one));
  msg::WorldEditRequest other = one;
  other.client("b");
  EXPECT_TRUE(taken.take(other));
  for (std::uint64_t id = 2; id <= 1001; ++id) {
    other.request_id(id);
    EXPECT_TRUE(taken.take(other));
  }
  EXPECT_TRUE(taken.take(one)) << "forgotten";
}

TEST(MeasuredArmsTest, MoveOnWithTheirVelocityUntilTheNextState) {
  const config::CellFile file =
      config::load_cell_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/planar_2r.yaml");
  const planner::Arm& arm = file.cell.arms[0].arm;
  const test::FreeDomain domain;
  bus::ParticipantOptions options;
  options.interfaces = {"127.0.0.1"};
  bus::Participant driver(domain.number(), "driver", options);
  bus::Participant participant(domain.number(), "world", options);
  bus::Mailbox mailbox;
  MeasuredArms arms(file, participant, mailbox);
  bus::Writer<msg::ArmState> writer(driver);
  std::vector<world::ArmBodies> bodies;
  for (const planner::PlannedArm& planned : file.cell.arms) bodies.push_back(planner::arm_bodies(planned.arm));
  world::BulletWorld world(file.cell.scene, bodies);
  msg::ArmState state;
  state.arm(arm.name);
  state.q().assign(static_cast<std::size_t>(arm.model->joints()), 0.1);
  state.qd().assign(state.q().size(), 2.0);
  const auto until = bus::Clock::now() + std::chrono::seconds(20);
  while (!arms.arrivals()[0] && bus::Clock::now() < until) {
    ASSERT_TRUE(writer.write(state));
    static_cast<void>(mailbox.wait(std::chrono::milliseconds(50)));
    arms.update(world, bus::Clock::now());
  }
  ASSERT_TRUE(arms.arrivals()[0]);
  arms.update(world, *arms.arrivals()[0] + std::chrono::seconds(1));
  const auto received = *arms.arrivals()[0];
  const auto first_joint = [&](std::chrono::milliseconds later) {
    arms.update(world, received + later);
    return (*arms.q()[0])[0];
  };
  EXPECT_NEAR(first_joint(std::chrono::milliseconds(-5)), 0.1, 1e-9);
  EXPECT_NEAR(first_joint(std::chrono::milliseconds(10)), 0.12, 1e-9);
  EXPECT_NEAR(first_joint(std::chrono::seconds(1)), 0.16, 1e-9);  // 30 ms at most
}

TEST(ContactReportMessage, CarriesAllFields) {
  world::ContactReport report;
  report.contacts = 2;
  report.has_smallest = true;
  report.smallest = {-0.003, world::ContactKind::kArmObstacle, "arm1/hand", "pallet", 1.5};
  report.kinds[1] = {2, true, report.smallest};
  report.events = {report.smallest};
  const msg::ContactReport message = contact_report(report, 7.25, true);
  EXPECT_TRUE(message.running());
  EXPECT_EQ(message.time(), 7.25);
  EXPECT_EQ(message.contacts(), 2U);
  EXPECT_EQ(message.smallest().distance(), -0.003);
  ASSERT_EQ(message.kinds().size(), 3U);
  EXPECT_EQ(message.kinds()[1].kind(), msg::ContactKind::CONTACT_ARM_OBSTACLE);
  EXPECT_EQ(message.kinds()[1].contacts(), 2U);
  EXPECT_EQ(message.kinds()[1].smallest().b(), "pallet");
  EXPECT_FALSE(message.kinds()[0].has_smallest());
  ASSERT_EQ(message.events().size(), 1U);
  EXPECT_EQ(message.events()[0].a(), "arm1/hand");
}

}  // namespace
}  // namespace hecaton::services
