#include "services/arm_driver/simulated_drive.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

constexpr double kDt = 0.002;       // [s]
constexpr double kTimeout = 0.050;  // [s]

class Drive : public testing::Test {
 protected:
  static planner::JointLimits limits() {
    planner::JointLimits limits;
    limits.lower = planner::JointVector::Constant(1, -3.0);
    limits.upper = planner::JointVector::Constant(1, 3.0);
    limits.velocity = planner::JointVector::Constant(1, 1.0);
    limits.acceleration = planner::JointVector::Constant(1, 10.0);
    return limits;
  }

  /// A planner that moves at 0.5 rad/s, ten milliseconds a command.
  void plan(std::uint64_t term = 1) {
    msg::ArmCommand command;
    command.term(term);
    command.sequence_number(++sequence_);
    command.period(0.01);
    q_ += 0.005;
    command.q({q_});
    command.qd({0.5});
    (void)drive_.command(command);
    for (int k = 0; k < 5; ++k) drive_.step(kDt);
  }
  void wait(double seconds) {
    for (double t = 0.0; t < seconds - 1e-9; t += kDt) drive_.step(kDt);
  }

  SimulatedDrive drive_{limits(), planner::JointVector::Zero(1), kTimeout};
  double q_ = 0.0;
  std::uint64_t sequence_ = 0;
};

TEST_F(Drive, StandsStillUntilASupervisorWasHeard) {
  for (int k = 0; k < 20; ++k) plan();
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_STARTING);
  EXPECT_EQ(drive_.arm().q()[0], 0.0);
  EXPECT_EQ(drive_.reason(), "no supervisor was heard yet");
  EXPECT_EQ(drive_.gate().sequence(), 20U) << "but says that it hears its planner";
}

TEST_F(Drive, FollowsAndStopsOnItsOwnProfileWhenCommandsCease) {
  drive_.order(msg::Mode::MODE_RUN, "");
  EXPECT_EQ(drive_.reason(), "no command came yet");
  for (int k = 0; k < 100; ++k) plan();
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_RUNNING);
  EXPECT_EQ(drive_.reason(), "");
  EXPECT_NEAR(drive_.arm().qd()[0], 0.5, 1e-2);
  wait(0.030);
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_RUNNING) << "10 + 30 ms without a command are within 50 ms";
  wait(0.014);
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_BRAKING);
  EXPECT_EQ(drive_.reason(), "commands ceased: none for more than 50 ms");
  wait(0.052);  // 0.5 rad/s at 10 rad/s² take 50 ms
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_STOPPED);
  EXPECT_EQ(drive_.arm().qd()[0], 0.0);
}

TEST_F(Drive, HoldStopsItAndCommandsDoNotMoveItMeanwhile) {
  drive_.order(msg::Mode::MODE_RUN, "");
  for (int k = 0; k < 100; ++k) plan();
  drive_.order(msg::Mode::MODE_HOLD, "the cell is held: door");
  plan();
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_BRAKING);
  EXPECT_EQ(drive_.reason(), "the cell is held: door");
  for (int k = 0; k < 20; ++k) plan();
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_STOPPED);
  const double stands = drive_.arm().q()[0];
  drive_.order(msg::Mode::MODE_RUN, "");
  wait(0.1);
  EXPECT_EQ(drive_.arm().q()[0], stands) << "an old command is not taken up again";
  q_ = stands;
  plan();
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_RUNNING);
}

TEST_F(Drive, StopsWhenItsSetPointsAreForAnArmThatIsSomewhereElse) {
  drive_.order(msg::Mode::MODE_RUN, "");
  for (int k = 0; k < 100; ++k) plan();
  q_ += 0.07;  // more than 1 rad/s · (50 + 10) ms, with the 5 ms of the next command
  plan();
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_BRAKING);
  EXPECT_EQ(drive_.reason(), "the set-point is too far away: joint 1 is at 0.500 and told to be at 0.575");
  wait(0.1);
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_STOPPED);
  EXPECT_EQ(drive_.too_far(), 1U);
  EXPECT_GT(drive_.command_age(), 0.1) << "it was not accepted";
  q_ = drive_.arm().q()[0];
  plan();
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_RUNNING);
  EXPECT_EQ(drive_.reason(), "");
}

TEST_F(Drive, AnOutdatedPlannerCannotKeepItMoving) {
  drive_.order(msg::Mode::MODE_RUN, "");
  for (int k = 0; k < 100; ++k) plan(1);
  drive_.saw({{}, 2});
  for (int k = 0; k < 20; ++k) plan(1);
  EXPECT_EQ(drive_.mode(), msg::ArmMode::ARM_STOPPED);
  EXPECT_EQ(drive_.gate().stale_rejected(), 20U);
  EXPECT_EQ(drive_.gate().term(), 1U);
  EXPECT_EQ(drive_.reason(), drive_.gate().complaint());
}

}  // namespace
}  // namespace hecaton::services
