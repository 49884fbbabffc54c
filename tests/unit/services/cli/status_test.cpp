/// The supervisor's picture for programs and for people.

#include <sstream>

#include <gtest/gtest.h>

#include "services/cli/client.hpp"
#include "services/cli/status_json.hpp"
#include "services/cli/status_text.hpp"
#include "services/command_line/failure.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services::cli {
namespace {

msg::CellStatus example() {
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
  lost.moved_for(0.1);
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

TEST(StatusJson, HasEveryPart) {
  const Json json = to_json(example());
  for (const char* key :
       {"cell", "mode", "held_arms", "lost_arms", "stopped_arms", "arm_orders", "cause", "term", "supervisor",
        "standby", "uptime_s", "arms", "nodes", "hosts", "faults", "referee", "obstacles"}) {
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
  EXPECT_TRUE(json["referee"].is_null());
}

TEST(StatusJson, ListsAllThatAnArmCarries) {
  msg::CellStatus status = example();
  EXPECT_EQ(to_json(status)["arms"][0]["state"]["carried"], Json::array());
  status.arms()[0].state().carried("crate, lid");
  EXPECT_EQ(to_json(status)["arms"][0]["state"]["carried"], (Json{"crate", "lid"}));
}

TEST(StatusText, FitsIntoATerminalHoweverLongTheReasonsAre) {
  msg::CellStatus status = example();
  std::string reason = "held: planner/north: no heartbeat for more than 250 ms";
  for (int i = 0; i < 5; ++i) reason += "; planner/west: no state of north for 0.2 s";
  status.arms()[0].waiting_for().text(reason);
  status.nodes()[0].heartbeat().state(msg::NodeState::NODE_DEGRADED);
  status.nodes()[0].heartbeat().cause().text(reason);
  status.faults()[0].cause().text(reason);
  std::istringstream lines(status_text(status, Palette(false)));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 120U) << line;
}

TEST(StatusJson, TellsTheRefereesAccount) {
  msg::CellStatus status = example();
  status.has_referee(true);
  status.referee().contacts(2);
  EXPECT_EQ(to_json(status)["referee"]["contacts"], 2);
  EXPECT_TRUE(to_json(status)["referee"]["min_separation_m"].is_null()) << "nothing was judged";
}

TEST(StatusText, TellsWhatBindsAndHowOldItIs) {
  const std::string text = status_text(example(), Palette(false));
  EXPECT_NE(text.find("cell test: run, held west"), std::string::npos) << text;
  EXPECT_NE(text.find("north/forearm – pallet, 18 mm"), std::string::npos) << text;
  EXPECT_NE(text.find("4 ms"), std::string::npos) << text;
  EXPECT_NE(text.find("never"), std::string::npos) << text;
  EXPECT_NE(text.find("referee: not heard of"), std::string::npos) << text;
}

TEST(StatusText, TellsHowProcessesEnded) {
  EXPECT_NE(hosts_text(example(), Palette(false)).find("ended by signal 9"), std::string::npos);
}

TEST(StatusText, SaysThatThereIsNothing) {
  const msg::CellStatus nothing;
  EXPECT_EQ(faults_text(nothing, Palette(false)), "no faults\n");
  EXPECT_EQ(obstacles_text(nothing, Palette(false)), "no obstacles\n");
}

TEST(RequireArm, NamesTheKnownOnes) {
  const msg::CellStatus status = example();
  EXPECT_EQ(require_arm(status, "west").arm(), "west");
  try {
    static_cast<void>(require_arm(status, "south"));
    FAIL() << "there is no such arm";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.code(), ExitCode::kBadInput);
    EXPECT_STREQ(failure.what(), "cell 'test' has no arm 'south'; its arms: north and west");
  }
}

TEST(RequireObstacle, NamesTheKnownOnes) {
  EXPECT_NO_THROW(require_obstacle(example(), "crate"));
  EXPECT_THROW(require_obstacle(example(), "box"), Failure);
  EXPECT_THROW(require_carried(example(), "north", "crate"), Failure) << "nobody carries it";
}

}  // namespace
}  // namespace hecaton::services::cli
