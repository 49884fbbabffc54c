// Selection of manoeuvres, independent of interruptions.
#include "planner/rollout/rollout_search.hpp"

#include <array>
#include <utility>

#include <gtest/gtest.h>

#include "planner/methods/registry.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::box_obstacle;
using test::joints;

LocalParameters without_following() {
  LocalParameters parameters;
  parameters.method = built_in_method("local");
  return parameters;
}

/// The point's goal is behind a wall. Constraints alone leave the point in front of it.
class Wall : public testing::Test {
 protected:
  Wall() : search_({test::planar_point()}, {without_following()}, 0) {
    boxes_ = {box_obstacle("wall", {0.4, 0.0, 0}, {0.05, 0.15, 0.1})};
    search_.set_obstacles(boxes_);
    for (const auto& box : boxes_) question_.obstacles.push_back({box.X_WO, {}, 0.0});
    RolloutArm arm;
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

TEST_F(Wall, ManoeuvreArrivesAtThePredictedTime) {
  const RolloutAnswer found = answer(1'000'000);
  EXPECT_TRUE(found.arrives);
  EXPECT_LT(found.cost, found.cost_of_continuing);
  EXPECT_NE(found.manoeuvre.kind, ManoeuvreKind::kContinue);
  EXPECT_FALSE(search_.busy());

  // The same manoeuvre on the same cell arrives at the predicted time.
  RolloutSimulation cell({test::planar_point()}, {without_following()}, 0.025);
  cell.set_obstacles(boxes_);
  auto arms = question_.arms;
  begin(found.manoeuvre, arms[0].memory);
  cell.begin(arms, question_.obstacles);
  while (cell.reached(0) < 0.0 && cell.time() < question_.horizon) cell.step();
  EXPECT_DOUBLE_EQ(cell.reached(0), found.cost);
}

TEST_F(Wall, AnswerHasThePathOfItsRollout) {
  const RolloutAnswer found = answer(7);
  RolloutSimulation cell({test::planar_point()}, {without_following()}, 0.025);
  cell.set_obstacles(boxes_);
  auto arms = question_.arms;
  begin(found.manoeuvre, arms[0].memory);
  cell.begin(arms, question_.obstacles);
  ASSERT_EQ(found.path.size(), static_cast<std::size_t>(found.cost / kRolloutPathStep + 1e-9) + 1);
  for (std::size_t i = 0; i < found.path.size(); ++i) {
    while (cell.time() < kRolloutPathStep * static_cast<double>(i) - 1e-9) cell.step();
    EXPECT_EQ(found.path[i], cell.arm(0).q) << "point " << i;
  }
}

TEST_F(Wall, AnswerIsIndependentOfInterruptions) {
  const RolloutAnswer whole = answer(1'000'000);
  const RolloutAnswer in_pieces = answer(1);
  EXPECT_EQ(whole.manoeuvre.kind, in_pieces.manoeuvre.kind);
  EXPECT_EQ(whole.manoeuvre.seed, in_pieces.manoeuvre.seed);
  EXPECT_EQ(whole.cost, in_pieces.cost);
}

TEST_F(Wall, ContinuesWhenTheGainIsSmall) {
  question_.arms[0].q_goal = joints({-0.8, 0});  // nothing is in the way
  const RolloutAnswer found = answer(1'000'000);
  EXPECT_EQ(found.manoeuvre.kind, ManoeuvreKind::kContinue);
  EXPECT_EQ(found.cost, found.cost_of_continuing);
}

TEST_F(Wall, IsIdleBeforeAQuestionAndAfterObstaclesChange) {
  EXPECT_FALSE(search_.busy());
  EXPECT_FALSE(search_.advance(1000).has_value());
  search_.begin(question_);
  EXPECT_TRUE(search_.busy());
  search_.set_obstacles(boxes_);
  EXPECT_FALSE(search_.busy());
}

// Two points block each other in the plane: the cost of a manoeuvre includes both arrival times.
TEST(RolloutSearch, CountsTheTimeOfAllArms) {
  RolloutSearch search({test::planar_point("a"), test::planar_point("b")}, {LocalParameters{}, LocalParameters{}}, 0);
  RolloutQuestion question;
  for (const double side : {-1.0, 1.0}) {
    RolloutArm arm;
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

/// A point whose joints reach 3 m from x = `x` [m] either way, on its way in a cell of such points.
Arm point_at(const std::string& name, double x) {
  Arm arm = test::planar_point(name);
  arm.X_WB.translation().x() = x;
  return arm;
}
RolloutArm crossing(double from, double to) {
  RolloutArm arm;
  arm.q = joints({from, 0});
  arm.qd = joints({0, 0});
  arm.q_goal = joints({to, 0});
  arm.has_goal = true;
  arm.plans = true;
  return arm;
}

/// The answer, and the number of advance() calls of one step each.
std::pair<RolloutAnswer, int> answer_in_steps(RolloutSearch& search, const RolloutQuestion& question) {
  search.begin(question);
  for (int calls = 1; calls < 1'000'000; ++calls) {
    if (const auto found = search.advance(1)) return {*found, calls};
  }
  ADD_FAILURE() << "no answer";
  return {};
}

// The own arm is the second of the cell; one neighbour is near, the other never comes near.
class Neighbours : public testing::Test {
 protected:
  Neighbours()
      : search_({point_at("far", 30.0), point_at("own", 0.0), point_at("near", 4.0)}, std::vector<LocalParameters>(3),
                1) {
    question_.arms = {crossing(-1, 1), crossing(0, 2), crossing(0, -2)};  // own and near want to pass each other
    question_.horizon = 6.0;
    question_.candidates = 4;
    question_.seed = 7;
  }

  RolloutSearch search_;
  RolloutQuestion question_;
};

TEST_F(Neighbours, OnlyNeighboursAreSimulated) {
  EXPECT_EQ(search_.simulated_arms(), (std::vector<int>{1, 2}));
  RolloutSearch alone({point_at("own", 0.0), point_at("near", 4.0)}, std::vector<LocalParameters>(2), 0);
  RolloutQuestion without_far = question_;
  without_far.arms.erase(without_far.arms.begin());
  const auto [expected, calls] = answer_in_steps(alone, without_far);
  const auto [found, calls_in_the_cell] = answer_in_steps(search_, question_);
  EXPECT_EQ(found.cost, expected.cost);
  EXPECT_EQ(found.cost_of_continuing, expected.cost_of_continuing);
  EXPECT_EQ(found.manoeuvre.seed, expected.manoeuvre.seed);
  EXPECT_EQ(calls_in_the_cell, calls) << "a far arm costs no tick";
}

TEST_F(Neighbours, LoadOfADistantArmIsNotSimulated) {
  world::Obstacle bar = box_obstacle("bar", {0, 0, 0}, {0.2, 0.05, 0.05});
  bar.attachment = world::Attachment{"far", Pose::Identity()};
  question_.obstacles = {world::ObstacleState{}};
  search_.set_obstacles(std::array{bar});
  EXPECT_EQ(search_.simulated_arms(), (std::vector<int>{1, 2}));
  const RolloutAnswer with_bar = answer_in_steps(search_, question_).first;
  bar.attachment.reset();
  bar.X_WO.translation().x() = 50.0;
  question_.obstacles[0].X_WO = bar.X_WO;
  search_.set_obstacles(std::array{bar});
  EXPECT_EQ(with_bar.cost, answer_in_steps(search_, question_).first.cost);
}

TEST_F(Neighbours, ArmWithALongLoadBecomesANeighbour) {
  world::Obstacle pole = box_obstacle("pole", {0, 0, 0}, {25.0, 0.05, 0.05});
  pole.attachment = world::Attachment{"far", Pose::Identity()};
  search_.set_obstacles(std::array{pole});
  EXPECT_EQ(search_.simulated_arms(), (std::vector<int>{0, 1, 2}));
}

}  // namespace
}  // namespace hecaton::planner
