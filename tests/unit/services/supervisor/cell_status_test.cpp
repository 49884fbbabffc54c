// The status of a cell from values, without a network.

#include "services/supervisor/cell_status.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/node_name.hpp"
#include "services/supervisor/cell_publisher.hpp"
#include "services/supervisor/expected_nodes.hpp"
#include "services/supervisor/replication/unreplicated.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

const std::string kCell = std::string(HECATON_SOURCE_DIR) + "/tests/cell/supervision/health_cell.yaml";

class CellStatusTest : public ::testing::Test {
 protected:
  CellStatusTest() {
    watch_.faults().begin_term(3);
    turn(10ms);
    for (const ExpectedNode& node : watch_.nodes()) heartbeat(node.name, msg::NodeState::NODE_RUNNING, {});
    for (const auto* arm : {"left", "right"}) state(arm, msg::ArmMode::ARM_RUNNING, 0.0, {});
    watch_.stream_heard("world", now_);
    watch_.judge(now_);
  }

  void turn(Time step) {
    now_ += step;
    watch_.advance(now_);
  }
  [[nodiscard]] bus::Clock::time_point at() const { return bus::Clock::time_point(now_); }
  void heartbeat(const std::string& node, msg::NodeState node_state, const std::string& detail) {
    msg::Heartbeat heartbeat;
    heartbeat.node(node);
    heartbeat.host("localhost");
    heartbeat.pid(1);
    heartbeat.state(node_state);
    if (!detail.empty()) heartbeat.cause(make_cause(msg::CauseKind::CAUSE_ARM_STATE_OLD, {}, detail));
    snapshot_.heartbeats.insert_or_assign(node, Received<msg::Heartbeat>{heartbeat, at(), {}});
    watch_.heard(node, {1, now_});
  }
  void state(const std::string& arm, msg::ArmMode mode, double speed, const std::string& reason) {
    msg::ArmState message;
    message.arm(arm);
    message.mode(mode);
    if (mode != msg::ArmMode::ARM_RUNNING) {
      const bool starts = mode == msg::ArmMode::ARM_STARTING;
      message.cause(
          make_cause(starts ? msg::CauseKind::CAUSE_STARTING : msg::CauseKind::CAUSE_COMMANDS_CEASED, arm, reason));
    }
    message.q({0.0, 0.0});
    message.qd({0.0, speed});
    snapshot_.update_observed(message);
    snapshot_.arms.insert_or_assign(arm, Received<msg::ArmState>{message, at(), {}});
    watch_.stream_heard(driver_node(arm), now_);
  }
  bus::Sample<msg::GoalStatus> goal(std::uint64_t sequence, const std::string& name, msg::GoalState goal_state) {
    bus::Sample<msg::GoalStatus> sample;
    sample.value.arm("left");
    sample.value.goal(name);
    sample.value.sequence_number(sequence);
    sample.value.state(goal_state);
    sample.received = at();
    return sample;
  }
  static bus::Sample<msg::Heartbeat> beat_of_left(std::uint64_t sequence) {
    bus::Sample<msg::Heartbeat> sample;
    sample.value.node(planner_node("left"));
    sample.value.kind(msg::NodeKind::NODE_PLANNER);
    sample.value.subject("left");
    sample.value.pid(1);
    sample.value.sequence_number(sequence);
    return sample;
  }
  msg::CellStatus status() { return cell_status({file_, watch_, snapshot_, failover_, mode_}, {now_, 1'000'000}); }
  std::string waits() { return waiting_for("left", watch_, snapshot_).text(); }

  config::CellFile file_ = config::load_cell_file(kCell);
  Time now_ = 100s;
  FaultDetector watch_{expected_nodes(file_, "supervisor"), arm_names(file_), detection_limits(file_, 5ms), now_};
  CellSnapshot snapshot_;
  PlannerFailover failover_{arms_with_standby(file_)};
  msg::CellMode mode_;
};

// Else a client would refuse the answer to each of its orders.
TEST_F(CellStatusTest, StaysAcceptableWhateverOthersSay) {
  const std::string text(16'384, 'x');
  const std::string name(150, 'n');
  const auto speak = [&](const std::string& node) {
    msg::Heartbeat heartbeat;
    heartbeat.node(node);
    heartbeat.cause(make_cause(msg::CauseKind::CAUSE_NODE_FAILED, name, text));
    heartbeat.oldest_input(name);
    for (int i = 0; i < 2; ++i) {
      msg::Refusal refusal;
      refusal.cause(make_cause(msg::CauseKind::CAUSE_INPUT_REFUSED, name, text));
      heartbeat.refusals().push_back(refusal);
    }
    ASSERT_FALSE(bus::Writer<msg::Heartbeat>::refusal_of(heartbeat));
    snapshot_.heartbeats.insert_or_assign(node, Received<msg::Heartbeat>{heartbeat, at(), {}});
    watch_.heard(node, {1, now_, 0, heartbeat.cause()});
  };
  for (int i = 0; i < 256; ++i) speak(name + std::to_string(i));
  for (const ExpectedNode& node : watch_.nodes()) speak(node.name);
  for (const auto* arm : {"left", "right"}) {
    state(arm, msg::ArmMode::ARM_STOPPED, 0.0, text);
    snapshot_.arms.at(arm).value.carried(text);
  }
  bus::EndpointId intruder;
  intruder.bytes[0] = 7;
  snapshot_.states = Received<msg::ObstacleStates>{{}, at(), {}};
  for (int i = 0; i < 4000; ++i) {
    Received<msg::ObstacleShapes> shapes{{}, at(), intruder};
    shapes.value.name(name + std::to_string(i));
    shapes.value.obstacle().shapes().resize(64);
    snapshot_.obstacles.insert_or_assign(shapes.value.name(), shapes);
  }
  watch_.judge(now_);
  mode_ = watch_.mode().decide();
  msg::SupervisorReply reply;
  reply.status(status());
  EXPECT_EQ(bus::Writer<msg::SupervisorReply>::refusal_of(reply), std::nullopt);
  EXPECT_EQ(bus::Writer<msg::CellMode>::refusal_of(mode_), std::nullopt);
  EXPECT_TRUE(reply.status().obstacles().empty()) << "forged";
  for (const FaultRecord& fault : watch_.faults().open()) {
    const msg::Fault message = fault_message(fault, {now_, 1'000'000});
    EXPECT_EQ(bus::Writer<msg::Fault>::refusal_of(message), std::nullopt);
    EXPECT_TRUE(fault.description.ends_with("…"));
  }
}

TEST_F(CellStatusTest, KeepsACellModeOfManyArmsWithinItsLimit) {
  std::vector<std::string> arms;
  AutomaticHolds holds;
  for (int i = 0; i < 128; ++i) {
    arms.push_back("arm" + std::to_string(i));
    holds.arms.emplace(arms.back(), make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "north", std::string(16'384, 'x')));
  }
  CellModeState mode(arms);
  mode.set_automatic(holds);
  EXPECT_EQ(bus::Writer<msg::CellMode>::refusal_of(mode.decide()), std::nullopt);
  EXPECT_EQ(mode.decide().arms().size(), arms.size());
}

TEST_F(CellStatusTest, ExpectsTheNodesOfTheCellFile) {
  std::vector<std::string> names;
  for (const ExpectedNode& node : expected_nodes(file_, "supervisor")) names.push_back(node.name);
  EXPECT_EQ(names, (std::vector<std::string>{"world", "driver/left", "planner/left", "driver/right", "planner/right",
                                             "agent/localhost"}));
  const DetectionLimits limits = detection_limits(file_, 5ms);
  EXPECT_EQ(limits.node.silence, 250ms);
  EXPECT_EQ(limits.host_lease, 500ms);
  EXPECT_EQ(limits.arm_stream, 250ms);
}

TEST_F(CellStatusTest, WaitsForAGoalInAHealthyCell) {
  EXPECT_EQ(waits(), "a goal");
}

TEST_F(CellStatusTest, HasNoCauseForAMovingArm) {
  state("left", msg::ArmMode::ARM_RUNNING, 0.2, {});
  EXPECT_EQ(waits(), "");
}

TEST_F(CellStatusTest, ReportsTheEndOfTheLastGoalWhileTheArmBrakes) {
  snapshot_.update_goal(goal(1, "g1", msg::GoalState::GOAL_REACHED));
  state("left", msg::ArmMode::ARM_RUNNING, 0.2, {});
  EXPECT_EQ(waits(), "a goal; the last was reached");
  state("left", msg::ArmMode::ARM_RUNNING, 0.0, {});
  EXPECT_EQ(waits(), "a goal; the last was reached");
}

TEST_F(CellStatusTest, WaitsForAGoalWhenTheDriveStartsAfterTheEndOfAGoal) {
  snapshot_.update_goal(goal(1, "g1", msg::GoalState::GOAL_REACHED));
  state("left", msg::ArmMode::ARM_STARTING, 0.0, {});
  EXPECT_EQ(waits(), "a goal; the last was reached");
  EXPECT_EQ(waiting_for("left", watch_, snapshot_).kind(), msg::CauseKind::CAUSE_NO_GOAL);
  snapshot_.update_goal(goal(2, "g2", msg::GoalState::GOAL_ACTIVE));
  EXPECT_EQ(waiting_for("left", watch_, snapshot_).kind(), msg::CauseKind::CAUSE_STARTING);
}

TEST_F(CellStatusTest, NamesTheBodyThatBlocksTheGoal) {
  auto blocked = goal(1, "g1", msg::GoalState::GOAL_BLOCKED);
  blocked.value.cause(make_cause(msg::CauseKind::CAUSE_PATH_BLOCKED, "pallet", "no way for now"));
  blocked.value.has_binding(true);
  blocked.value.binding_own("left/forearm");
  blocked.value.binding_other("pallet");
  blocked.value.binding_distance(0.0184);
  snapshot_.update_goal(blocked);
  EXPECT_EQ(waits(), "blocked: no way for now (left/forearm – pallet, 18 mm)");
}

TEST_F(CellStatusTest, UsesTheCauseKindsOfPlannerAndDriver) {
  auto yielding = goal(1, "g1", msg::GoalState::GOAL_ACTIVE);
  snapshot_.update_goal(yielding);
  EXPECT_TRUE(is_none(waiting_for("left", watch_, snapshot_))) << "it is about to move";
  yielding = goal(2, "g1", msg::GoalState::GOAL_ACTIVE);
  yielding.value.cause(make_cause(msg::CauseKind::CAUSE_GIVING_WAY, "right", "gives way to right"));
  snapshot_.update_goal(yielding);
  EXPECT_EQ(waiting_for("left", watch_, snapshot_).kind(), msg::CauseKind::CAUSE_GIVING_WAY);
  EXPECT_EQ(waiting_for("left", watch_, snapshot_).subject(), "right");
  state("left", msg::ArmMode::ARM_STOPPED, 0.0, "no command for 60 ms");
  EXPECT_EQ(waiting_for("left", watch_, snapshot_).kind(), msg::CauseKind::CAUSE_COMMANDS_CEASED);
}

TEST_F(CellStatusTest, PrefersTheDriversCauseToTheGoals) {
  snapshot_.update_goal(goal(1, "g1", msg::GoalState::GOAL_ACTIVE));
  state("left", msg::ArmMode::ARM_STOPPED, 0.0, "no command for 60 ms");
  EXPECT_EQ(waits(), "driver has stopped: no command for 60 ms");
}

TEST_F(CellStatusTest, PrefersTheCauseOfADegradedPlannerToTheDrivers) {
  state("left", msg::ArmMode::ARM_STOPPED, 0.0, "no command for 60 ms");
  heartbeat("planner/left", msg::NodeState::NODE_DEGRADED, "no state of right for 0.2 s");
  EXPECT_EQ(waits(), "planner/left: no state of right for 0.2 s");
}

TEST_F(CellStatusTest, PrefersOrdersToAllOtherCauses) {
  watch_.process_exited("planner/left", {1, -1, 9, false});
  watch_.judge(now_);
  EXPECT_EQ(waits(), "held: planner/left: process 1 was ended by signal 9 (Killed)");
  EXPECT_TRUE(is_none(watch_.mode().stop({"left"})));
  EXPECT_TRUE(waits().starts_with("on stop by operator: waits for resume; held: "));
}

TEST_F(CellStatusTest, KeepsTheNewestGoalInAnyOrderOfArrival) {
  snapshot_.update_goal(goal(8, "g2", msg::GoalState::GOAL_ACTIVE));
  snapshot_.update_goal(goal(5, "g1", msg::GoalState::GOAL_REACHED));
  EXPECT_EQ(snapshot_.goals.at("left").value.goal(), "g2");
  EXPECT_EQ(status().arms()[0].goal().goal(), "g2");
  EXPECT_FALSE(status().arms()[1].has_goal());
}

TEST_F(CellStatusTest, PrefersTheGoalOfTheNewPlanner) {
  snapshot_.update_goal(goal(800, "g1", msg::GoalState::GOAL_ACTIVE));
  auto next = goal(1, "g2", msg::GoalState::GOAL_ACCEPTED);
  next.writer.bytes[0] = 1;
  snapshot_.update_goal(next);
  EXPECT_EQ(snapshot_.goals.at("left").value.goal(), "g2");
}

TEST_F(CellStatusTest, LosesTheGoalOfARestartedPlannerUnlessItIsPublishedAgain) {
  auto heartbeat = beat_of_left(800);
  snapshot_.update_heartbeat(heartbeat);
  auto active = goal(800, "g1", msg::GoalState::GOAL_ACTIVE);
  active.value.node(planner_node("left"));
  snapshot_.update_goal(active);
  snapshot_.update_heartbeat(beat_of_left(801));
  EXPECT_TRUE(status().arms()[0].has_goal());
  // The successor has the same pid, as in a container, and a higher sequence number.
  heartbeat = beat_of_left(900);
  heartbeat.writer.bytes[0] = 1;
  snapshot_.update_heartbeat(heartbeat);
  EXPECT_FALSE(status().arms()[0].has_goal());
  EXPECT_EQ(waits(), "a goal; g1 was lost with the process of planner/left");
  snapshot_.update_goal(goal(1, "g1", msg::GoalState::GOAL_ACTIVE));
  EXPECT_TRUE(status().arms()[0].has_goal());
  // The status of an ended goal stays valid.
  snapshot_.update_goal(goal(2, "g1", msg::GoalState::GOAL_REACHED));
  heartbeat.writer.bytes[0] = 2;
  snapshot_.update_heartbeat(heartbeat);
  EXPECT_EQ(waits(), "a goal; the last was reached");
}

TEST_F(CellStatusTest, DetectsANewPlannerProcessByItsSequenceNumber) {
  snapshot_.update_heartbeat(beat_of_left(800));
  auto active = goal(800, "g1", msg::GoalState::GOAL_ACTIVE);
  active.value.node(planner_node("left"));
  snapshot_.update_goal(active);
  snapshot_.update_heartbeat(beat_of_left(1));  // its endpoint has the same id, too
  EXPECT_EQ(waits(), "a goal; g1 was lost with the process of planner/left");
}

TEST_F(CellStatusTest, MeasuresAgesFromArrival) {
  turn(40ms);
  const auto told = status();
  ASSERT_EQ(told.arms().size(), 2U);
  EXPECT_NEAR(told.arms()[0].state_age(), 0.040, 1e-9);
  EXPECT_LT(told.arms()[0].goal_age(), 0.0);
  EXPECT_NEAR(told.nodes()[0].age(), 0.040, 1e-9);
  EXPECT_NEAR(told.hosts()[0].age(), 0.040, 1e-9);
  EXPECT_LT(told.contact_report_age(), 0.0);
  // A driver whose device fails repeats its last measurement.
  msg::ArmState& left = snapshot_.arms.at("left").value;
  left.command_age(-60.0);
  left.mode(msg::ArmMode::ARM_FAILED);
  EXPECT_DOUBLE_EQ(status().arms()[0].state_age(), 60.0);
}

TEST_F(CellStatusTest, ListsUnheardNodesAsAwaited) {
  snapshot_.heartbeats.erase("planner/left");
  FaultDetector fresh(expected_nodes(file_, "supervisor"), arm_names(file_), detection_limits(file_, 5ms), now_);
  const auto told = cell_status({file_, fresh, snapshot_, failover_, mode_}, {now_, 0});
  const auto& nodes = told.nodes();
  const auto found = std::find_if(nodes.begin(), nodes.end(),
                                  [](const auto& node) { return node.heartbeat().node() == "planner/left"; });
  ASSERT_NE(found, nodes.end());
  EXPECT_FALSE(found->alive());
  EXPECT_LT(found->age(), 0.0);
  EXPECT_EQ(found->heartbeat().kind(), msg::NodeKind::NODE_PLANNER);
  EXPECT_EQ(found->heartbeat().cause(),
            make_cause(msg::CauseKind::CAUSE_NODE_MISSING, "planner/left", "planner/left has not appeared yet"));
}

TEST_F(CellStatusTest, KeepsIdentityAndBeginningOfFaults) {
  watch_.process_exited("planner/left", {1, -1, 9, false});
  watch_.judge(now_);
  turn(2s);
  const auto told = status();
  ASSERT_GE(told.faults().size(), 1U);
  const msg::Fault& fault = told.faults()[0];
  EXPECT_EQ(fault.id(), "f3-1");
  EXPECT_EQ(fault.cause().kind(), msg::CauseKind::CAUSE_PROCESS_DIED);
  EXPECT_EQ(fault.since_ns(), (now_ - 2s).count());
  EXPECT_EQ(fault.since_unix_ms(), 998'000);
  EXPECT_FALSE(fault.cleared());
}

TEST_F(CellStatusTest, ReportsTheModeOfEachArm) {
  EXPECT_TRUE(is_none(watch_.mode().hold({"right"})));
  const msg::CellMode message = mode_message(watch_.mode(), failover_, "supervisor");
  EXPECT_EQ(message.mode(), msg::Mode::MODE_RUN);
  EXPECT_EQ(arms_on(message, msg::Mode::MODE_HOLD), std::vector<std::string>{"right"});
  EXPECT_EQ(causes_text(message), "right: hold by operator");
  EXPECT_TRUE(message.leases().empty()) << "no arm has a standby";
  EXPECT_EQ(status().arms()[0].mode(), msg::Mode::MODE_RUN);
  EXPECT_EQ(status().arms()[1].mode(), msg::Mode::MODE_HOLD);
}

TEST_F(CellStatusTest, SeparatesOrdersFromAutomaticHolds) {
  EXPECT_TRUE(is_none(watch_.mode().hold({"right"})));
  EXPECT_TRUE(is_none(watch_.mode().stop({"left"})));
  watch_.process_exited("world", {1, -1, 9, false});
  watch_.judge(now_);
  const msg::CellMode message = mode_message(watch_.mode(), failover_, "supervisor");
  EXPECT_EQ(message.mode(), msg::Mode::MODE_HOLD) << "because of the world";
  EXPECT_EQ(orders_in(message), watch_.mode().orders());
  EXPECT_EQ(orders_in(message).cell, msg::Mode::MODE_RUN);
}

TEST_F(CellStatusTest, ConvertsFaultsOfAnotherSupervisorUnchanged) {
  watch_.process_exited("planner/left", {1, -1, 9, false});
  watch_.judge(now_);
  turn(500ms);
  heartbeat("planner/left", msg::NodeState::NODE_RUNNING, {});
  watch_.process_exited("driver/right", {1, -1, 9, false});
  watch_.judge(now_);
  const FaultHistory before = watch_.faults().history();
  ASSERT_FALSE(before.open.empty());
  std::map<std::string, msg::Fault> told;
  for (const auto& [cause, record] : before.open) {
    msg::Fault fault = fault_message(record, {now_, 1'000'000});
    fault.term(7);
    told[fault.id()] = fault;
  }
  // On a host whose steady clock began 50 s later.
  FaultHistory after = fault_history_of(told, 7, {now_ - 50s, 1'000'000});
  ASSERT_EQ(after.open.size(), before.open.size());
  for (auto& [cause, record] : after.open) {
    ASSERT_TRUE(before.open.contains(cause)) << cause;
    record.since += 50s;
    EXPECT_EQ(record, before.open.at(cause)) << cause;
  }
}

// Two supervisors published one death as a fault each; the leader cleared its own.
TEST_F(CellStatusTest, ClearsFaultsThatTheLastLeaderDidNotPublish) {
  watch_.process_exited("planner/left", {1, -1, 9, false});
  watch_.judge(now_);
  msg::Fault fault = fault_message(watch_.faults().open().front(), {now_, 1'000'000});
  fault.term(7);
  const FaultHistory after = fault_history_of({{fault.id(), fault}}, 8, {now_ + 1s, 1'001'000});
  EXPECT_TRUE(after.open.empty());
  ASSERT_EQ(after.cleared.size(), 1U);
  EXPECT_EQ(after.cleared.front().cleared_at, now_ + 1s);
}

TEST_F(CellStatusTest, RemovesUnreplicatedFaultsThatALaterLeaderPublished) {
  watch_.process_exited("planner/left", {1, -1, 9, false});
  watch_.judge(now_);
  UnreplicatedFaults unreplicated;
  EXPECT_FALSE(unreplicated.remove_published({})) << "nothing is pending";
  unreplicated.step_down(watch_.faults().history(), 7);
  ASSERT_EQ(unreplicated.pending().size(), 1U);
  msg::Fault fault = fault_message(watch_.faults().open().front(), {now_, 1'000'000});
  EXPECT_EQ(unreplicated.pending().begin()->first, fault.id());
  EXPECT_EQ(unreplicated.pending().begin()->second.key, "planner/left");
  fault.term(6);
  EXPECT_FALSE(unreplicated.remove_published({{fault.id(), fault}}));
  fault.term(8);
  EXPECT_TRUE(unreplicated.remove_published({{fault.id(), fault}}));
  EXPECT_TRUE(unreplicated.pending().empty());
  EXPECT_FALSE(unreplicated.remove_published({{fault.id(), fault}})) << "only once";
}

TEST_F(CellStatusTest, JudgesAnArmAtOnePercentByItsSpeed) {
  snapshot_.update_goal(goal(1, "way", msg::GoalState::GOAL_ACTIVE));
  state("left", msg::ArmMode::ARM_RUNNING, 5e-4, {});
  EXPECT_TRUE(stands_without_reason("left", watch_, snapshot_));
  EXPECT_TRUE(is_none(watch_.mode().set_speed({"left"}, 0.01)));
  EXPECT_FALSE(stands_without_reason("left", watch_, snapshot_)) << "0.5 mrad/s is motion at 1 %";
  EXPECT_EQ(status().arms()[0].speed(), 0.01);
  state("left", msg::ArmMode::ARM_RUNNING, 0.0, {});
  EXPECT_TRUE(stands_without_reason("left", watch_, snapshot_));
}

TEST_F(CellStatusTest, NamesADriverThatRefusesItsPlanner) {
  const auto refuses = [this](msg::CauseKind kind) {
    state("left", msg::ArmMode::ARM_STOPPED, 0.0, "");
    snapshot_.arms.at("left").value.cause(make_cause(kind, "planner/left", "term 3 is outdated"));
    return stands_without_reason("left", watch_, snapshot_);
  };
  EXPECT_EQ(refuses(msg::CauseKind::CAUSE_COMMAND_REFUSED), "driver has stopped: term 3 is outdated")
      << "also without a goal";
  EXPECT_EQ(refuses(msg::CauseKind::CAUSE_COMMAND_TOO_FAR), "driver has stopped: term 3 is outdated");
  EXPECT_FALSE(refuses(msg::CauseKind::CAUSE_COMMANDS_CEASED)) << "no goal";
  EXPECT_FALSE(refuses(msg::CauseKind::CAUSE_HOLD_ORDERED)) << "a person wants it";
  // The reason of the cell comes first.
  EXPECT_TRUE(is_none(watch_.mode().stop({})));
  EXPECT_FALSE(refuses(msg::CauseKind::CAUSE_COMMAND_REFUSED));
}

// The cell learns of the end at once, and both arms have been last heard at rest.
TEST_F(CellStatusTest, ListsOnlyLostArmsThatTheirControllersStop) {
  const auto lost = [this](std::vector<bool> stop_without_driver) {
    std::vector<std::string> names;
    for (const msg::LostArm& arm : lost_arms(file_, stop_without_driver, watch_, snapshot_, at())) {
      names.push_back(arm.arm());
    }
    return names;
  };
  for (const auto* arm : {"left", "right"}) watch_.process_exited(driver_node(arm), {1, -1, 9, false});
  watch_.judge(now_);
  EXPECT_TRUE(lost({true, true}).empty()) << "they may still brake";
  turn(2s);
  EXPECT_EQ(lost({true, true}), (std::vector<std::string>{"left", "right"}));
  EXPECT_EQ(lost({true, false}), std::vector<std::string>{"left"});
  EXPECT_TRUE(lost({false, false}).empty());
}

// The reachable stop set says nothing of an arm that a person moves on.
TEST_F(CellStatusTest, ListsNoArmThatOthersMayMove) {
  const auto lost = [this] { return lost_arms(file_, {true, false}, watch_, snapshot_, at()).size(); };
  const auto ends = [&] {
    watch_.process_exited(driver_node("left"), {1, -1, 9, false});
    watch_.judge(now_);
    turn(2s);
  };
  state("left", msg::ArmMode::ARM_OBSERVED, 0.0, "");
  state("left", msg::ArmMode::ARM_FAILED, 0.0, "its pendant is off");
  ends();
  EXPECT_EQ(lost(), 0U) << "its device has failed; others may move it all the same";
  msg::ArmState unmeasured;  // of the driver's next process
  unmeasured.arm("left");
  unmeasured.mode(msg::ArmMode::ARM_STARTING);
  snapshot_.update_observed(unmeasured);
  EXPECT_EQ(lost(), 0U);
  state("left", msg::ArmMode::ARM_STOPPED, 0.0, "");
  ends();
  EXPECT_EQ(lost(), 1U) << "its planner has it back";
  // Ordered, and it still brakes: then others move it.
  msg::ArmState braking = snapshot_.arms.at("left").value;
  braking.mode(msg::ArmMode::ARM_BRAKING);
  braking.cause(make_cause(msg::CauseKind::CAUSE_OBSERVED, "left", "others move it"));
  snapshot_.update_observed(braking);
  EXPECT_EQ(lost(), 0U);
}

class StandbyStatus : public CellStatusTest {
 protected:
  StandbyStatus() { failover_ = PlannerFailover({{"left", {"planner/left", "planner/left@beta"}}}); }
};

TEST_F(StandbyStatus, ReportsThePlannerInChargeAndItsTerm) {
  failover_.update("left", {"planner/left@beta", 6});
  watch_.put_in_charge("left", "planner/left@beta");
  heartbeat("planner/left", msg::NodeState::NODE_STANDBY, {});
  heartbeat("planner/left@beta", msg::NodeState::NODE_RUNNING, {});
  const msg::ArmStatus arm = status().arms()[0];
  EXPECT_EQ(arm.planner(), "planner/left@beta");
  EXPECT_EQ(arm.standby(), "planner/left");
  EXPECT_EQ(arm.term(), 6U);
  const msg::CellMode message = mode_message(watch_.mode(), failover_, "supervisor");
  ASSERT_EQ(message.leases().size(), 1U);
  EXPECT_EQ(message.leases()[0].planner(), "planner/left@beta");
}

}  // namespace
}  // namespace hecaton::services
