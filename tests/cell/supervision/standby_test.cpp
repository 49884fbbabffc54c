// Failover of planner and supervisor, with two hosts of one cell on this machine. A test begins with either one in
// charge, because a busy machine may have exchanged them before.

#include <algorithm>
#include <csignal>
#include <deque>
#include <map>
#include <optional>

#include <gtest/gtest.h>

#include "tests/cell/supervision/health_cell.hpp"

namespace hecaton::services::testing {
namespace {

bus::ReaderOptions every_sample() {
  bus::ReaderOptions options;
  options.conflate = false;
  options.queue = 1'000'000;
  return options;
}

class Standby : public ::testing::Test {
 protected:
  ~Standby() override { expect_one_planner_a_term(); }

  /// Until the arm and the cell have a node in charge and a standby each.
  msg::CellStatus await_ready() {
    return cell_.await("standbys that are ready", [](const msg::CellStatus& status) {
      return !status.standby().empty() && !arm_of(status, "left").standby().empty() &&
             arm_of(status, "left").state().mode() == msg::ArmMode::ARM_RUNNING &&
             status.mode().mode() == msg::Mode::MODE_RUN && arms_on(status.mode(), msg::Mode::MODE_HOLD).empty();
    });
  }
  msg::CellStatus send_left_on_its_way() {
    await_ready();
    cell_.send_goal("left", "way", "away");
    cell_.await("left moves", [](const msg::CellStatus& status) {
      return arm_of(status, "left").has_goal() && is_none(arm_of(status, "left").waiting_for());
    });
    return await_ready();
  }
  void expect_arrival() {
    cell_.await_goal("way",
                     [](const msg::GoalStatus& status) { return status.state() == msg::GoalState::GOAL_REACHED; });
  }
  msg::ArmStatus await_successor(const msg::ArmStatus& before) {
    const auto status = cell_.await("a successor of " + before.planner(), [&](const msg::CellStatus& seen) {
      return arm_of(seen, "left").planner() != before.planner() && arm_of(seen, "left").term() > before.term();
    });
    return arm_of(status, "left");
  }
  /// Until `node` stands by for the arm.
  void await_standing_by(const std::string& node) {
    cell_.await(node + " stands by", [&](const msg::CellStatus& status) {
      return std::any_of(status.nodes().begin(), status.nodes().end(), [&](const msg::NodeStatus& seen) {
        const bool up = seen.alive() && seen.heartbeat().node() == node;
        return up &&
               (seen.heartbeat().state() == msg::NodeState::NODE_STANDBY || arm_of(status, "left").planner() == node);
      });
    });
  }
  /// Checks all states that the driver sent: terms never decrease, and each belongs to one planner.
  void expect_one_planner_a_term() {
    std::uint64_t followed = 0;
    std::uint64_t newest = 0;
    std::map<std::uint64_t, std::string> planners;
    for (const auto& sample : states_.take()) {
      if (sample.disposed) continue;
      EXPECT_GE(sample.value.newest_term(), newest);
      if (sample.value.term() > 0) {  // 0: the driver has followed no planner yet
        EXPECT_GE(sample.value.term(), followed);
        followed = sample.value.term();
      }
      newest = sample.value.newest_term();
      if (sample.value.planner().empty()) continue;
      const auto [known, first] = planners.try_emplace(newest, sample.value.planner());
      EXPECT_EQ(known->second, sample.value.planner()) << "in term " << newest;
    }
    EXPECT_FALSE(planners.empty());
  }

  HealthCell cell_{{"--host", "alpha"}, "standby_cell.yaml"};
  ChildProcess beta_{cell_.agent_command({"--host", "beta"})};
  bus::Reader<msg::ArmState> states_{cell_.participant(), &cell_.mailbox(), every_sample()};
};

TEST_F(Standby, ContinuesTheGoalOfAKilledPlanner) {
  const auto status = send_left_on_its_way();
  const msg::ArmStatus before = arm_of(status, "left");
  ASSERT_EQ(kill(pid_of_node(status, before.planner()), SIGKILL), 0);
  const msg::ArmStatus after = await_successor(before);
  EXPECT_TRUE(after.mode() == msg::Mode::MODE_RUN) << "its fault holds no arm: " << after.waiting_for().text();
  expect_arrival();
  cell_.await_fault("the death", [&](const msg::Fault& fault) {
    return fault.cause().kind() == msg::CauseKind::CAUSE_PROCESS_DIED && fault.cause().subject() == before.planner();
  });
  await_standing_by(before.planner());
}

// A planner that went straight to the end would move three times as fast as the trajectory.
TEST_F(Standby, ContinuesTheTrajectoryOfAKilledPlanner) {
  constexpr double kDuration = 8.0;
  const planner::Arm& arm = cell_.file().cell.arms[0].arm;
  const planner::JointVector& home = arm.named.at("home");
  const planner::JointVector& away = arm.named.at("away");
  const double fastest = 1.5 * (away - home).cwiseAbs().maxCoeff() / kDuration;  // of a cubic from rest to rest
  await_ready();
  bus::Reader<msg::ArmState> watched(cell_.participant(), &cell_.mailbox(), every_sample());
  msg::Goal goal;
  goal.arm("left");
  goal.goal("way");
  goal.kind(msg::GoalKind::GOAL_TRAJECTORY);
  goal.trajectory().time({0.0, kDuration});
  goal.trajectory().q().assign(home.begin(), home.end());
  goal.trajectory().q().insert(goal.trajectory().q().end(), away.begin(), away.end());
  goal.trajectory().qd().assign(goal.trajectory().q().size(), 0.0);
  cell_.send(goal);
  cell_.await_goal("way", [](const msg::GoalStatus& status) { return status.trajectory_time() > 2.0; });
  const auto status = await_ready();
  const msg::ArmStatus before = arm_of(status, "left");
  ASSERT_EQ(kill(pid_of_node(status, before.planner()), SIGKILL), 0);
  await_successor(before);
  cell_.await_goal("way", [&](const msg::GoalStatus& seen) {
    return seen.node() != before.planner() && seen.trajectory_time() > 3.0 && seen.trajectory_rate() > 0.5;
  });
  expect_arrival();

  double farthest = home[0];
  std::optional<msg::ArmState> last;
  double fastest_seen = 0.0;
  for (const auto& sample : watched.take()) {
    if (sample.disposed || sample.value.arm() != "left") continue;
    const msg::ArmState& state = sample.value;
    EXPECT_GT(state.q()[0], farthest - 0.05) << "it does not go back";
    farthest = std::max(farthest, state.q()[0]);
    for (int j = 1; j < 6; ++j) EXPECT_NEAR(state.q()[static_cast<std::size_t>(j)], home[j], 0.01);
    // From positions of 100 ms: a driver catches up after a late command.
    if (!last) last = state;
    const double seconds = 1e-9 * static_cast<double>(state.stamp_ns() - last->stamp_ns());
    if (seconds < 0.1) continue;
    fastest_seen = std::max(fastest_seen, (state.q()[0] - last->q()[0]) / seconds);
    last = state;
  }
  EXPECT_LT(fastest_seen, 1.25 * fastest);
  EXPECT_GT(fastest_seen, 0.8 * fastest);
}

TEST_F(Standby, StaysInChargeWhenAStoppedPlannerContinues) {
  const auto status = send_left_on_its_way();
  const msg::ArmStatus before = arm_of(status, "left");
  const int pid = pid_of_node(status, before.planner());
  ASSERT_EQ(kill(pid, SIGSTOP), 0);
  await_successor(before);
  ASSERT_EQ(kill(pid, SIGCONT), 0);
  expect_arrival();
  await_standing_by(before.planner());
}

/// Speed of the fastest joint as a share of its limit.
double share_of(const msg::ArmState& state) {
  constexpr double kLimit = 1.5;  // standby_cell.yaml [rad/s]
  double fastest = 0.0;
  for (const double v : state.qd()) fastest = std::max(fastest, std::abs(v));
  return fastest / kLimit;
}

class SpeedOverride : public Standby {
 protected:
  static constexpr double kMeasured = 0.02;  ///< of interpolation
  /// A driver catches up after a late command: for one period the arm is faster, but not on the way of some periods.
  static constexpr std::chrono::milliseconds kWindow{50};

  void await_share(const std::string& what, const std::function<bool(double)>& condition) {
    for (const auto until = bus::Clock::now() + kPatience; !condition(share_of(cell_.next_state("left")));)
      ASSERT_LT(bus::Clock::now(), until) << what;
  }
  /// The highest share of the velocity limits since the last call, from the ways that the arm went within kWindow.
  double highest_share() {
    double highest = 0.0;
    std::deque<msg::ArmState> window;
    for (const auto& sample : watched_.take()) {
      if (sample.disposed || sample.value.arm() != "left") continue;
      window.push_back(sample.value);
      const auto since = [&](const msg::ArmState& state) {
        return std::chrono::nanoseconds(window.back().stamp_ns() - state.stamp_ns());
      };
      while (window.size() > 2 && since(window[1]) >= kWindow) window.pop_front();
      if (since(window.front()) < kWindow) continue;
      const double seconds = std::chrono::duration<double>(since(window.front())).count();
      msg::ArmState way = window.back();
      for (std::size_t j = 0; j < way.q().size(); ++j) way.qd()[j] = (way.q()[j] - window.front().q()[j]) / seconds;
      highest = std::max(highest, share_of(way));
    }
    return highest;
  }

  bus::Reader<msg::ArmState> watched_{cell_.participant(), &cell_.mailbox(), every_sample()};
};

TEST_F(SpeedOverride, SlowsAnArmOnItsWayAndSurvivesBothFailovers) {
  send_left_on_its_way();
  await_share("full speed", [](double share) { return share > 0.9; });
  const auto reply = cell_.order_speed(0.1);
  ASSERT_TRUE(reply && reply->done());
  EXPECT_EQ(arm_of(reply->status(), "left").speed(), 0.1);
  // Well below the bound: the other reader may not have the last state above it yet.
  await_share("a tenth of the speed", [&](double share) { return share < 0.1 + 0.5 * kMeasured && share > 0.05; });
  static_cast<void>(highest_share());

  auto status = await_ready();
  const msg::ArmStatus before = arm_of(status, "left");
  ASSERT_EQ(kill(pid_of_node(status, before.planner()), SIGKILL), 0);
  await_successor(before);
  await_share("the successor moves", [](double share) { return share > 0.05; });
  await_standing_by(before.planner());

  status = await_ready();
  const std::string supervisor = status.supervisor();
  ASSERT_EQ(kill(pid_of_node(status, supervisor), SIGKILL), 0);
  status = cell_.await("another supervisor", [&](const msg::CellStatus& seen) {
    return seen.supervisor() != supervisor && seen.mode().term() > status.mode().term();
  });
  EXPECT_EQ(status.mode().speed(), 0.1);
  EXPECT_EQ(arm_of(status, "left").speed(), 0.1);
  await_share("the arm moves on", [](double share) { return share > 0.05; });
  EXPECT_LT(highest_share(), 0.1 + kMeasured) << "no process has moved it faster in between";

  ASSERT_TRUE(cell_.order_speed(1.0)->done());
  expect_arrival();
  EXPECT_GT(highest_share(), 0.3);
}

TEST_F(SpeedOverride, IsNoFaultAtOnePercent) {
  await_ready();
  ASSERT_TRUE(cell_.order_speed(0.01, {"left"})->done());
  EXPECT_FALSE(cell_.order_speed(0.001)->done());
  EXPECT_FALSE(cell_.order_speed(30.0)->done());
  cell_.send_goal("left", "way", "away");
  await_share("motion", [](double share) { return share > 0.005; });
  static_cast<void>(highest_share());
  const double begin = cell_.next_state("left").q()[0];
  // 1 % of 1.5 rad/s: 75 mrad take 5 s, five times as long as a supervisor waits for an arm that stands.
  for (const auto until = bus::Clock::now() + kPatience; cell_.next_state("left").q()[0] < begin + 0.075;)
    ASSERT_LT(bus::Clock::now(), until);
  EXPECT_LT(highest_share(), 0.01 + kMeasured);
  const auto status =
      cell_.await("its goal", [](const msg::CellStatus& seen) { return arm_of(seen, "left").has_goal(); });
  EXPECT_EQ(arm_of(status, "left").goal().state(), msg::GoalState::GOAL_ACTIVE);
  EXPECT_TRUE(is_none(arm_of(status, "left").waiting_for())) << arm_of(status, "left").waiting_for().text();
  EXPECT_EQ(open_faults(status, "arm_stands", "left"), 0) << text_of(status);
  ASSERT_TRUE(cell_.order_speed(1.0, {"left"})->done());
  expect_arrival();
}

// Commands of a planner that was stopped during its replacement and has not received the new lease yet.
TEST_F(Standby, IsProtectedFromCommandsOfTheReplacedPlanner) {
  const auto status = await_ready();
  const msg::ArmStatus before = arm_of(status, "left");
  const int pid = pid_of_node(status, before.planner());
  bus::Writer<msg::ArmCommand> commands(cell_.participant());
  ASSERT_TRUE(commands.wait_matched(1, kPatience));
  ASSERT_EQ(kill(pid, SIGSTOP), 0);
  const msg::ArmStatus after = await_successor(before);
  msg::ArmCommand command;
  command.arm("left");
  command.node(before.planner());
  command.term(before.term());
  command.sequence_number(1'000'000'000);
  command.period(0.01);
  command.q({1.0, -1.9, 2.6, 0, 0.6, 0});
  command.qd(std::vector<double>(6, 0.0));
  msg::ArmState state = cell_.next_state("left");
  // The supervisor publishes the lease before the driver has received it.
  for (const auto until = bus::Clock::now() + kPatience; state.term() < after.term();) {
    ASSERT_LT(bus::Clock::now(), until) << "the successor is not followed";
    state = cell_.next_state("left");
  }
  const std::uint64_t refused = state.stale_rejected();
  for (const auto until = bus::Clock::now() + kPatience; state.stale_rejected() < refused + 20;) {
    ASSERT_LT(bus::Clock::now(), until) << "nothing is refused";
    ASSERT_TRUE(commands.write(command));
    state = cell_.next_state("left");
    EXPECT_GE(state.term(), after.term());
    EXPECT_NEAR(state.q()[0], 0.0, 0.01) << "the arm must not move";
  }
  ASSERT_EQ(kill(pid, SIGCONT), 0);
  await_standing_by(before.planner());
}

// A restarted driver begins with the newest lease of its checkpoint.
TEST_F(Standby, KeepsItsLeaseWhenTheDriverRestarts) {
  const auto status = await_ready();
  const msg::ArmStatus before = arm_of(status, "left");
  ASSERT_EQ(kill(pid_of_node(status, before.planner()), SIGKILL), 0);
  await_successor(before);
  const auto taken_over = await_ready();
  ASSERT_EQ(kill(pid_of_node(taken_over, "driver/left"), SIGKILL), 0);
  cell_.await_fault("the driver's death", [&](const msg::Fault& fault) {
    return fault.cause().kind() == msg::CauseKind::CAUSE_PROCESS_DIED && fault.cause().subject() == "driver/left" &&
           fault.cleared();
  });
  const msg::ArmStatus after = arm_of(await_ready(), "left");
  EXPECT_GE(after.term(), arm_of(taken_over, "left").term());
}

TEST_F(Standby, KeepsOrdersFaultsAndLeasesOfAKilledSupervisor) {
  const auto started = await_ready();
  const msg::ArmStatus first = arm_of(started, "left");
  ASSERT_EQ(kill(pid_of_node(started, first.planner()), SIGKILL), 0);
  const msg::Fault died = cell_.await_fault("the planner's death", [&](const msg::Fault& fault) {
    return fault.cause().kind() == msg::CauseKind::CAUSE_PROCESS_DIED && fault.cause().subject() == first.planner() &&
           fault.cleared();
  });
  const auto before = cell_.await("a standby", [](const auto& status) { return !status.standby().empty(); });
  const std::string leader = before.supervisor();
  ASSERT_TRUE(
      cell_.call(msg::RequestKind::REQUEST_HOLD, {"left"})->done());  // acknowledged: it survives the supervisor
  ASSERT_EQ(kill(pid_of_node(before, leader), SIGKILL), 0);

  const msg::CellMode mode = cell_.await_mode("another leader's", [&](const msg::CellMode& seen) {
    return seen.node() != leader && seen.term() > before.mode().term();
  });
  EXPECT_EQ(mode.mode(), msg::Mode::MODE_RUN);
  EXPECT_EQ(orders_in(mode).arms.at("left"), msg::Mode::MODE_HOLD);
  const auto after = cell_.await("an answer", [&](const msg::CellStatus& seen) { return seen.supervisor() != leader; });
  EXPECT_TRUE(std::any_of(after.faults().begin(), after.faults().end(), [&](const msg::Fault& fault) {
    return fault.id() == died.id() && fault.cleared() && fault.cause() == died.cause();
  })) << text_of(after);
  cell_.await_fault("the supervisor's death", [&](const msg::Fault& fault) {
    return fault.cause().kind() == msg::CauseKind::CAUSE_PROCESS_DIED && fault.cause().subject() == leader;
  });

  ASSERT_TRUE(cell_.call(msg::RequestKind::REQUEST_RESUME)->done());
  const auto way = send_left_on_its_way();
  const msg::ArmStatus arm = arm_of(way, "left");
  ASSERT_EQ(kill(pid_of_node(way, arm.planner()), SIGKILL), 0);
  await_successor(arm);
  expect_arrival();
}

// Both supervisors die at one time, and with the leader's host its checkpoint.
TEST_F(Standby, HasTheOrdersAfterBothSupervisorsDied) {
  const auto started = await_ready();
  ASSERT_TRUE(cell_.call(msg::RequestKind::REQUEST_STOP)->done());
  const bool first_leads = started.supervisor() == "supervisor";
  const int standby = pid_of_node(started, started.standby());
  (first_leads ? cell_.agent() : beta_).signal(SIGKILL);
  ASSERT_EQ(kill(standby, SIGKILL), 0);
  const auto after = cell_.await("a supervisor", [&](const msg::CellStatus& status) {
    return status.supervisor() == started.standby() && status.mode().term() > started.mode().term();
  });
  EXPECT_EQ(after.mode().mode(), msg::Mode::MODE_STOP);
}

// The standby hangs while a person stops the cell, and leads when the leader hangs, too.
TEST_F(Standby, ReceivesOrdersThatWereGivenWhileItHung) {
  const auto started = await_ready();
  const std::string leader = started.supervisor();
  const std::string other = started.standby();
  const int led = pid_of_node(started, leader);
  const int goes_on = pid_of_node(started, other);
  ASSERT_EQ(kill(goes_on, SIGSTOP), 0);
  cell_.await_dropped(other);
  ASSERT_TRUE(cell_.call(msg::RequestKind::REQUEST_STOP, {"left"})->done()) << "a hanging standby delays no reply";
  ASSERT_EQ(kill(led, SIGSTOP), 0);
  cell_.await_dropped(leader);
  ASSERT_EQ(kill(goes_on, SIGCONT), 0);
  cell_.await_mode("another leader's", [&](const msg::CellMode& mode) {
    return mode.node() == other && mode.term() > started.mode().term();
  });
  ASSERT_EQ(kill(led, SIGCONT), 0);
  cell_.await("the stop, from the new leader", [&](const msg::CellStatus& status) {
    return contains(arms_on(status.mode(), msg::Mode::MODE_STOP), "left") && !status.standby().empty();
  });
}

// Both supervisors hang, and one of them continues: it has not observed the hang of the other one.
TEST_F(Standby, ReportsTheOtherSupervisorAsSilentAfterBothHung) {
  const auto started = await_ready();
  const std::string leader = started.supervisor();
  const std::string other = started.standby();
  const int hung = pid_of_node(started, leader);
  const int goes_on = pid_of_node(started, other);
  ASSERT_EQ(kill(goes_on, SIGSTOP), 0);
  ASSERT_EQ(kill(hung, SIGSTOP), 0);
  cell_.await_dropped(leader);
  ASSERT_EQ(kill(goes_on, SIGCONT), 0);
  const msg::Fault fault = cell_.await_fault("that the other is silent", [&](const msg::Fault& reported) {
    return reported.cause().kind() == msg::CauseKind::CAUSE_NODE_SILENT && reported.cause().subject() == leader &&
           !reported.cleared();
  });
  ASSERT_EQ(kill(hung, SIGCONT), 0);
  cell_.await_fault("that it is back",
                    [&](const msg::Fault& reported) { return reported.id() == fault.id() && reported.cleared(); });
  // Its loop waited while the participant recovered.
  const auto status = await_ready();
  for (const msg::NodeStatus& node : status.nodes()) {
    if (node.heartbeat().kind() != msg::NodeKind::NODE_SUPERVISOR) continue;
    EXPECT_LT(node.heartbeat().ticks(), 1000 * status.uptime() + 100'000) << node.heartbeat().node();
  }
}

}  // namespace
}  // namespace hecaton::services::testing
