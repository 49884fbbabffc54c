// Rollouts on their own thread: the answer is the search's own, and comes only as fast as it is granted.
#include "services/planner/rollout_worker.hpp"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::services {
namespace {

using test::joints;

planner::RolloutQuestion question() {
  planner::RolloutQuestion question;
  planner::PlayedArm arm;
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

RolloutWorker::Obstacles no_obstacles() {
  return std::make_shared<const std::vector<world::Obstacle>>();
}

TEST(RolloutWorker, AnswersWhatTheSearchAnswers) {
  planner::RolloutSearch search({test::planar_point()}, {planner::LocalParameters{}}, 0);
  search.begin(question());
  const auto expected = search.advance(1'000'000);
  ASSERT_TRUE(expected.has_value());

  RolloutWorker worker({test::planar_point()}, {planner::LocalParameters{}}, 0, 10);
  EXPECT_FALSE(worker.answer().has_value());
  worker.ask(question(), no_obstacles());
  std::optional<planner::RolloutAnswer> found;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!found && std::chrono::steady_clock::now() < until) {
    worker.grant();
    std::this_thread::yield();
    found = worker.answer();
  }
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->cost, expected->cost);
  EXPECT_EQ(found->manoeuvre.kind, expected->manoeuvre.kind);
  EXPECT_FALSE(worker.answer().has_value()) << "an answer is given once";
}

TEST(RolloutWorker, EndsWithAQuestionUnderWay) {
  RolloutWorker worker({test::planar_point()}, {planner::LocalParameters{}}, 0, 1);
  auto long_one = question();
  long_one.horizon = 50.0;
  long_one.candidates = 1000;
  worker.ask(std::move(long_one), no_obstacles());
  worker.grant();
}

}  // namespace
}  // namespace hecaton::services
