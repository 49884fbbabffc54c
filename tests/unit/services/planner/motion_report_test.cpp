#include "services/planner/motion_report.hpp"

#include <gtest/gtest.h>

#include "services/planner/motion_publisher.hpp"
#include "tests/support/free_domain.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using planner::JointVector;
using test::joints;
using Values = std::vector<double>;

/// An arm that is at (0, 0).
class MotionReportTest : public testing::Test {
 protected:
  MotionReportTest() { give({.q_goal = joints({0.5, 0.25})}); }
  void give(const planner::GoalChange& goal) {
    planner::PeriodEvents events;
    events.obstacles = std::make_shared<const std::vector<world::Obstacle>>();
    events.goal = goal;
    planner_.receive(events);
  }
  /// A control period of the planner.
  void step() {
    const std::vector<planner::ArmObservation> arms(1);
    planner::PeriodInputs inputs;
    inputs.own.state = {joints({0, 0}), joints({0, 0})};
    inputs.arms = arms;
    const planner::TickResult result = planner_.step(inputs);
    static_cast<void>(planner_.plan_ahead(inputs, result));
  }

  planner::LocalParameters parameters_;
  planner::ArmPlanner planner_{planner::CellGeometry({test::planar_point()}, 0), parameters_, {}};
  MotionReport report_{"point", "planner/point"};
};

TEST_F(MotionReportTest, HasTheGoalOnceAndEachChangeOfIt) {
  ASSERT_TRUE(report_.update(10.0, planner_, nullptr));
  EXPECT_EQ(report_.message().arm(), "point");
  EXPECT_EQ(report_.message().node(), "planner/point");
  EXPECT_EQ(report_.message().way(), (Values{0.5, 0.25}));
  EXPECT_FALSE(report_.update(11.0, planner_, nullptr)) << "nothing has changed";
  give({.q_goal = joints({0, -0.5})});
  EXPECT_TRUE(report_.update(12.0, planner_, nullptr));
  EXPECT_EQ(report_.message().way(), (Values{0, -0.5}));
  give({.q_goal = joints({0.1, 0})});
  EXPECT_FALSE(report_.update(12.05, planner_, nullptr)) << "ten times a second at most";
  EXPECT_TRUE(report_.update(12.11, planner_, nullptr));
  give({});
  EXPECT_TRUE(report_.update(13.0, planner_, nullptr));
  EXPECT_EQ(report_.message().way(), Values());
  report_.restart();
  EXPECT_TRUE(report_.update(13.01, planner_, nullptr)) << "for a new reader";
}

TEST_F(MotionReportTest, HasARolloutUntilItIsOver) {
  ASSERT_TRUE(report_.update(10.0, planner_, nullptr));
  planner::RolloutAnswer answer;
  answer.path = {joints({0, 0}), joints({0.1, 0}), joints({0.2, 0.1})};
  ASSERT_TRUE(report_.update(11.0, planner_, &answer));
  EXPECT_EQ(report_.message().foreseen(), (Values{0, 0, 0.1, 0, 0.2, 0.1}));
  EXPECT_DOUBLE_EQ(report_.message().foreseen_period(), 0.1);
  EXPECT_FALSE(report_.update(11.2, planner_, nullptr));
  ASSERT_TRUE(report_.update(11.31, planner_, nullptr));
  EXPECT_EQ(report_.message().foreseen(), Values());
}

TEST_F(MotionReportTest, HasTheRestOfATrajectory) {
  auto trajectory = std::make_shared<planner::TimedTrajectory>();
  trajectory->points = {{0.0, joints({0, 0}), {}, {}}, {1.0, joints({0.2, 0.1}), {}, {}}};
  give({.q_goal = joints({0.2, 0.1}), .trajectory = trajectory});
  step();
  ASSERT_TRUE(report_.update(10.0, planner_, nullptr));
  const Values& way = report_.message().way();
  ASSERT_GT(way.size(), 12U) << "more points than the end";
  ASSERT_LE(way.size(), 2 * MotionReport::kMostPoints);
  for (std::size_t i = 0; i < way.size(); i += 2) {
    EXPECT_NEAR(way[i], 2.0 * way[i + 1], 1e-9) << "on the trajectory";
    if (i == 0) continue;
    EXPECT_GT(way[i], way[i - 2]);
  }
  EXPECT_EQ(way[way.size() - 2], 0.2);
}

TEST_F(MotionReportTest, LeavesOutPointsOfALongRouteButNotItsEnd) {
  planner::RolloutAnswer answer;
  for (int i = 0; i < 150; ++i) answer.path.push_back(joints({0.01 * i, 0}));
  ASSERT_TRUE(report_.update(10.0, planner_, &answer));
  const Values& foreseen = report_.message().foreseen();
  EXPECT_EQ(foreseen.size(), 100U);
  EXPECT_DOUBLE_EQ(foreseen[foreseen.size() - 2], 1.49);
}

TEST_F(MotionReportTest, IsPublishedForEachReaderThatComes) {
  const test::FreeDomain domain;
  bus::ParticipantOptions one_host;
  one_host.interfaces = {"127.0.0.1"};
  bus::Participant here(domain.number(), "here", one_host);
  bus::Participant there(domain.number(), "there", one_host);
  MotionPublisher publisher(here, "point", "planner/point");
  bus::Mailbox received;
  const auto arrives = [&](bus::Reader<msg::PlannedMotion>& reader) -> std::optional<msg::PlannedMotion> {
    const auto until = bus::Clock::now() + 60s;
    while (bus::Clock::now() < until) {
      publisher.publish(bus::Clock::now(), planner_, {});
      (void)reader.wait_for_data(20ms);
      const auto samples = reader.take();
      if (!samples.empty()) return samples.back().value;
    }
    return std::nullopt;
  };
  bus::Reader<msg::PlannedMotion> first(there, &received);
  const auto motion = arrives(first);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->way(), (Values{0.5, 0.25}));
  EXPECT_GT(motion->stamp_ns(), 0);
  // The way is the same as before, and the second reader has not seen it.
  bus::Participant later(domain.number(), "later", one_host);
  bus::Reader<msg::PlannedMotion> second(later, &received);
  EXPECT_TRUE(arrives(second));
}

}  // namespace
}  // namespace hecaton::services
