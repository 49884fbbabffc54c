#include "services/supervisor/cell_mode.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using Names = std::vector<std::string>;

class CellModeStateTest : public ::testing::Test {
 protected:
  CellModeState mode_{{"arm1", "arm2", "arm3"}};
};

TEST_F(CellModeStateTest, RunsWithoutOrders) {
  EXPECT_EQ(mode_.decide(), ModeDecision{});
}

TEST_F(CellModeStateTest, HoldAndResumeTheCell) {
  EXPECT_EQ(mode_.hold({}), "");
  EXPECT_EQ(mode_.decide().cell, MoveMode::kHold);
  EXPECT_EQ(mode_.decide().reason, "hold by operator");
  EXPECT_EQ(mode_.resume({}), "");
  EXPECT_EQ(mode_.decide(), ModeDecision{});
}

TEST_F(CellModeStateTest, StopIsLatched) {
  EXPECT_EQ(mode_.stop({}), "");
  EXPECT_EQ(mode_.hold({}), "");
  EXPECT_EQ(mode_.decide().cell, MoveMode::kStop);
  EXPECT_EQ(mode_.resume({"arm1"}), "the whole cell is on stop: resume the cell, then stop single arms if you wish");
  EXPECT_EQ(mode_.decide().cell, MoveMode::kStop);
  EXPECT_EQ(mode_.resume({}), "");
  EXPECT_EQ(mode_.decide().cell, MoveMode::kRun);
}

TEST_F(CellModeStateTest, ArmsHaveOrdersOfTheirOwn) {
  EXPECT_EQ(mode_.hold({"arm3"}), "");
  EXPECT_EQ(mode_.stop({"arm1"}), "");
  EXPECT_EQ(mode_.hold({"arm1"}), "");
  const ModeDecision decision = mode_.decide();
  EXPECT_EQ(decision.cell, MoveMode::kRun);
  EXPECT_EQ(decision.stopped_arms, Names{"arm1"});
  EXPECT_EQ(decision.held_arms, Names{"arm3"});
  EXPECT_EQ(decision.reason, "arm1: stop by operator; arm3: hold by operator");
  EXPECT_EQ(mode_.mode_of("arm1"), MoveMode::kStop);
  EXPECT_EQ(mode_.mode_of("arm2"), MoveMode::kRun);
  EXPECT_EQ(mode_.resume({"arm1"}), "");
  EXPECT_EQ(mode_.mode_of("arm1"), MoveMode::kRun);
  EXPECT_EQ(mode_.mode_of("arm3"), MoveMode::kHold);
  EXPECT_EQ(mode_.resume({}), "");
  EXPECT_EQ(mode_.decide(), ModeDecision{});
}

TEST_F(CellModeStateTest, WhoWasStoppedByNameIsResumedByNameOnly) {
  EXPECT_EQ(mode_.stop({"arm1"}), "");
  EXPECT_EQ(mode_.hold({"arm2"}), "");
  EXPECT_EQ(mode_.stop({}), "");
  EXPECT_EQ(mode_.resume({}), "");
  EXPECT_EQ(mode_.decide().cell, MoveMode::kRun);
  EXPECT_EQ(mode_.decide().stopped_arms, Names{"arm1"});
  EXPECT_TRUE(mode_.decide().held_arms.empty()) << "a hold is no latch";
  EXPECT_EQ(mode_.mode_of("arm1"), MoveMode::kStop);
  EXPECT_EQ(mode_.resume({"arm1"}), "");
  EXPECT_EQ(mode_.decide(), ModeDecision{});
}

TEST_F(CellModeStateTest, UnknownArmIsRefusedAndNothingChanges) {
  EXPECT_EQ(mode_.stop({"arm1", "arm9"}), "unknown arm arm9: this cell's arms are arm1, arm2, arm3");
  EXPECT_EQ(mode_.hold({"arm9"}), "unknown arm arm9: this cell's arms are arm1, arm2, arm3");
  EXPECT_EQ(mode_.resume({"arm9"}), "unknown arm arm9: this cell's arms are arm1, arm2, arm3");
  EXPECT_EQ(mode_.decide(), ModeDecision{});
}

TEST_F(CellModeStateTest, ResumeDoesNotReleaseWhatFaultsHold) {
  AutomaticHolds holds;
  holds.arms["arm2"] = "planner/arm2: dead";
  mode_.set_automatic(holds);
  EXPECT_EQ(mode_.resume({}), "");
  EXPECT_EQ(mode_.decide().held_arms, Names{"arm2"});
  EXPECT_EQ(mode_.decide().reason, "arm2: planner/arm2: dead");
  EXPECT_EQ(mode_.reason_of("arm2"), "held: planner/arm2: dead");
}

TEST_F(CellModeStateTest, EndOfAFaultDoesNotReleaseWhatPeopleHold) {
  EXPECT_EQ(mode_.hold({"arm2"}), "");
  AutomaticHolds holds;
  holds.arms["arm2"] = "planner/arm2: dead";
  mode_.set_automatic(holds);
  mode_.set_automatic({});
  EXPECT_EQ(mode_.decide().held_arms, Names{"arm2"});
  EXPECT_EQ(mode_.reason_of("arm2"), "on hold by operator: waits for resume");
}

TEST_F(CellModeStateTest, AutomaticHoldOfTheCellDoesNotWeakenStop) {
  EXPECT_EQ(mode_.stop({}), "");
  mode_.set_automatic({"world: silent", {}});
  EXPECT_EQ(mode_.decide().cell, MoveMode::kStop);
  EXPECT_EQ(mode_.resume({}), "");
  EXPECT_EQ(mode_.decide().cell, MoveMode::kHold);
  EXPECT_EQ(mode_.mode_of("arm1"), MoveMode::kHold);
}

TEST_F(CellModeStateTest, RestoresOrdersOfKnownArms) {
  Orders orders;
  orders.cell = MoveMode::kStop;
  orders.arms = {{"arm1", MoveMode::kHold}, {"gone", MoveMode::kStop}};
  mode_.restore(orders);
  EXPECT_EQ(mode_.orders().cell, MoveMode::kStop);
  EXPECT_EQ(mode_.orders().arms.size(), 1U);
}

}  // namespace
}  // namespace hecaton::services
