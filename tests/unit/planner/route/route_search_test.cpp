#include "planner/route/route_search.hpp"

#include <gtest/gtest.h>

#include "tests/unit/planner/route/room.hpp"

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
    for (const JointVector& point : left) question.left.push_back({point});
    question.arms.resize(1);
    question.obstacles = test::states_of(boxes);
    return search_.answer(question);
  }
  /// Of the ball on the whole way from `from` by the answer's points [m].
  double least_room(const JointVector& from, const RouteAnswer& answer) const {
    double least = std::numeric_limits<double>::infinity();
    JointVector a = from;
    for (const JointPoint& point : answer.points) {
      const JointVector& b = point.front();
      for (int k = 0; k <= 100; ++k) {
        least = std::min(least, test::room_at(a + 0.01 * k * (b - a), boxes_, test::states_of(boxes_)));
      }
      a = b;
    }
    return least;
  }

  LocalParameters parameters_;
  RouteSearch search_{{test::planar_point()}, {parameters_}, 0};
  std::vector<world::Obstacle> boxes_;
};

TEST_F(RouteSearchTest, ThroughAGapAndWithRoom) {
  const auto answer = ask(test::wall_with_gap(1.5, 0.4), joints({-1, 0}), joints({1, 0}));
  ASSERT_EQ(answer.kind, Kind::kFound);
  EXPECT_EQ(answer.points.back().front(), joints({1, 0}));
  EXPECT_GT(answer.checks, 0U);
  EXPECT_GT(least_room(joints({-1, 0}), answer), parameters_.damper.security_distance + 0.02);
}

TEST_F(RouteSearchTest, WhereThereIsLittleRoomItKeepsLess) {
  // 180 mm for a ball of 100: 40 mm to either side, and 20 mm are what the dampers let it come near.
  const auto answer = ask(test::wall_with_gap(1.5, 0.18), joints({-1, 1.5}), joints({1, 0}));
  ASSERT_EQ(answer.kind, Kind::kFound);
  EXPECT_GT(least_room(joints({-1, 1.5}), answer), parameters_.damper.security_distance);
}

TEST_F(RouteSearchTest, StraightWhereNothingStandsInTheWay) {
  const auto answer = ask(test::wall_with_gap(0.0, 0.4), joints({-1, 0}), joints({1, 0}));
  EXPECT_EQ(answer.kind, Kind::kStraight);
  EXPECT_TRUE(answer.points.empty());
}

TEST_F(RouteSearchTest, NoneThroughAWall) {
  EXPECT_EQ(ask({test::box_obstacle("wall", {0, 0, 0}, {0.1, 4, 0.5})}, joints({-1, 0}), joints({1, 0})).kind,
            Kind::kNone);
}

TEST_F(RouteSearchTest, ARouteThatIsFreeIsKeptAndShortened) {
  const auto boxes = test::wall_with_gap(1.5, 0.6);
  const std::vector<JointVector> left{joints({-1, 0.5}), joints({-0.5, 1.5}), joints({0.5, 1.5}), joints({1, 0})};
  const auto answer = ask(boxes, joints({-1, 0}), joints({1, 0}), left);
  ASSERT_EQ(answer.kind, Kind::kKept);
  ASSERT_EQ(answer.points.size(), 3U) << "the second point is in sight";
  EXPECT_EQ(answer.points.front().front(), joints({-0.5, 1.5}));
}

TEST_F(RouteSearchTest, ARouteThatIsCutIsReplaced) {
  const std::vector<JointVector> left{joints({-0.5, 1.5}), joints({0.5, 1.5}), joints({1, 0})};
  const auto answer = ask(test::wall_with_gap(-1.5, 0.6), joints({-1, 0}), joints({1, 0}), left);
  ASSERT_EQ(answer.kind, Kind::kFound);
  EXPECT_GT(least_room(joints({-1, 0}), answer), parameters_.damper.security_distance);
}

TEST_F(RouteSearchTest, FromWhereTheDampersHoldTheArm) {
  // 21 mm before the wall, as near as an arm gets.
  const JointVector stuck = joints({-0.171, 0});
  const auto answer = ask(test::wall_with_gap(1.5, 0.4), stuck, joints({1, 0}));
  ASSERT_EQ(answer.kind, Kind::kFound);
  EXPECT_GT(least_room(stuck, answer), 0.0);
}

TEST_F(RouteSearchTest, TheSameQuestionHasTheSameAnswer) {
  const auto boxes = test::wall_with_gap(1.5, 0.4);
  const auto one = ask(boxes, joints({-1, 0}), joints({1, 0}));
  const auto two = ask(boxes, joints({-1, 0}), joints({1, 0}));
  EXPECT_EQ(one.points, two.points);
  EXPECT_EQ(one.checks, two.checks);
}

}  // namespace
}  // namespace hecaton::planner
