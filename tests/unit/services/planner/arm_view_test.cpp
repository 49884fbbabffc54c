#include "services/planner/arm_view.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "services/config/cell_file.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

class ArmViewTest : public testing::Test {
 protected:
  static planner::Cell cell() {
    const std::string text =
        "name: c\n"
        "defaults: {urdf: urdf/puma560.urdf, poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}}\n"
        "arms: [{name: arm1}, {name: arm2, base: {xyz: [0, 2, 0]}}]\n";
    return config::parse_cell_file(text, std::string(HECATON_SOURCE_DIR) + "/deploy/cells/test.yaml").cell;
  }
  static msg::ArmState state(const std::string& arm, std::uint64_t sequence, double q0 = 0.0) {
    msg::ArmState message;
    message.arm(arm);
    message.sequence_number(sequence);
    message.mode(msg::ArmMode::ARM_RUNNING);
    message.q({q0, 0, 0, 0, 0, 0});
    message.qd(std::vector<double>(6, 0.0));
    return message;
  }
  CellModeView mode(const std::vector<std::string>& held = {}, const std::vector<msg::LostArm>& lost = {}) const {
    msg::CellMode message;
    message.mode(msg::Mode::MODE_RUN);
    message.term(1);
    for (const std::string& arm : held) {
      msg::ArmOrder& order = message.arms().emplace_back();
      order.arm(arm);
      order.mode(msg::Mode::MODE_HOLD);
    }
    message.lost_arms(lost);
    CellModeView view;
    EXPECT_TRUE(view.apply(message, now_));
    return view;
  }
  /// Lost at rest in q = (q0, 0, …), with a braking delay of 0.1 s.
  static msg::LostArm lost(std::int64_t stamp_ns, double q0) {
    msg::LostArm arm;
    arm.arm("arm2");
    arm.stamp_ns(stamp_ns);
    arm.q({q0, 0, 0, 0, 0, 0});
    arm.qd(std::vector<double>(6, 0.0));
    arm.braking_delay_bound(0.1);
    return arm;
  }

  ArmView view_{cell(), 0};
  ArmView::Clock::time_point now_{10s};
};

TEST_F(ArmViewTest, RejectsAStateWithAnInvalidCommandAge) {
  for (const double age : {std::nan(""), -std::numeric_limits<double>::infinity()}) {
    msg::ArmState unsound = state("arm1", 1);
    unsound.command_age(age);
    EXPECT_NE(view_.apply(unsound, {}, now_).value().find("command_age = "), std::string::npos);
  }
  EXPECT_FALSE(view_.arm(0));
}

TEST_F(ArmViewTest, MeasuresAgesFromTheArrival) {
  EXPECT_TRUE(std::isinf(view_.age(1, now_)));
  EXPECT_FALSE(view_.observe(now_, mode())[1].known);
  EXPECT_EQ(view_.apply(state("arm2", 1, 0.5), {}, now_), std::nullopt);
  const auto seen = view_.observe(now_ + 30ms, mode());
  EXPECT_TRUE(seen[1].known);
  EXPECT_DOUBLE_EQ(seen[1].age, 0.03);
  EXPECT_EQ(seen[1].q[0], 0.5);
  EXPECT_FALSE(seen[0].known);
}

TEST_F(ArmViewTest, AddsTheDelayOfAState) {
  const auto hear = [this](std::uint64_t sequence, std::int64_t stamp_ms, ArmView::Clock::time_point received) {
    msg::ArmState message = state("arm2", sequence);
    message.stamp_ns(stamp_ms * 1'000'000);
    EXPECT_EQ(view_.apply(message, {}, received), std::nullopt);
  };
  hear(1, 0, now_);
  hear(2, 10, now_ + 50ms);  // 40 ms later than the first
  EXPECT_DOUBLE_EQ(view_.age(1, now_ + 50ms), 0.04);
}

TEST_F(ArmViewTest, CountsTheCommandsSinceTheMeasurementOfAFailedDeviceAsItsAge) {
  msg::ArmState message = state("arm2", 1);
  message.command_age(-60.0);
  EXPECT_EQ(view_.apply(message, {}, now_), std::nullopt);
  EXPECT_EQ(view_.age(1, now_), 0.0) << "a device that works";
  message.sequence_number(2);
  message.mode(msg::ArmMode::ARM_FAILED);
  EXPECT_EQ(view_.apply(message, {}, now_), std::nullopt);
  EXPECT_DOUBLE_EQ(view_.age(1, now_), 60.0);
  message.sequence_number(3);
  message.command_age(-1e300);
  EXPECT_EQ(view_.apply(message, {}, now_), std::nullopt);
  EXPECT_DOUBLE_EQ(view_.age(1, now_), 1e6);
}

TEST_F(ArmViewTest, CountsOnlyRunningArmsAsAvoiding) {
  EXPECT_EQ(view_.apply(state("arm2", 1), {}, now_), std::nullopt);
  EXPECT_TRUE(view_.observe(now_, mode())[1].plans);
  EXPECT_FALSE(view_.observe(now_, mode({"arm2"}))[1].plans);
  EXPECT_FALSE(view_.observe(now_, CellModeView())[1].plans) << "no supervisor: no arm may move";
  for (const msg::ArmMode stands :
       {msg::ArmMode::ARM_STARTING, msg::ArmMode::ARM_BRAKING, msg::ArmMode::ARM_STOPPED, msg::ArmMode::ARM_FAILED}) {
    static std::uint64_t sequence = 1;
    msg::ArmState message = state("arm2", ++sequence);
    message.mode(stands);
    EXPECT_EQ(view_.apply(message, {}, now_), std::nullopt);
    EXPECT_FALSE(view_.observe(now_, mode())[1].plans);
  }
}

TEST_F(ArmViewTest, CountsAnArmThatLagsAsAvoidingUntilItsStopBegins) {
  msg::ArmState message = state("arm2", 1);
  message.tracking_delay(0.15);
  EXPECT_EQ(view_.apply(message, {}, now_), std::nullopt);
  EXPECT_TRUE(view_.observe(now_, mode())[1].plans);
  message.sequence_number(2);
  message.mode(msg::ArmMode::ARM_BRAKING);
  EXPECT_EQ(view_.apply(message, {}, now_ + 10ms), std::nullopt);
  EXPECT_TRUE(view_.observe(now_ + 140ms, mode())[1].plans);
  EXPECT_FALSE(view_.observe(now_ + 160ms, mode())[1].plans);
  EXPECT_FALSE(view_.observe(now_ + 170ms, mode())[1].plans);
}

TEST_F(ArmViewTest, KnowsAnArmThatOthersMove) {
  msg::ArmState message = state("arm2", 1);
  message.mode(msg::ArmMode::ARM_OBSERVED);
  EXPECT_EQ(view_.apply(message, {}, now_), std::nullopt);
  EXPECT_TRUE(view_.observe(now_, mode())[1].foreign);
  EXPECT_FALSE(view_.observe(now_, mode())[1].plans);
  EXPECT_TRUE(view_.observe(now_, mode({"arm2"}))[1].foreign) << "no hold of the cell stops it";
  for (const std::uint64_t sequence : {2, 3}) {
    message.sequence_number(sequence);
    message.mode(msg::ArmMode::ARM_FAILED);
    EXPECT_EQ(view_.apply(message, {}, now_), std::nullopt);
    EXPECT_TRUE(view_.observe(now_, mode())[1].foreign) << "its device fails, and others move it on";
  }
  message = state("arm2", 4);
  EXPECT_EQ(view_.apply(message, {}, now_), std::nullopt);
  EXPECT_FALSE(view_.observe(now_, mode())[1].foreign);
  EXPECT_TRUE(view_.observe(now_, mode())[1].plans);
}

TEST_F(ArmViewTest, DropsOldStatesButNotThoseOfARestartedDriver) {
  EXPECT_EQ(view_.apply(state("arm1", 9, 0.9), {}, now_), std::nullopt);
  EXPECT_EQ(view_.apply(state("arm1", 8, 0.8), {}, now_), std::nullopt);
  EXPECT_EQ(view_.arm(0)->q[0], 0.9);
  bus::EndpointId restarted;
  restarted.bytes[0] = 1;
  EXPECT_EQ(view_.apply(state("arm1", 1, 0.1), restarted, now_), std::nullopt);
  EXPECT_EQ(view_.arm(0)->q[0], 0.1);
}

TEST_F(ArmViewTest, RejectsInvalidStatesWithASentence) {
  EXPECT_EQ(view_.apply(state("arm3", 1), {}, now_), "ArmState of arm3: no such arm in this cell");
  msg::ArmState bad = state("arm1", 1);
  bad.q({1, 2});
  EXPECT_EQ(view_.apply(bad, {}, now_), "ArmState of arm1: q has 2 joints, the arm has 6");
  bad = state("arm1", 1, NAN);
  EXPECT_EQ(view_.apply(bad, {}, now_), "ArmState of arm1: q[0] = nan must be finite");
  EXPECT_FALSE(view_.arm(0));
}

TEST_F(ArmViewTest, KnowsGoalsUntilTheyEnd) {
  ArmView view(cell(), 0);
  msg::GoalStatus status;
  status.arm("arm2");
  status.goal("g1");
  status.state(msg::GoalState::GOAL_ACTIVE);
  status.q_goal({1, 2, 3, 4, 5, 6});
  EXPECT_EQ(view.apply(status), std::nullopt);
  const auto seen = view.observe(ArmView::Clock::now(), mode());
  EXPECT_TRUE(seen[1].has_goal);
  EXPECT_EQ(seen[1].q_goal[5], 6.0);
  EXPECT_FALSE(seen[0].has_goal);

  status.goal("g0");  // a late status of an earlier goal
  status.state(msg::GoalState::GOAL_REPLACED);
  EXPECT_EQ(view.apply(status), std::nullopt);
  EXPECT_TRUE(view.observe(ArmView::Clock::now(), mode())[1].has_goal);
  status.goal("g1");
  status.state(msg::GoalState::GOAL_REACHED);
  EXPECT_EQ(view.apply(status), std::nullopt);
  EXPECT_FALSE(view.observe(ArmView::Clock::now(), mode())[1].has_goal);

  status.state(msg::GoalState::GOAL_ACTIVE);
  status.q_goal({1, 2});
  EXPECT_NE(view.apply(status), std::nullopt);
  status.arm("arm9");
  EXPECT_EQ(view.apply(status), "GoalStatus of arm9: no such arm in this cell");
}

TEST_F(ArmViewTest, ObservesALostArmInItsStopSet) {
  msg::ArmState last = state("arm2", 1, 0.5);
  last.stamp_ns(1000);
  EXPECT_EQ(view_.apply(last, {}, now_), std::nullopt);
  now_ += 1s;
  EXPECT_FALSE(view_.observe(now_, mode({"arm2"}))[1].lost());
  EXPECT_FALSE(view_.lost(1, now_, mode({"arm2"})));

  const CellModeView older = mode({"arm2"}, {lost(900, 0.3)});
  EXPECT_TRUE(view_.lost(1, now_, older));
  planner::ArmObservation seen = view_.observe(now_, older)[1];
  EXPECT_TRUE(seen.known);
  EXPECT_TRUE(seen.lost());
  EXPECT_FALSE(seen.plans);
  EXPECT_EQ(seen.age, 0.0);
  EXPECT_EQ(seen.q[0], 0.5) << "the planner's own state is newer";
  EXPECT_GT(seen.position_uncertainty[0], 0.0);
  EXPECT_EQ(seen.qd.norm(), 0.0);

  seen = view_.observe(now_, mode({"arm2"}, {lost(1100, 0.3)}))[1];
  EXPECT_EQ(seen.q[0], 0.3) << "the supervisor's state is newer";
  EXPECT_FALSE(view_.lost(0, now_, mode({}, {lost(1100, 0.3)})));
}

TEST_F(ArmViewTest, KnowsALostArmFromTheSupervisorAlone) {
  const planner::ArmObservation seen = view_.observe(now_, mode({"arm2"}, {lost(1, 0.3)}))[1];
  EXPECT_TRUE(seen.known);
  EXPECT_EQ(seen.q[0], 0.3);
}

TEST_F(ArmViewTest, LosesNoArmWithFreshStates) {
  EXPECT_EQ(view_.apply(state("arm2", 1, 0.5), {}, now_), std::nullopt);
  EXPECT_FALSE(view_.observe(now_ + 10ms, mode({"arm2"}, {lost(1, 0.3)}))[1].lost());
}

// This planner itself may be cut off.
TEST_F(ArmViewTest, LosesNoArmWithoutAFreshCellMode) {
  EXPECT_EQ(view_.apply(state("arm2", 1, 0.5), {}, now_), std::nullopt);
  const CellModeView mode = this->mode({"arm2"}, {lost(1, 0.3)});
  EXPECT_TRUE(view_.observe(now_ + 260ms, mode)[1].age > 0.25);
  EXPECT_FALSE(view_.observe(now_ + 260ms, mode)[1].lost());
}

msg::ArmState commanded_by(msg::ArmState state, const std::string& planner, std::uint64_t term) {
  state.planner(planner);
  state.newest_term(term);
  return state;
}

/// Progress of arm2 in plan 7 of arm1, or in no plan.
msg::CoupledPlanProgress progress(const std::string& planner, bool takes_part) {
  msg::CoupledPlanProgress message;
  message.arm("arm2");
  message.node(planner);
  if (takes_part) message.proposer("arm1");
  message.number(takes_part ? 7 : 0);
  message.reached(-1);
  return message;
}

msg::CoupledPlan proposal(const std::string& planner) {
  msg::CoupledPlan message;
  message.arm("arm2");
  message.node(planner);
  message.number(3);
  message.arms({"arm1", "arm2"});
  message.points(1);
  message.q(std::vector<double>(12, 0.5));
  return message;
}

TEST_F(ArmViewTest, IgnoresPlansOfAPlannerThatIsNotInCharge) {
  EXPECT_EQ(view_.apply(commanded_by(state("arm2", 1), "p", 1), {}, now_), std::nullopt);
  EXPECT_EQ(view_.apply(progress("p", true)), std::nullopt);
  EXPECT_EQ(view_.apply(proposal("p")), std::nullopt);
  EXPECT_TRUE(view_.observe(now_, mode())[1].progress.of(0, 7));
  ASSERT_NE(view_.observe(now_, mode())[1].proposal, nullptr);
  EXPECT_EQ(view_.observe(now_, mode())[1].proposal->number, 3U);

  EXPECT_EQ(view_.apply(commanded_by(state("arm2", 2), "q", 2), {}, now_), std::nullopt);
  EXPECT_FALSE(view_.observe(now_, mode())[1].progress.of(0, 7));
  EXPECT_EQ(view_.observe(now_, mode())[1].proposal, nullptr);
  EXPECT_EQ(view_.apply(proposal("p")), std::nullopt) << "late";
  EXPECT_EQ(view_.observe(now_, mode())[1].proposal, nullptr);
  EXPECT_EQ(view_.apply(progress("q", true)), std::nullopt);
  EXPECT_TRUE(view_.observe(now_, mode())[1].progress.of(0, 7));
}

// Messages of planner and driver may arrive in either order.
TEST_F(ArmViewTest, AppliesPlansWhenTheDriverFollowsTheirPlanner) {
  EXPECT_EQ(view_.apply(commanded_by(state("arm2", 1), "p", 1), {}, now_), std::nullopt);
  EXPECT_EQ(view_.apply(progress("p", false)), std::nullopt);
  EXPECT_EQ(view_.apply(progress("q", true)), std::nullopt);
  EXPECT_FALSE(view_.observe(now_, mode())[1].progress.of(0, 7));
  EXPECT_EQ(view_.apply(commanded_by(state("arm2", 2), "q", 2), {}, now_), std::nullopt);
  EXPECT_TRUE(view_.observe(now_, mode())[1].progress.of(0, 7));
}

// An intruder invents planners.
TEST_F(ArmViewTest, KeepsThePlanOfThePlannerInChargeAmongManyOthers) {
  EXPECT_EQ(view_.apply(commanded_by(state("arm2", 1), "p", 1), {}, now_), std::nullopt);
  EXPECT_EQ(view_.apply(proposal("p")), std::nullopt);
  const std::weak_ptr<const planner::CoupledPlan> forged = [&] {
    EXPECT_EQ(view_.apply(proposal("x")), std::nullopt);
    EXPECT_EQ(view_.apply(commanded_by(state("arm2", 2), "x", 1), {}, now_), std::nullopt);
    const auto shown = view_.observe(now_, mode())[1].proposal;
    EXPECT_NE(shown, nullptr);
    EXPECT_EQ(view_.apply(commanded_by(state("arm2", 3), "p", 1), {}, now_), std::nullopt);
    return std::weak_ptr<const planner::CoupledPlan>(shown);
  }();
  EXPECT_NE(view_.observe(now_, mode())[1].proposal, nullptr);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(view_.apply(progress("x" + std::to_string(i), true)), std::nullopt);
  EXPECT_NE(view_.observe(now_, mode())[1].proposal, nullptr);
  EXPECT_TRUE(forged.expired()) << "it takes no memory";
}

TEST_F(ArmViewTest, ForgetsPlansOfARestartedPlanner) {
  EXPECT_EQ(view_.apply(commanded_by(state("arm2", 1), "p", 1), {}, now_), std::nullopt);
  EXPECT_EQ(view_.apply(progress("p", true)), std::nullopt);
  EXPECT_EQ(view_.apply(proposal("p")), std::nullopt);
  EXPECT_EQ(view_.apply(progress("p", false)), std::nullopt);
  msg::CoupledPlan none;
  none.arm("arm2");
  none.node("p");
  EXPECT_EQ(view_.apply(none), std::nullopt);
  EXPECT_FALSE(view_.observe(now_, mode())[1].progress.of(0, 7));
  EXPECT_EQ(view_.observe(now_, mode())[1].proposal, nullptr);
}

TEST_F(ArmViewTest, IgnoresPlansOfAnArmWithoutCommands) {
  msg::ArmState last = commanded_by(state("arm2", 1), "p", 1);
  EXPECT_EQ(view_.apply(last, {}, now_), std::nullopt);
  EXPECT_EQ(view_.apply(progress("p", true)), std::nullopt);
  const auto takes_part = [&](msg::ArmMode arm_mode) {
    last.sequence_number(last.sequence_number() + 1);
    last.mode(arm_mode);
    EXPECT_EQ(view_.apply(last, {}, now_), std::nullopt);
    return view_.observe(now_, mode())[1].progress.of(0, 7);
  };
  EXPECT_TRUE(takes_part(msg::ArmMode::ARM_BRAKING)) << "a command is late";
  EXPECT_FALSE(takes_part(msg::ArmMode::ARM_STOPPED));
  EXPECT_TRUE(takes_part(msg::ArmMode::ARM_RUNNING));
  EXPECT_FALSE(takes_part(msg::ArmMode::ARM_FAILED));
  EXPECT_FALSE(takes_part(msg::ArmMode::ARM_STARTING));
}

TEST_F(ArmViewTest, TreatsALostArmWithAnInvalidStateAsUnknown) {
  msg::LostArm broken = lost(1, 0.3);
  broken.q().pop_back();
  EXPECT_FALSE(view_.observe(now_, mode({"arm2"}, {broken}))[1].known);
}

/// A plan of arm2 for both arms with `points` points.
msg::CoupledPlan both_arms(std::uint32_t points) {
  msg::CoupledPlan plan;
  plan.arm("arm2");
  plan.number(7);
  plan.arms({"arm1", "arm2"});
  plan.points(points);
  plan.q(std::vector<double>(12 * static_cast<std::size_t>(points), 0.5));
  return plan;
}

TEST_F(ArmViewTest, TakesAndWithdrawsACoupledPlan) {
  EXPECT_EQ(view_.apply(both_arms(3)), std::nullopt);
  auto plan = view_.observe(now_, mode())[1].proposal;
  ASSERT_NE(plan, nullptr);
  EXPECT_EQ(plan->number, 7U);
  EXPECT_EQ(plan->arms, (std::vector<int>{0, 1}));
  ASSERT_EQ(plan->points.size(), 3U);
  EXPECT_EQ(plan->points[2][1], planner::JointVector::Constant(6, 0.5));
  msg::CoupledPlan none;
  none.arm("arm2");
  EXPECT_EQ(view_.apply(none), std::nullopt);
  EXPECT_EQ(view_.observe(now_, mode())[1].proposal, nullptr);
}

TEST_F(ArmViewTest, RejectsInvalidCoupledPlansWithASentence) {
  const auto refused = [&](const msg::CoupledPlan& plan, const std::string& why) {
    const std::string said = view_.apply(plan).value_or("");
    EXPECT_NE(said.find("CoupledPlan of " + plan.arm()), std::string::npos) << said;
    EXPECT_NE(said.find(why), std::string::npos) << said;
    EXPECT_EQ(view_.observe(now_, mode())[1].proposal, nullptr) << why;
  };
  msg::CoupledPlan plan = both_arms(2);
  plan.arm("arm9");
  refused(plan, "no such arm in this cell");
  plan = both_arms(2);
  plan.arms({"arm1", "arm9"});
  refused(plan, "arm arm9 is not in this cell");
  plan = both_arms(2);
  plan.arms({"arm2", "arm2"});
  refused(plan, "not in the cell's order");
  plan = both_arms(2);
  plan.arms({"arm1"});
  plan.points(4);
  refused(plan, "its proposer is not one of its arms");
  plan = both_arms(2);
  plan.points(0xFFFFFFFFU);
  refused(plan, "24 joint values must be 4294967295 points of 12 joints");
  plan.arms().clear();
  refused(plan, "it has points, but no arms");
  plan.q().clear();
  refused(plan, "it has points, but no arms");
  refused(both_arms(0), "it has arms, but no points");
  plan = both_arms(2);
  plan.q().pop_back();
  refused(plan, "23 joint values must be 2 points of 12 joints");
  for (const double unsound : {std::nan(""), HUGE_VAL}) {
    plan = both_arms(2);
    plan.q()[20] = unsound;
    refused(plan, "must be finite");
  }
}

}  // namespace
}  // namespace hecaton::services
