// Which arms a planner hears (docs/explanation/0023-neighbours.md).
#include <gtest/gtest.h>

#include "services/config/cell_file.hpp"
#include "services/messages/convert.hpp"
#include "services/planner/live_planner.hpp"

namespace hecaton::services {
namespace {

using Clock = LivePlanner::Clock;
using Names = std::vector<std::string>;

/// `near` is within reach of `own`, `far` is not.
planner::Cell row_of_arms() {
  const std::string text =
      "name: row\n"
      "defaults: {urdf: urdf/puma560.urdf, poses: {home: [0, -1.9, 2.6, 0, 0.6, 0]}}\n"
      "arms: [{name: own}, {name: near, base: {xyz: [0, 1.5, 0]}}, {name: far, base: {xyz: [0, -6, 0]}}]\n";
  return config::parse_cell_file(text, std::string(HECATON_SOURCE_DIR) + "/deploy/cells/test.yaml").cell;
}

class NoSearches : public planner::SearchExecutor {
 public:
  [[nodiscard]] planner::SearchAnswers answers() override { return {}; }
  void ask(planner::SearchQuestions /*questions*/, const planner::SharedObstacles& /*obstacles*/) override {}
};

class Neighbours : public testing::Test {
 protected:
  Neighbours() {
    msg::CellMode run;
    run.mode(msg::Mode::MODE_RUN);
    run.term(1);
    EXPECT_TRUE(mode_.apply(run, now_));
  }

  void hear(const std::string& arm) {
    msg::ArmState state;
    state.arm(arm);
    state.mode(msg::ArmMode::ARM_RUNNING);
    state.sequence_number(++number_);
    state.stamp_ns(now_.time_since_epoch().count());
    state.q(messages::to_message(cell_.arms[0].arm.home()));
    state.qd(std::vector<double>(6, 0.0));
    EXPECT_EQ(planner_.arms().apply(state, {}, now_), std::nullopt);
  }

  /// The world has one obstacle.
  void describe(const world::Obstacle& obstacle) {
    msg::ObstacleShapes shapes;
    shapes.name(obstacle.name);
    shapes.obstacle(messages::to_message(obstacle));
    EXPECT_EQ(planner_.obstacles().apply(shapes, {}), std::nullopt);
    world::ObstacleSnapshot snapshot;
    snapshot.sequence = ++number_;
    snapshot.states.resize(1);
    snapshot.states[0].X_WO = obstacle.X_WO;
    msg::ObstacleStates states = messages::to_message(snapshot, std::vector{obstacle});
    states.sequence_number(snapshot.sequence);
    states.stamp_ns(now_.time_since_epoch().count());
    EXPECT_EQ(planner_.obstacles().apply(states, {}, now_), std::nullopt);
    planner_.obstacles().join();
  }

  /// The next period, in which the own arm was heard.
  planner::TickResult step() {
    hear("own");
    const auto period =
        planner_.step({.now = now_, .mode = mode_, .term = 1, .commands = true, .continues = true}, searches_);
    EXPECT_TRUE(period);
    return period ? period->result : planner::TickResult{};
  }

  /// A pole of 10 m, held in the middle.
  static world::Obstacle pole() {
    world::Obstacle pole;
    pole.name = "pole";
    pole.shapes = {{.shape = world::Box{{0.02, 0.02, 5.0}}}};
    pole.X_WO.translation() = Eigen::Vector3d(20.0, 0.0, 0.0);
    return pole;
  }

  const planner::Cell cell_ = row_of_arms();
  LivePlanner planner_{cell_, 0, "planner/own", {}};
  CellModeView mode_;
  NoSearches searches_;
  Clock::time_point now_{std::chrono::hours(1)};
  std::uint64_t number_ = 0;
};

TEST_F(Neighbours, AreTheArmsThatCanMeet) {
  EXPECT_EQ(planner_.neighbour_names(), (Names{"own", "near"}));
  EXPECT_EQ(LivePlanner(cell_, 2, "planner/far", {}).neighbour_names(), Names{"far"});
}

TEST_F(Neighbours, HoldTheGoalUntilTheyAreHeardAndOthersDoNot) {
  describe(pole());
  EXPECT_EQ(step().stale_arm, 1) << "near is unknown";
  hear("near");
  EXPECT_EQ(step().stale_arm, -1);
  EXPECT_LT(planner_.oldest_input(now_, mode_).age, 1.0) << "far is no input";
}

TEST_F(Neighbours, FollowWhatAnArmCarries) {
  describe(pole());
  hear("near");
  EXPECT_EQ(step().stale_arm, -1);

  world::Obstacle held = pole();
  held.attachment = world::Attachment{"far", planner::Pose::Identity()};
  describe(held);
  EXPECT_EQ(step().stale_arm, 2) << "with the pole far reaches this arm, and was never heard";
  EXPECT_EQ(planner_.neighbour_names(), (Names{"own", "near", "far"}));
  hear("far");
  EXPECT_EQ(step().stale_arm, -1);

  describe(pole());
  EXPECT_EQ(step().stale_arm, -1);
  EXPECT_EQ(planner_.neighbour_names(), (Names{"own", "near"}));
  describe(held);
  EXPECT_EQ(step().stale_arm, 2) << "what was heard before it was no neighbour does not count";
}

}  // namespace
}  // namespace hecaton::services
