#include "services/supervisor/cell_mode.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using Names = std::vector<std::string>;

class CellModeStateTest : public ::testing::Test {
 protected:
  CellModeState mode_{{"arm1", "arm2", "arm3"}};
};

TEST_F(CellModeStateTest, RunsWithoutOrders) {
  EXPECT_EQ(mode_.decide(), msg::CellMode{});
}

TEST_F(CellModeStateTest, HoldsAndResumesTheCell) {
  EXPECT_TRUE(is_none(mode_.hold({})));
  EXPECT_EQ(mode_.decide().mode(), msg::Mode::MODE_HOLD);
  EXPECT_EQ(causes_text(mode_.decide()), "hold by operator");
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(mode_.decide(), msg::CellMode{});
}

TEST_F(CellModeStateTest, LatchesStop) {
  EXPECT_TRUE(is_none(mode_.stop({})));
  EXPECT_TRUE(is_none(mode_.hold({})));
  EXPECT_EQ(mode_.decide().mode(), msg::Mode::MODE_STOP);
  EXPECT_EQ(mode_.resume({"arm1"}).text(),
            "the whole cell is on stop: resume the cell, then stop single arms if needed");
  EXPECT_EQ(mode_.decide().mode(), msg::Mode::MODE_STOP);
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(mode_.decide().mode(), msg::Mode::MODE_RUN);
}

TEST_F(CellModeStateTest, KeepsOrdersOfSingleArms) {
  EXPECT_TRUE(is_none(mode_.hold({"arm3"})));
  EXPECT_TRUE(is_none(mode_.stop({"arm1"})));
  EXPECT_TRUE(is_none(mode_.hold({"arm1"})));
  const msg::CellMode decision = mode_.decide();
  EXPECT_EQ(decision.mode(), msg::Mode::MODE_RUN);
  EXPECT_EQ(arms_on(decision, msg::Mode::MODE_STOP), Names{"arm1"});
  EXPECT_EQ(arms_on(decision, msg::Mode::MODE_HOLD), Names{"arm3"});
  EXPECT_EQ(causes_text(decision), "arm1: stop by operator; arm3: hold by operator");
  EXPECT_EQ(mode_.mode_of("arm1"), msg::Mode::MODE_STOP);
  EXPECT_EQ(mode_.mode_of("arm2"), msg::Mode::MODE_RUN);
  EXPECT_TRUE(is_none(mode_.resume({"arm1"})));
  EXPECT_EQ(mode_.mode_of("arm1"), msg::Mode::MODE_RUN);
  EXPECT_EQ(mode_.mode_of("arm3"), msg::Mode::MODE_HOLD);
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(mode_.decide(), msg::CellMode{});
}

TEST_F(CellModeStateTest, SetsTheSpeedOfTheCellAndOfArms) {
  EXPECT_TRUE(is_none(mode_.set_speed({}, 0.5)));
  EXPECT_TRUE(is_none(mode_.set_speed({"arm1", "arm2"}, 0.3)));
  EXPECT_TRUE(is_none(mode_.set_speed({"arm3"}, 0.8)));
  EXPECT_EQ(mode_.speed_of("arm1"), 0.3);
  EXPECT_EQ(mode_.speed_of("arm3"), 0.5) << "the cell's is lower";
  EXPECT_TRUE(is_none(mode_.set_speed({"arm1"}, 1.0)));
  EXPECT_EQ(mode_.speed_of("arm1"), 0.5);
  const msg::CellMode decision = mode_.decide();
  EXPECT_EQ(decision.speed(), 0.5);
  ASSERT_EQ(decision.speeds().size(), 2U);
  EXPECT_EQ(decision.speeds()[0].arm(), "arm2");
  EXPECT_EQ(orders_in(decision), mode_.orders());
  EXPECT_TRUE(is_none(mode_.set_speed({}, 1.0)));
  EXPECT_EQ(mode_.speed_of("arm2"), 0.3) << "an arm keeps its own";
}

TEST_F(CellModeStateTest, KeepsTheSpeedWhenPeopleHoldAndResume) {
  EXPECT_TRUE(is_none(mode_.set_speed({}, 0.3)));
  EXPECT_TRUE(is_none(mode_.stop({})));
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(mode_.speed_of("arm1"), 0.3);
}

TEST_F(CellModeStateTest, RefusesSpeedsBeyondTheLimitsAndUnknownArms) {
  EXPECT_TRUE(is_none(mode_.set_speed({}, 0.01)));
  for (const double speed : {0.0099, 0.0, -0.3, 1.001, 30.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(mode_.set_speed({}, speed).kind(), msg::CauseKind::CAUSE_INVALID_VALUE) << speed;
    EXPECT_EQ(mode_.slow_down({"arm1"}, speed).kind(), msg::CauseKind::CAUSE_INVALID_VALUE) << speed;
  }
  EXPECT_EQ(mode_.set_speed({}, 30.0).text(), "speed 3000 % must be 1 % to 100 %; nothing was changed");
  EXPECT_EQ(mode_.set_speed({"arm1", "arm9"}, 0.3).kind(), msg::CauseKind::CAUSE_UNKNOWN_NAME);
  EXPECT_EQ(mode_.speed_of("arm1"), 0.01);
  EXPECT_TRUE(mode_.orders().speeds.empty());
}

TEST_F(CellModeStateTest, TakesOverTheLowerSpeeds) {
  EXPECT_TRUE(is_none(mode_.set_speed({}, 0.5)));
  EXPECT_TRUE(is_none(mode_.slow_down({}, 0.7)));
  EXPECT_TRUE(is_none(mode_.slow_down({"arm1"}, 0.2)));
  EXPECT_EQ(mode_.orders().speed, 0.5);
  Orders others;
  others.speed = 0.4;
  others.speeds = {{"arm1", 0.6}, {"arm2", 0.1}, {"arm9", 0.1}};
  mode_.add(others);
  EXPECT_EQ(mode_.orders().speed, 0.4);
  EXPECT_EQ(mode_.orders().speeds, (std::map<std::string, double, std::less<>>{{"arm1", 0.2}, {"arm2", 0.1}}));
  mode_.restore(others);
  EXPECT_EQ(mode_.speed_of("arm1"), 0.4) << "a restored order replaces";
}

TEST_F(CellModeStateTest, ResumesAnArmStoppedByNameOnlyByName) {
  EXPECT_TRUE(is_none(mode_.stop({"arm1"})));
  EXPECT_TRUE(is_none(mode_.hold({"arm2"})));
  EXPECT_TRUE(is_none(mode_.stop({})));
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(mode_.decide().mode(), msg::Mode::MODE_RUN);
  EXPECT_EQ(arms_on(mode_.decide(), msg::Mode::MODE_STOP), Names{"arm1"});
  EXPECT_TRUE(arms_on(mode_.decide(), msg::Mode::MODE_HOLD).empty()) << "a hold is no latch";
  EXPECT_EQ(mode_.mode_of("arm1"), msg::Mode::MODE_STOP);
  EXPECT_TRUE(is_none(mode_.resume({"arm1"})));
  EXPECT_EQ(mode_.decide(), msg::CellMode{});
}

TEST_F(CellModeStateTest, ResumesAnArmOnlyByNameAndOnlyAfterTheFaultOfItsDevice) {
  const msg::Cause device = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "arm1", "protective stop");
  AutomaticHolds holds;
  holds.arms["arm1"] = device;
  mode_.set_automatic(holds);
  mode_.hold_until_resumed("arm1", device);
  mode_.hold_until_resumed("arm2", make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "planner/arm2", "signal 9"));
  EXPECT_TRUE(is_none(mode_.hold({"arm3"})));

  EXPECT_EQ(mode_.resume({"arm3", "arm1"}),
            make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, "arm1",
                       "the fault of its device lasts, so that no arm was resumed: protective stop"));
  EXPECT_EQ(mode_.mode_of("arm3"), msg::Mode::MODE_HOLD);
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(arms_on(mode_.decide(), msg::Mode::MODE_HOLD), Names{"arm1"});
  mode_.set_automatic({});
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(mode_.mode_of("arm1"), msg::Mode::MODE_HOLD);
  EXPECT_TRUE(is_held_for_device(mode_.decide(), "arm1"));
  EXPECT_TRUE(is_none(mode_.resume({"arm1"})));
  EXPECT_EQ(mode_.decide(), msg::CellMode{});
}

// A person may stand beside an arm whose device has stopped, whatever fails after that.
TEST_F(CellModeStateTest, KeepsTheHoldForADeviceWhenAnotherFaultHoldsTheArm) {
  const msg::Cause device = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "arm1", "protective stop");
  const msg::Cause planner = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "planner/arm1", "signal 9");
  const msg::Cause later = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "arm1", "emergency stop");
  mode_.hold_until_resumed("arm1", device);
  mode_.hold_until_resumed("arm1", planner);
  EXPECT_EQ(mode_.causes().at("arm1"), device);
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(mode_.mode_of("arm1"), msg::Mode::MODE_HOLD);
  mode_.hold_until_resumed("arm1", later);
  EXPECT_EQ(mode_.causes().at("arm1"), later) << "the newest of its device";
  EXPECT_TRUE(is_none(mode_.resume({"arm1"})));
  EXPECT_EQ(mode_.decide(), msg::CellMode{});
}

TEST_F(CellModeStateTest, TakesOverTheHoldsForDevicesOfAnotherLeader) {
  const msg::Cause device = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "arm1", "protective stop");
  const msg::Cause planner = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "planner/arm1", "signal 9");
  CellModeState leader({"arm1", "arm2", "arm3"});
  leader.hold_until_resumed("arm1", device);
  leader.hold_until_resumed("arm2", planner);
  EXPECT_TRUE(is_none(leader.hold({"arm3"})));
  EXPECT_EQ(device_causes_in(leader.decide()), (CausesByArm{{"arm1", device}}));

  mode_.hold_until_resumed("arm1", planner);
  mode_.restore(orders_in(leader.decide()), device_causes_in(leader.decide()));
  EXPECT_EQ(mode_.causes().at("arm1"), device);
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(arms_on(mode_.decide(), msg::Mode::MODE_HOLD), Names{"arm1"});
}

TEST_F(CellModeStateTest, RejectsAnUnknownArmWithoutAChange) {
  EXPECT_EQ(mode_.stop({"arm1", "arm9"}).text(), "unknown arm arm9: this cell's arms are arm1, arm2, arm3");
  EXPECT_EQ(mode_.hold({"arm9"}).text(), "unknown arm arm9: this cell's arms are arm1, arm2, arm3");
  EXPECT_EQ(mode_.resume({"arm9"}).text(), "unknown arm arm9: this cell's arms are arm1, arm2, arm3");
  EXPECT_EQ(mode_.decide(), msg::CellMode{});
}

TEST_F(CellModeStateTest, ResumeKeepsAutomaticHolds) {
  AutomaticHolds holds;
  holds.arms["arm2"] = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "planner/arm2", "planner/arm2: dead");
  mode_.set_automatic(holds);
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(arms_on(mode_.decide(), msg::Mode::MODE_HOLD), Names{"arm2"});
  EXPECT_EQ(causes_text(mode_.decide()), "arm2: planner/arm2: dead");
  EXPECT_EQ(mode_.cause_of("arm2").text(), "held: planner/arm2: dead");
}

TEST_F(CellModeStateTest, ClearedFaultKeepsOrders) {
  EXPECT_TRUE(is_none(mode_.hold({"arm2"})));
  AutomaticHolds holds;
  holds.arms["arm2"] = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "planner/arm2", "planner/arm2: dead");
  mode_.set_automatic(holds);
  mode_.set_automatic({});
  EXPECT_EQ(arms_on(mode_.decide(), msg::Mode::MODE_HOLD), Names{"arm2"});
  EXPECT_EQ(mode_.cause_of("arm2").text(), "on hold by operator: waits for resume");
}

TEST_F(CellModeStateTest, AutomaticHoldDoesNotWeakenStop) {
  EXPECT_TRUE(is_none(mode_.stop({})));
  mode_.set_automatic({make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "world", "world: silent"), {}});
  EXPECT_EQ(mode_.decide().mode(), msg::Mode::MODE_STOP);
  EXPECT_TRUE(is_none(mode_.resume({})));
  EXPECT_EQ(mode_.decide().mode(), msg::Mode::MODE_HOLD);
  EXPECT_EQ(mode_.mode_of("arm1"), msg::Mode::MODE_HOLD);
}

TEST_F(CellModeStateTest, HoldsForACauseWithoutText) {
  AutomaticHolds holds;
  holds.cell = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "world", "");
  holds.arms["arm2"] = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "planner/arm2", "");
  mode_.set_automatic(holds);
  EXPECT_EQ(mode_.decide().mode(), msg::Mode::MODE_HOLD);
  EXPECT_EQ(mode_.decide().cause().subject(), "world");
  EXPECT_EQ(arms_on(mode_.decide(), msg::Mode::MODE_HOLD), Names{"arm2"});
  EXPECT_EQ(mode_.cause_of("arm1").kind(), msg::CauseKind::CAUSE_HELD_BY_FAULT);
}

TEST_F(CellModeStateTest, CausesNameTheOrderAndTheFault) {
  EXPECT_TRUE(is_none(mode_.stop({"arm1"})));
  mode_.hold_until_resumed("arm3", make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "planner/arm3", "signal 9"));
  const msg::CellMode decision = mode_.decide();
  ASSERT_EQ(decision.arms().size(), 2U);
  EXPECT_EQ(decision.arms()[0].cause(), make_cause(msg::CauseKind::CAUSE_STOP_ORDERED, "arm1", "stop by operator"));
  EXPECT_EQ(decision.arms()[1].cause(),
            make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "planner/arm3", "hold until resumed: signal 9"));
}

TEST_F(CellModeStateTest, TellsAFaultOnceThatLastsAndWaitsForResume) {
  const msg::Cause fault = make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "arm3", "the robot does not answer");
  mode_.hold_until_resumed("arm3", fault);
  AutomaticHolds holds;
  holds.arms["arm3"] = fault;
  mode_.set_automatic(holds);
  EXPECT_EQ(mode_.decide().arms().at(0).cause().text(), "hold until resumed: the robot does not answer");
  EXPECT_EQ(mode_.cause_of("arm3").text(), "on hold until resumed: the robot does not answer");
  holds.arms["arm3"].text("the emergency stop is pressed");
  mode_.set_automatic(holds);
  EXPECT_EQ(mode_.cause_of("arm3").text(),
            "on hold until resumed: the robot does not answer; held: the emergency stop is pressed");
}

TEST_F(CellModeStateTest, RestoresOrdersOfKnownArms) {
  Orders orders;
  orders.cell = msg::Mode::MODE_STOP;
  orders.arms = {{"arm1", msg::Mode::MODE_HOLD}, {"gone", msg::Mode::MODE_STOP}};
  mode_.restore(orders);
  EXPECT_EQ(mode_.orders().cell, msg::Mode::MODE_STOP);
  EXPECT_EQ(mode_.orders().arms.size(), 1U);
}

}  // namespace
}  // namespace hecaton::services
