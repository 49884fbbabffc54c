/// The status of a cell as text and as JSON.

#include <sstream>

#include <gtest/gtest.h>

#include "services/cli/cell_access.hpp"
#include "services/cli/status_output.hpp"
#include "services/command_line/program.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services::cli {
namespace {

msg::CellStatus example_status() {
  msg::CellStatus status;
  status.cell("test");
  status.mode().mode(msg::Mode::MODE_RUN);
  msg::ArmOrder held;
  held.arm("west");
  held.mode(msg::Mode::MODE_HOLD);
  status.mode().arms({held});
  msg::LostArm lost;
  lost.arm("west");
  lost.q({0.3});
  lost.braking_delay_bound(0.1);
  status.mode().lost_arms({lost});
  status.supervisor("supervisor");

  msg::ArmStatus arm;
  arm.arm("north");
  arm.mode(msg::Mode::MODE_RUN);
  arm.driver_alive(true);
  arm.planner_alive(true);
  arm.state().mode(msg::ArmMode::ARM_RUNNING);
  arm.state().q({0.1, 0.2});
  arm.state_age(0.004);
  arm.has_goal(true);
  arm.goal().state(msg::GoalState::GOAL_BLOCKED);
  arm.goal().has_binding(true);
  arm.goal().binding_own("north/forearm");
  arm.goal().binding_other("pallet");
  arm.goal().binding_distance(0.018);
  arm.goal().elapsed(2.5);
  status.arms().push_back(arm);
  msg::ArmStatus unheard;
  unheard.arm("west");
  unheard.mode(msg::Mode::MODE_HOLD);
  unheard.state_age(-1.0);
  status.arms().push_back(unheard);

  msg::NodeStatus node;
  node.heartbeat().node("planner/north");
  node.heartbeat().kind(msg::NodeKind::NODE_PLANNER);
  node.alive(true);
  status.nodes().push_back(node);

  msg::HostStatus host;
  host.host("cell-pc");
  host.agent_alive(true);
  msg::ProcessEvent process;
  process.name("planner-north");
  process.kind(msg::ProcessEventKind::PROCESS_EXITED);
  process.exit_code(-1);
  process.signal_number(9);
  host.processes().push_back(process);
  status.hosts().push_back(host);

  msg::Fault fault;
  fault.id("1/1");
  fault.severity(msg::Severity::SEVERITY_ERROR);
  fault.cause(make_cause(msg::CauseKind::CAUSE_PROCESS_DIED, "planner/north", "planner/north was ended by signal 9"));
  fault.cleared(true);
  status.faults().push_back(fault);

  msg::ObstacleStatus obstacle;
  obstacle.name("crate");
  obstacle.shape("box 0.1 × 0.1 × 0.1 m");
  obstacle.X_WO().position().z(2.0);
  obstacle.X_WO().qw(1.0);
  status.obstacles().push_back(obstacle);
  return status;
}

TEST(StatusJson, HasAllKeys) {
  const Json json = to_json(example_status());
  for (const char* key :
       {"cell", "mode", "held_arms", "lost_arms", "stopped_arms", "speed", "arm_speeds", "arm_orders", "cause", "term",
        "supervisor", "standby", "uptime_s", "arms", "nodes", "hosts", "faults", "contact_report", "obstacles"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["mode"], "run");
  EXPECT_EQ(json["lost_arms"][0]["arm"], "west");
  EXPECT_EQ(json["lost_arms"][0]["q"], (Json{0.3}));
  EXPECT_EQ(json["arms"][0]["state"]["q"], (Json{0.1, 0.2}));
  EXPECT_EQ(json["arms"][0]["goal"]["binding"],
            (Json{{"own", "north/forearm"}, {"other", "pallet"}, {"distance_m", 0.018}}));
  EXPECT_TRUE(json["arms"][1]["goal"].is_null());
  EXPECT_TRUE(json["arms"][1]["state"]["age_s"].is_null()) << "never heard of";
  EXPECT_EQ(json["hosts"][0]["processes"][0]["signal"], 9);
  EXPECT_EQ(json["hosts"][0]["processes"][0]["running"], false);
  EXPECT_EQ(json["obstacles"][0]["xyz_rpy"], (Json{0.0, 0.0, 2.0, 0.0, 0.0, 0.0}));
  EXPECT_TRUE(json["contact_report"].is_null());
}

TEST(StatusText, SaysASpeedBelowFullSpeed) {
  msg::CellStatus status = example_status();
  EXPECT_EQ(status_text(status, Palette(false)).find("speed"), std::string::npos);
  status.mode().speed(0.3);
  msg::ArmSpeed own;
  own.arm("north");
  own.speed(0.125);
  status.mode().speeds({own});
  status.arms()[0].speed(0.125);
  EXPECT_NE(mode_text(status, Palette(false)).find(": run, speed 30 %, north 12.5 %"), std::string::npos)
      << mode_text(status, Palette(false));
  EXPECT_NE(arms_text(status, Palette(false)).find("12.5 %"), std::string::npos);
  EXPECT_EQ(to_json(status)["speed"], 0.3);
  EXPECT_EQ(to_json(status)["arm_speeds"], (Json{{{"arm", "north"}, {"speed", 0.125}}}));
  EXPECT_EQ(speed_text(0.01), "1 %");
  EXPECT_EQ(speed_text(1.0), "100 %");
}

TEST(StatusText, ShowsGrippersThatAreHeard) {
  const msg::CellStatus status = example_status();
  const std::string arm = status.arms()[0].arm();
  EXPECT_EQ(arms_text(status, Palette(false)).find("gripper"), std::string::npos);
  msg::ToolState tool;
  tool.arm(arm);
  tool.has_gripper(true);
  tool.width(0.04);
  tool.holding("crate");
  const Tools tools{{arm, tool}};
  EXPECT_NE(arms_text(status, Palette(false), tools).find("40 mm, holds crate"), std::string::npos)
      << arms_text(status, Palette(false), tools);
  Json arms = list_json(status.arms());
  add_tools(arms, tools);
  EXPECT_EQ(arms[0]["tool"], (Json{{"arm", arm}, {"moving", false}, {"width", 0.04}, {"holding", "crate"}}));
  EXPECT_TRUE(arms[1]["tool"].is_null()) << "no gripper";
  tool.width(-1.0);
  tool.holding("");
  EXPECT_EQ(gripper_text(tool), "holds nothing") << "a gripper on outputs";
}

TEST(StatusJson, ListsCarriedObjects) {
  msg::CellStatus status = example_status();
  EXPECT_EQ(to_json(status)["arms"][0]["state"]["carried"], Json::array());
  status.arms()[0].state().carried("crate, lid");
  EXPECT_EQ(to_json(status)["arms"][0]["state"]["carried"], (Json{"crate", "lid"}));
}

TEST(StatusText, WrapsLongReasons) {
  msg::CellStatus status = example_status();
  std::string reason = "held: planner/north: no heartbeat for more than 250 ms";
  for (int i = 0; i < 5; ++i) reason += "; planner/west: no state of north for 0.2 s";
  status.arms()[0].waiting_for().text(reason);
  status.nodes()[0].heartbeat().state(msg::NodeState::NODE_DEGRADED);
  status.nodes()[0].heartbeat().cause().text(reason);
  status.faults()[0].cause().text(reason);
  std::istringstream lines(status_text(status, Palette(false)));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 120U) << line;
}

TEST(StatusJson, ReportsContacts) {
  msg::CellStatus status = example_status();
  status.has_contact_report(true);
  status.contact_report().contacts(2);
  EXPECT_EQ(to_json(status)["contact_report"]["contacts"], 2);
  EXPECT_TRUE(to_json(status)["contact_report"]["min_separation_m"].is_null()) << "no pair was checked";
}

TEST(StatusText, ShowsBindingPairAndAge) {
  const std::string text = status_text(example_status(), Palette(false));
  EXPECT_NE(text.find("cell test: run, held west"), std::string::npos) << text;
  EXPECT_NE(text.find("north/forearm – pallet, 18 mm"), std::string::npos) << text;
  EXPECT_NE(text.find("4 ms"), std::string::npos) << text;
  EXPECT_NE(text.find("never"), std::string::npos) << text;
  EXPECT_NE(text.find("contact monitor: no report yet"), std::string::npos) << text;
}

TEST(StatusText, ShowsHowProcessesEnded) {
  EXPECT_NE(hosts_text(example_status(), Palette(false)).find("ended by signal 9"), std::string::npos);
}

TEST(StatusText, SaysWhenListsAreEmpty) {
  const msg::CellStatus nothing;
  EXPECT_EQ(faults_text(nothing, Palette(false)), "no faults\n");
  EXPECT_EQ(obstacles_text(nothing, Palette(false)), "no obstacles\n");
}

TEST(RequireArm, NamesTheArmsOfTheCell) {
  const msg::CellStatus status = example_status();
  EXPECT_EQ(require_arm(status, "west").arm(), "west");
  try {
    static_cast<void>(require_arm(status, "south"));
    FAIL() << "there is no such arm";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.code(), ExitCode::kBadInput);
    EXPECT_STREQ(failure.what(), "cell 'test' has no arm 'south'; its arms: north and west");
  }
}

TEST(FailureOf, DistinguishesBadInputRejectionAndSilence) {
  const auto code = [](const Error& error) { return failure_of(error).code(); };
  EXPECT_EQ(code(Rejected({CauseKind::kUnknownName, "box", "there is no obstacle named 'box'"})), ExitCode::kBadInput);
  EXPECT_EQ(code(Rejected({CauseKind::kNameTaken, "box", "the name is taken"})), ExitCode::kBadInput);
  EXPECT_EQ(code(Rejected({CauseKind::kNotAllowedNow, "box", "an arm is there"})), ExitCode::kNegative);
  EXPECT_EQ(code(NoAnswer("the world does not answer")), ExitCode::kTimeOut);
  EXPECT_EQ(code(InvalidArgument("no such domain")), ExitCode::kBadInput);
  const Failure nowhere =
      failure_of(Unreachable({"no cell answers in DDS domain 42", "start one", "the supervisor", true}));
  EXPECT_EQ(nowhere.code(), ExitCode::kUnreachable);
  EXPECT_NE(std::string(nowhere.what()).find("--domain or --cell"), std::string::npos);
  const Failure no_recorder = failure_of(Unreachable({"no recorder saves", "give one the key record", "the recorder"}));
  EXPECT_EQ(no_recorder.code(), ExitCode::kUnreachable);
  EXPECT_STREQ(no_recorder.what(), "no recorder saves: give one the key record");
}

msg::GoalStatus blocked_goal() {
  msg::GoalStatus goal;
  goal.state(msg::GoalState::GOAL_BLOCKED);
  goal.cause(make_cause(msg::CauseKind::CAUSE_PATH_BLOCKED, "pallet", "no way for now"));
  goal.has_binding(true);
  goal.binding_own("arm2/forearm");
  goal.binding_other("pallet");
  goal.binding_distance(0.018);
  goal.recovery_action("draws another subspace");
  return goal;
}

TEST(GoalText, HasCauseBindingAndRecoveryAction) {
  EXPECT_EQ(goal_text(blocked_goal()),
            "blocked: no way for now (arm2/forearm – pallet, 18 mm); draws another subspace");
}

TEST(GoalText, HasTheBindingPairWithoutACause) {
  msg::GoalStatus goal = blocked_goal();
  goal.cause({});
  goal.recovery_action("");
  EXPECT_EQ(goal_text(goal), "blocked: arm2/forearm – pallet, 18 mm");
}

TEST(GoalText, HasTheBlockedDuration) {
  msg::GoalStatus goal = blocked_goal();
  goal.blocked_duration(3.2);
  EXPECT_EQ(goal_text(goal),
            "blocked: no way for now (arm2/forearm – pallet, 18 mm), for 3.20 s; draws another subspace");
}

TEST(GoalText, OmitsTheRecoveryActionOfAFinishedGoal) {
  msg::GoalStatus goal = blocked_goal();
  goal.state(msg::GoalState::GOAL_TIMED_OUT);
  EXPECT_EQ(goal_text(goal), "timed_out: no way for now (arm2/forearm – pallet, 18 mm)");
  goal.state(msg::GoalState::GOAL_REACHED);
  EXPECT_EQ(goal_text(goal), "reached");
}

TEST(GoalText, HasTheMeasuredErrorOfAReachedPose) {
  msg::GoalStatus goal;
  goal.state(msg::GoalState::GOAL_REACHED);
  goal.has_tool(true);
  goal.position_error(0.00012);
  goal.orientation_error(0.0005);  // 0.0286°
  EXPECT_EQ(goal_text(goal), "reached (tool 0.12 mm and 0.03° from the pose)");
  goal.tool().free_rotation(msg::FreeRotation::FREE_ALL);
  EXPECT_EQ(goal_text(goal), "reached (tool 0.12 mm from the position)");
  goal.position_error(-1.0);
  EXPECT_EQ(goal_text(goal), "reached") << "not measured";
}

TEST(GoalJson, HasAReasonWheneverTheGoalIsBlocked) {
  msg::GoalStatus goal;
  EXPECT_TRUE(to_json(goal)["reason"].is_null());
  goal.state(msg::GoalState::GOAL_BLOCKED);
  EXPECT_EQ(to_json(goal)["reason"], "its planner has reported no reason");
  goal.has_binding(true);
  goal.binding_own("a/hand");
  goal.binding_other("crate");
  goal.binding_distance(0.018);
  EXPECT_EQ(to_json(goal)["reason"], "a/hand – crate, 18 mm");
}

TEST(GoalJson, HasTheNearestOrientation) {
  msg::GoalStatus goal;
  EXPECT_TRUE(to_json(goal)["nearest"].is_null());
  goal.has_nearest(true);
  goal.nearest_angle(0.8);
  const Json nearest = to_json(goal)["nearest"];
  EXPECT_EQ(nearest["angle_rad"], 0.8);
  EXPECT_EQ(nearest["xyz_rpy"], Json::parse("[0, 0, 0, 0, 0, 0]").get<std::vector<double>>());
}

TEST(WaitingText, PrefersTheSupervisorsReason) {
  msg::ArmStatus arm;
  EXPECT_EQ(waiting_text(arm), "");
  arm.has_goal(true);
  arm.goal(blocked_goal());
  EXPECT_EQ(waiting_text(arm), "no way for now (arm2/forearm – pallet, 18 mm); draws another subspace");
  arm.waiting_for(make_cause(msg::CauseKind::CAUSE_HOLD_ORDERED, {}, "the cell is on hold"));
  EXPECT_EQ(waiting_text(arm), "the cell is on hold");
}

TEST(IsFinal, IsFalseForAcceptedActiveAndBlocked) {
  for (const msg::GoalState state :
       {msg::GoalState::GOAL_ACCEPTED, msg::GoalState::GOAL_ACTIVE, msg::GoalState::GOAL_BLOCKED}) {
    EXPECT_FALSE(is_final(state)) << text(state);
  }
  for (const msg::GoalState state :
       {msg::GoalState::GOAL_REACHED, msg::GoalState::GOAL_REJECTED, msg::GoalState::GOAL_CANCELLED,
        msg::GoalState::GOAL_REPLACED, msg::GoalState::GOAL_TIMED_OUT}) {
    EXPECT_TRUE(is_final(state)) << text(state);
  }
}

TEST(ContactText, CountsContacts) {
  msg::ContactReport report;
  EXPECT_EQ(contact_text(report, Palette(false)), "0 contacts, no pair checked yet");
  report.contacts(1);
  report.has_smallest(true);
  report.smallest().distance(-0.002);
  report.smallest().a("a/x");
  report.smallest().b("crate");
  EXPECT_EQ(contact_text(report, Palette(false)), "1 contact, smallest separation -2.0 mm (a/x – crate)");
}

TEST(FaultDuration, EndsWhenItIsCleared) {
  msg::Fault fault;
  fault.since_ns(1'000'000'000);
  fault.stamp_ns(3'000'000'000);
  EXPECT_DOUBLE_EQ(fault_duration(fault), 2.0);
  fault.cleared(true);
  fault.cleared_ns(1'500'000'000);
  EXPECT_DOUBLE_EQ(fault_duration(fault), 0.5);
}

}  // namespace
}  // namespace hecaton::services::cli
