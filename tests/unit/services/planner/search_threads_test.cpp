// Searches in threads give the answers of the searches; rollouts advance with the control periods.
#include "services/planner/search_threads.hpp"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::services {
namespace {

using test::joints;

planner::Cell cell(int ticks_per_period) {
  planner::Cell cell;
  cell.arms.push_back({test::planar_point(), {}});
  cell.arms[0].parameters.rollout.ticks_per_period = ticks_per_period;
  return cell;
}

planner::RolloutQuestion question() {
  planner::RolloutQuestion question;
  planner::RolloutArm arm;
  arm.q = joints({0, 0});
  arm.qd = joints({0, 0});
  arm.q_goal = joints({1, 0});
  arm.has_goal = true;
  arm.plans = true;
  question.arms = {arm};
  question.horizon = 1.0;
  question.candidates = 6;
  return question;
}

planner::SharedObstacles no_obstacles() {
  return std::make_shared<const std::vector<world::Obstacle>>();
}

/// Runs periods until `found` is true.
template <class Found>
void pass_periods(SearchThreads& threads, const Found& found) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (std::chrono::steady_clock::now() < until) {
    if (found(threads.answers())) return;
    threads.ask({}, no_obstacles());
    std::this_thread::yield();
  }
  FAIL() << "no answer";
}

TEST(SearchThreads, GiveTheAnswersOfTheRolloutSearch) {
  planner::RolloutSearch search({test::planar_point()}, {planner::LocalParameters{}}, 0);
  search.begin(question());
  const auto expected = search.advance(1'000'000);
  ASSERT_TRUE(expected.has_value());

  SearchThreads threads(cell(10), 0);
  EXPECT_FALSE(threads.answers().rollout.has_value());
  threads.ask({.rollout = question()}, no_obstacles());
  pass_periods(threads, [&](const planner::SearchAnswers& answers) {
    if (!answers.rollout) return false;
    EXPECT_EQ(answers.rollout->cost, expected->cost);
    EXPECT_EQ(answers.rollout->manoeuvre.kind, expected->manoeuvre.kind);
    return true;
  });
  EXPECT_FALSE(threads.answers().rollout.has_value()) << "one answer per question";
}

TEST(SearchThreads, AnswerRoutesAndCoupledPlansSeparately) {
  planner::RouteQuestion straight;
  straight.planned = {0};
  straight.q = {joints({0, 0})};
  straight.q_goal = {joints({1, 0})};
  straight.arms = {planner::JointVector()};
  SearchThreads threads(cell(10), 0);
  threads.ask({.route = straight}, no_obstacles());
  pass_periods(threads, [](const planner::SearchAnswers& answers) {
    EXPECT_FALSE(answers.coupled_plan.has_value());
    return answers.route && answers.route->kind == planner::RouteAnswer::Kind::kStraight;
  });
  threads.ask({.coupled_plan = straight}, no_obstacles());
  pass_periods(threads, [](const planner::SearchAnswers& answers) {
    EXPECT_FALSE(answers.route.has_value());
    return answers.coupled_plan && answers.coupled_plan->kind == planner::RouteAnswer::Kind::kStraight;
  });
  EXPECT_FALSE(threads.stalled(std::chrono::steady_clock::now()).has_value());
}

TEST(SearchThreads, EndDuringASearch) {
  SearchThreads threads(cell(1), 0);
  auto long_one = question();
  long_one.horizon = 50.0;
  long_one.candidates = 1000;
  threads.ask({.rollout = std::move(long_one)}, no_obstacles());
  threads.ask({}, no_obstacles());
}

}  // namespace
}  // namespace hecaton::services
