#include "planner/route/route_search.hpp"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "tests/unit/planner/route/walls.hpp"

namespace hecaton::planner {
namespace {

using Kind = RouteAnswer::Kind;
using test::joints;

class RouteSearchTest : public testing::Test {
 protected:
  RouteAnswer ask(const std::vector<world::Obstacle>& boxes, const JointVector& from, const JointVector& to,
                  const std::vector<JointVector>& left = {}) {
    boxes_ = boxes;
    search_.set_obstacles(boxes);
    RouteQuestion question;
    question.planned = {0};
    question.q = {from};
    question.q_goal = {to};
    for (const JointVector& point : left) question.remaining.push_back({point});
    question.arms.resize(1);
    question.obstacles = test::states_of(boxes);
    return search_.answer(question);
  }
  /// Smallest clearance of the ball from `from` along the answer's points [m].
  double least_room(const JointVector& from, const RouteAnswer& answer) const {
    double least = std::numeric_limits<double>::infinity();
    JointVector a = from;
    for (const JointPoint& point : answer.points) {
      const JointVector& b = point.front();
      for (int k = 0; k <= 100; ++k) {
        least = std::min(least, test::clearance_at(a + 0.01 * k * (b - a), boxes_, test::states_of(boxes_)));
      }
      a = b;
    }
    return least;
  }

  LocalParameters parameters_;
  RouteSearch search_{{test::planar_point()}, {parameters_}, 0};
  std::vector<world::Obstacle> boxes_;
};

TEST_F(RouteSearchTest, FindsARouteThroughAGapWithClearance) {
  const auto answer = ask(test::wall_with_gap(1.5, 0.4), joints({-1, 0}), joints({1, 0}));
  ASSERT_EQ(answer.kind, Kind::kFound);
  EXPECT_EQ(answer.points.back().front(), joints({1, 0}));
  EXPECT_GT(answer.checks, 0U);
  EXPECT_GT(least_room(joints({-1, 0}), answer), parameters_.damper.security_distance + 0.02);
}

TEST_F(RouteSearchTest, KeepsLessClearanceInANarrowGap) {
  // A gap of 180 mm for a ball of 100 mm: 40 mm on either side; the dampers keep 20 mm.
  const auto answer = ask(test::wall_with_gap(1.5, 0.18), joints({-1, 1.5}), joints({1, 0}));
  ASSERT_EQ(answer.kind, Kind::kFound);
  EXPECT_GT(least_room(joints({-1, 1.5}), answer), parameters_.damper.security_distance);
}

TEST_F(RouteSearchTest, IsStraightWithoutObstacles) {
  const auto answer = ask(test::wall_with_gap(0.0, 0.4), joints({-1, 0}), joints({1, 0}));
  EXPECT_EQ(answer.kind, Kind::kStraight);
  EXPECT_TRUE(answer.points.empty());
}

TEST_F(RouteSearchTest, FindsNoRouteThroughAWall) {
  EXPECT_EQ(ask({test::box_obstacle("wall", {0, 0, 0}, {0.1, 4, 0.5})}, joints({-1, 0}), joints({1, 0})).kind,
            Kind::kNone);
}

TEST_F(RouteSearchTest, KeepsAndShortensAFreeRoute) {
  const auto boxes = test::wall_with_gap(1.5, 0.6);
  const std::vector<JointVector> left{joints({-1, 0.5}), joints({-0.5, 1.5}), joints({0.5, 1.5}), joints({1, 0})};
  const auto answer = ask(boxes, joints({-1, 0}), joints({1, 0}), left);
  ASSERT_EQ(answer.kind, Kind::kKept);
  ASSERT_EQ(answer.points.size(), 3U) << "the edge to the second point is free";
  EXPECT_EQ(answer.points.front().front(), joints({-0.5, 1.5}));
}

TEST_F(RouteSearchTest, ReplacesABlockedRoute) {
  const std::vector<JointVector> left{joints({-0.5, 1.5}), joints({0.5, 1.5}), joints({1, 0})};
  const auto answer = ask(test::wall_with_gap(-1.5, 0.6), joints({-1, 0}), joints({1, 0}), left);
  ASSERT_EQ(answer.kind, Kind::kFound);
  EXPECT_GT(least_room(joints({-1, 0}), answer), parameters_.damper.security_distance);
}

TEST_F(RouteSearchTest, StartsWhereTheDampersHoldTheArm) {
  // 21 mm before the wall, the closest that an arm gets.
  const JointVector stuck = joints({-0.171, 0});
  const auto answer = ask(test::wall_with_gap(1.5, 0.4), stuck, joints({1, 0}));
  ASSERT_EQ(answer.kind, Kind::kFound);
  EXPECT_GT(least_room(stuck, answer), 0.0);
}

// Two balls exchange places; one of them must move aside into the gap between two walls.
TEST_F(RouteSearchTest, ArmsPlannedTogetherKeepTheirDistance) {
  std::vector<Arm> arms{test::planar_point("left"), test::planar_point("right")};
  for (Arm& arm : arms) {
    arm.limits.lower = joints({-1.2, -0.12});
    arm.limits.upper = joints({1.2, 0.5});
  }
  const std::vector<world::Obstacle> boxes{test::box_obstacle("south", {0, -0.2, 0}, {2, 0.05, 0.5}),
                                           test::box_obstacle("west", {-1.2, 0.4, 0}, {1, 0.25, 0.5}),
                                           test::box_obstacle("east", {1.2, 0.4, 0}, {1, 0.25, 0.5})};
  RouteSearch search(arms, {parameters_, parameters_}, 0);
  search.set_obstacles(boxes);
  RouteQuestion question;
  question.planned = {0, 1};
  question.q = {joints({-1, 0}), joints({1, 0})};
  question.q_goal = {joints({1, 0}), joints({-1, 0})};
  question.arms = question.q;
  question.obstacles = test::states_of(boxes);
  const RouteAnswer answer = search.answer(question);
  ASSERT_EQ(answer.kind, Kind::kFound);
  EXPECT_EQ(answer.points.back(), question.q_goal);
  JointPoint from = question.q;
  double nearest = std::numeric_limits<double>::infinity();
  for (const JointPoint& to : answer.points) {
    for (int k = 0; k <= 20; ++k) {
      const JointVector a = from[0] + 0.05 * k * (to[0] - from[0]);
      const JointVector b = from[1] + 0.05 * k * (to[1] - from[1]);
      nearest = std::min({nearest, (a - b).norm() - 0.1, test::clearance_at(a, boxes, question.obstacles),
                          test::clearance_at(b, boxes, question.obstacles)});
    }
    from = to;
  }
  EXPECT_GT(nearest, parameters_.damper.security_distance);
}

// Arms of a coupled plan wait at each point, also without obstacles.
TEST_F(RouteSearchTest, StraightPathOfSeveralArmsIsDivided) {
  RouteSearch search({test::planar_point("one"), test::planar_point("other")}, {parameters_, parameters_}, 0);
  search.set_obstacles({});
  RouteQuestion question;
  question.planned = {0, 1};
  question.q = {joints({-1, 0}), joints({-1, 1})};
  question.q_goal = {joints({1, 0}), joints({-0.5, 1})};
  question.arms = question.q;
  const RouteAnswer answer = search.answer(question);
  ASSERT_EQ(answer.kind, Kind::kStraight);
  ASSERT_GE(answer.points.size(), 7U);
  EXPECT_EQ(answer.points.back(), question.q_goal);
  JointPoint last = question.q;
  for (const JointPoint& point : answer.points) {
    for (int arm = 0; arm < 2; ++arm) EXPECT_LE((point[arm] - last[arm]).cwiseAbs().maxCoeff(), 0.3 + 1e-9);
    last = point;
  }
}

TEST_F(RouteSearchTest, SameQuestionGivesSameAnswer) {
  const auto boxes = test::wall_with_gap(1.5, 0.4);
  const auto one = ask(boxes, joints({-1, 0}), joints({1, 0}));
  const auto two = ask(boxes, joints({-1, 0}), joints({1, 0}));
  EXPECT_EQ(one.points, two.points);
  EXPECT_EQ(one.checks, two.checks);
}

}  // namespace
}  // namespace hecaton::planner
