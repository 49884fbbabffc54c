// Which manoeuvre wins, and that interruptions do not change it.
#include "planner/rollout/rollout_search.hpp"

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::box_obstacle;
using test::joints;

LocalParameters without_following() {
  LocalParameters parameters;
  parameters.method = Method::kLocal;
  return parameters;
}

/// The point's goal is behind a wall, and constraints alone leave it standing in front.
class Wall : public testing::Test {
 protected:
  Wall() : search_({test::planar_point()}, {without_following()}, 0) {
    boxes_ = {box_obstacle("wall", {0.4, 0.0, 0}, {0.05, 0.15, 0.1})};
    search_.set_obstacles(boxes_);
    for (const auto& box : boxes_) question_.obstacles.push_back({box.X_WO, {}, 0.0});
    PlayedArm arm;
    arm.q = joints({0, 0});
    arm.qd = joints({0, 0});
    arm.q_goal = joints({0.9, 0});
    arm.memory.q_goal = arm.q_goal;  // it has pursued this goal before
    arm.has_goal = true;
    arm.plans = true;
    question_.arms = {arm};
    question_.horizon = 8.0;
    question_.candidates = 40;
    question_.seed = 3;
  }

  RolloutAnswer answer(int ticks_at_a_time) {
    search_.begin(question_);
    for (int calls = 0; calls < 1'000'000; ++calls) {
      if (const auto found = search_.advance(ticks_at_a_time)) return *found;
      EXPECT_TRUE(search_.busy());
    }
    ADD_FAILURE() << "no answer";
    return {};
  }

  std::vector<world::Obstacle> boxes_;
  RolloutSearch search_;
  RolloutQuestion question_;
};

TEST_F(Wall, AManoeuvreThatLeadsRoundIsFoundAndKeepsItsPromise) {
  const RolloutAnswer found = answer(1'000'000);
  EXPECT_TRUE(found.arrives);
  EXPECT_LT(found.cost, found.cost_of_going_on);
  EXPECT_NE(found.manoeuvre.kind, ManoeuvreKind::kGoOn);
  EXPECT_FALSE(search_.busy());

  // What was played happens: the same manoeuvre on the same cell arrives at the promised time.
  PlayedCell cell({test::planar_point()}, {without_following()}, 0.025);
  cell.set_obstacles(boxes_);
  auto arms = question_.arms;
  begin(found.manoeuvre, arms[0].memory);
  cell.begin(arms, question_.obstacles);
  while (cell.reached(0) < 0.0 && cell.time() < question_.horizon) cell.step();
  EXPECT_DOUBLE_EQ(cell.reached(0), found.cost);
}

TEST_F(Wall, InterruptionsDoNotChangeTheAnswer) {
  const RolloutAnswer whole = answer(1'000'000);
  const RolloutAnswer in_pieces = answer(1);
  EXPECT_EQ(whole.manoeuvre.kind, in_pieces.manoeuvre.kind);
  EXPECT_EQ(whole.manoeuvre.seed, in_pieces.manoeuvre.seed);
  EXPECT_EQ(whole.cost, in_pieces.cost);
}

TEST_F(Wall, NothingIsChangedForLittle) {
  question_.arms[0].q_goal = joints({-0.8, 0});  // nothing is in the way
  const RolloutAnswer found = answer(1'000'000);
  EXPECT_EQ(found.manoeuvre.kind, ManoeuvreKind::kGoOn);
  EXPECT_EQ(found.cost, found.cost_of_going_on);
}

TEST_F(Wall, IsIdleUntilAskedAndAfterItsObstaclesChanged) {
  EXPECT_FALSE(search_.busy());
  EXPECT_FALSE(search_.advance(1000).has_value());
  search_.begin(question_);
  EXPECT_TRUE(search_.busy());
  search_.set_obstacles(boxes_);
  EXPECT_FALSE(search_.busy());
}

// Two points face each other in the plane, each in the other's way; the manoeuvre must count the other's way, too.
TEST(RolloutSearch, CountsTheTimeOfAllArms) {
  RolloutSearch search({test::planar_point("a"), test::planar_point("b")}, {LocalParameters{}, LocalParameters{}}, 0);
  RolloutQuestion question;
  for (const double side : {-1.0, 1.0}) {
    PlayedArm arm;
    arm.q = joints({side, 0});
    arm.qd = joints({0, 0});
    arm.q_goal = joints({side * 0.5, 0});  // they stay apart
    arm.has_goal = true;
    arm.plans = true;
    question.arms.push_back(arm);
  }
  question.candidates = 0;
  question.horizon = 10.0;
  search.begin(question);
  const auto both = search.advance(1'000'000);
  ASSERT_TRUE(both.has_value());
  question.arms[1].has_goal = false;
  search.begin(question);
  const auto one = search.advance(1'000'000);
  ASSERT_TRUE(one.has_value());
  EXPECT_NEAR(both->cost, 2.0 * one->cost, 1e-9);  // by symmetry
}

}  // namespace
}  // namespace hecaton::planner
