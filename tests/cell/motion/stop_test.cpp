// Stops of an arm while other processes fail.
#include <algorithm>
#include <cmath>

#include "tests/cell/motion/motion_cell.hpp"

namespace hecaton::test {
namespace {

const std::vector<double> kFarAway{2.5, -1.9, 2.6, 0, 0.6, 0};

class MotionStop : public MotionCell {
 protected:
  [[nodiscard]] bool seen(msg::ArmMode mode) const {
    return std::any_of(history_.begin(), history_.end(),
                       [mode](const msg::ArmState& state) { return state.mode() == mode; });
  }
  [[nodiscard]] bool in(msg::ArmMode mode) const { return arm() != nullptr && arm()->mode() == mode; }

  void move_away(const std::string& goal) {
    send(joint_goal(goal, kFarAway));
    ASSERT_TRUE(await([&] { return moves(); }));
    history_.clear();
  }
  double fastest_joint() {
    double fastest = 0.0;
    if (arm() == nullptr) return fastest;
    for (const double speed : arm()->qd()) fastest = std::max(fastest, std::abs(speed));
    return fastest;
  }
};

TEST_F(MotionStop, DriverBrakesWhenItsPlannerIsKilled) {
  start_world();
  start_driver();
  ChildProcess& planner = start_planner();
  ASSERT_TRUE(await([&] { return in(msg::ArmMode::ARM_RUNNING); }));
  move_away("g");
  // From 0.8 rad/s the stop takes 80 ms at 10 rad/s², longer than the command time-out of 50 ms.
  ASSERT_TRUE(await([&] { return fastest_joint() > 0.8; }));
  history_.clear();
  planner.signal(SIGKILL);
  ASSERT_TRUE(await([&] { return in(msg::ArmMode::ARM_STOPPED); }));
  ASSERT_TRUE(seen(msg::ArmMode::ARM_BRAKING));
  EXPECT_NE(arm()->cause().text().find("commands ceased"), std::string::npos) << arm()->cause().text();
  constexpr double kAtRest = 1e-3;  // the driver calls slower joints at rest [rad/s]
  for (const double speed : arm()->qd()) EXPECT_LE(std::abs(speed), kAtRest);

  // On the stop profile all joints brake together at the cell's 10 rad/s²: from every sample on the way the arm comes
  // to rest q̇ T/2 further, T = maxⱼ |q̇ⱼ| / 10. While a set-point is late, because the machine is busy, the device moves
  // on with the velocity of the last one, and returns later.
  constexpr double kPeriod = 2e-3;  // of set-points [s]
  const auto fastest = [](const msg::ArmState& state) {
    double speed = 0.0;
    for (const double qd : state.qd()) speed = std::max(speed, std::abs(qd));
    return speed;
  };
  double late_path = 0.0;  // [rad]
  for (std::size_t i = 1; i < history_.size(); ++i) {
    const double dt = 1e-9 * static_cast<double>(history_[i].stamp_ns() - history_[i - 1].stamp_ns());
    late_path += fastest(history_[i - 1]) * std::max(0.0, dt - kPeriod);
  }
  const std::vector<double> q_rest = arm()->q();
  for (const msg::ArmState& state : history_) {
    if (state.mode() != msg::ArmMode::ARM_BRAKING) continue;
    const double T = fastest(state) / 10.0;
    for (std::size_t j = 0; j < q_rest.size(); ++j) {
      EXPECT_NEAR(q_rest[j], state.q()[j] + 0.5 * T * state.qd()[j], 1e-4 + late_path);
    }
  }

  // The driver follows a planner restarted in the same term at once: the planner continues the driver's sequence.
  start_planner();
  ASSERT_TRUE(await([&] { return in(msg::ArmMode::ARM_RUNNING); }));
  send(joint_goal("again", kHome));
  ASSERT_TRUE(await([&] { return is("again", msg::GoalState::GOAL_REACHED); }));
}

TEST_F(MotionStop, HoldStopsTheArmAndRunContinuesToTheSameGoal) {
  start_all();
  move_away("g");
  set_mode(msg::Mode::MODE_HOLD, 1, "the door is open");
  ASSERT_TRUE(await([&] { return in(msg::ArmMode::ARM_STOPPED); }));
  EXPECT_EQ(arm()->cause().text(), "the cell is held: the door is open");
  ASSERT_TRUE(await([&] { return status("g")->cause().text() == "the cell is held: the door is open"; }));
  EXPECT_EQ(status("g")->state(), msg::GoalState::GOAL_ACTIVE);
  set_mode(msg::Mode::MODE_RUN, 1);
  ASSERT_TRUE(await([&] { return is("g", msg::GoalState::GOAL_REACHED); }));
}

TEST_F(MotionStop, SilentSupervisorStopsNoArm) {
  start_all();
  send(joint_goal("g", kFarAway));
  // Reads without publishing the cell mode.
  const auto until = bus::Clock::now() + kLimit;
  while (!is("g", msg::GoalState::GOAL_REACHED) && bus::Clock::now() < until) (void)mailbox_.wait(20ms);
  EXPECT_TRUE(is("g", msg::GoalState::GOAL_REACHED));
}

TEST_F(MotionStop, PlannerStopsWithoutAWorldAndContinuesWithTheNext) {
  ChildProcess& world = start_world();
  start_driver();
  start_planner();
  ASSERT_TRUE(await([&] { return in(msg::ArmMode::ARM_RUNNING); }));
  move_away("g");
  world.signal(SIGKILL);
  ASSERT_TRUE(await([&] { return is("g", msg::GoalState::GOAL_BLOCKED); }));
  EXPECT_EQ(status("g")->cause().text(), "the world service sends no states");
  EXPECT_FALSE(moves());
  start_world();
  ASSERT_TRUE(await([&] { return is("g", msg::GoalState::GOAL_REACHED); }));
}

class MotionStopOfTwo : public MotionCell {
 protected:
  MotionStopOfTwo() : MotionCell(2) {}
};

TEST_F(MotionStopOfTwo, ArmStopsWhileItsNeighbourIsSilent) {
  start_world();
  start_driver("arm1");
  start_planner("arm1");
  ChildProcess& neighbour = start_driver("arm2");
  ASSERT_TRUE(await([&] { return arm("arm1") != nullptr && arm("arm1")->mode() == msg::ArmMode::ARM_RUNNING; }));
  send(joint_goal("g", {-2.5, -1.9, 2.6, 0, 0.6, 0}));
  ASSERT_TRUE(await([&] { return moves("arm1"); }));
  neighbour.signal(SIGKILL);
  ASSERT_TRUE(await([&] { return is("g", msg::GoalState::GOAL_BLOCKED); }));
  EXPECT_EQ(status("g")->cause().text().find("the last state of arm arm2 is "), 0U) << status("g")->cause().text();
  EXPECT_FALSE(moves("arm1"));
  start_driver("arm2");
  ASSERT_TRUE(await([&] { return is("g", msg::GoalState::GOAL_REACHED); }));
}

// The test is the planner here, twice: the second with an older term.
TEST_F(MotionStop, RefusesAndCountsCommandsOfAnOlderTerm) {
  bus::Writer<msg::ArmCommand> commands(participant_);
  start_driver();
  ASSERT_TRUE(commands.wait_matched(1, kLimit));
  msg::ArmCommand command;
  command.arm("arm1");
  command.node("planner/test");
  command.period(0.01);
  command.q(kHome);
  command.qd(std::vector<double>(6, 0.0));
  const auto send_until = [&](std::uint64_t term, const std::function<bool()>& event) {
    command.term(term);
    return await([&] {
      command.sequence_number(command.sequence_number() + 1);
      EXPECT_TRUE(commands.write(command));
      return event();
    });
  };
  EXPECT_TRUE(await([&] { return arm() != nullptr && arm()->newest_term() == 1; }))
      << "the driver hears the supervisor";
  command.term(5);
  for (int i = 0; i < 20; ++i) {
    command.sequence_number(command.sequence_number() + 1);
    EXPECT_TRUE(commands.write(command));
    const auto number = arm()->sequence_number();
    EXPECT_TRUE(await([&] { return arm()->sequence_number() > number; }));
    EXPECT_FALSE(in(msg::ArmMode::ARM_RUNNING)) << "no supervisor has granted the term";
  }
  set_mode(msg::Mode::MODE_RUN, 5);
  ASSERT_TRUE(send_until(5, [&] { return in(msg::ArmMode::ARM_RUNNING); }));
  EXPECT_EQ(arm()->term(), 5U);
  EXPECT_EQ(arm()->stale_rejected(), 0U);

  command.q(kReady);  // where the stale planner would move the arm
  ASSERT_TRUE(send_until(4, [&] { return arm()->stale_rejected() >= 10 && in(msg::ArmMode::ARM_STOPPED); }));
  EXPECT_EQ(arm()->term(), 5U);
  EXPECT_EQ(arm()->cause().text(), "commands of planner/test have term 4, older than term 5");
  for (std::size_t j = 0; j < kHome.size(); ++j) EXPECT_NEAR(arm()->q()[j], kHome[j], 1e-9);

  // A cell mode of a newer term outdates the commands, too.
  set_mode(msg::Mode::MODE_RUN, 7);
  const std::uint64_t refused = arm()->stale_rejected();
  command.q(kHome);
  ASSERT_TRUE(send_until(6, [&] { return arm()->stale_rejected() >= refused + 10; }));
  EXPECT_FALSE(in(msg::ArmMode::ARM_RUNNING));
  ASSERT_TRUE(send_until(7, [&] { return in(msg::ArmMode::ARM_RUNNING); }));
  EXPECT_EQ(arm()->term(), 7U);
}

TEST_F(MotionStop, RefusesUnusableCommandsWithASentence) {
  bus::Writer<msg::ArmCommand> commands(participant_);
  start_driver();
  ASSERT_TRUE(commands.wait_matched(1, kLimit));
  ASSERT_TRUE(await([&] { return arm() != nullptr && arm()->cause().text() == "no command received yet"; }));
  msg::ArmCommand command;
  command.arm("arm1");
  command.node("planner/test");
  command.term(1);
  command.period(0.01);
  command.qd(std::vector<double>(6, 0.0));
  const auto refused = [&](const std::vector<double>& q, const std::string& sentence) {
    command.q(q);
    return await([&] {
      command.sequence_number(command.sequence_number() + 1);
      EXPECT_TRUE(commands.write(command));
      return arm()->cause().text() == sentence;
    });
  };
  EXPECT_TRUE(refused({1, 2, 3}, "command of planner/test: q has 3 joints, the arm has 6")) << arm()->cause().text();
  command.period(5.0);
  EXPECT_TRUE(refused(kHome, "command of planner/test: period = 5.000000 must be above 0 s and at most 0.050000 s"))
      << arm()->cause().text();
  EXPECT_EQ(arm()->mode(), msg::ArmMode::ARM_STARTING);
  EXPECT_EQ(arm()->term(), 0U);
}

}  // namespace
}  // namespace hecaton::test
