// The planner runs in the planner service, by messages, and in the simulation. The same episode gives the same
// set-points in both, bit by bit.
#include "services/planner/live_planner.hpp"

#include <bit>
#include <cmath>

#include <gtest/gtest.h>

#include "planner/simulation/cell_simulation.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"
#include "tests/support/corridor.hpp"

namespace hecaton::services {
namespace {

using planner::JointVector;

constexpr int kArms = 3;
/// Multiples of this period, and all ages, are exact as doubles and as whole nanoseconds.
constexpr double kPeriod = 1.0 / 64.0;  // [s]
constexpr std::chrono::nanoseconds kPeriodNs{15'625'000};
const std::string kGoal = "goal";

/// Inputs and results of one planner in a period.
struct Period {
  std::optional<planner::GoalChange> goal;
  planner::PeriodInputs inputs;  ///< but for the spans
  std::vector<planner::ArmObservation> arms;
  std::vector<world::ObstacleState> obstacles;
  planner::TickResult result;
};

struct Recording {
  planner::ArmPlannerOptions options;
  std::vector<Period> periods;
};

/// Keeps the periods of all planners.
class PeriodLog : public planner::EpisodeLog {
 public:
  explicit PeriodLog(std::array<Recording, kArms>& recordings) : recordings_(recordings) {}

  void begin(const planner::CellConfiguration& /*goals*/) override {}
  void publish(const planner::CellMoment& /*moment*/) override {}
  void plan(const planner::PlannerPeriod& period) override {
    Recording& recording = recordings_[period.arm];
    recording.options = period.options;
    Period& now =
        recording.periods.emplace_back(Period{period.events.goal,
                                              period.inputs,
                                              {period.inputs.arms.begin(), period.inputs.arms.end()},
                                              {period.inputs.obstacles.begin(), period.inputs.obstacles.end()},
                                              period.result});
    now.inputs.arms = {};
    now.inputs.obstacles = {};
  }
  void end(const planner::EpisodeOutcome& /*outcome*/) override {}

 private:
  std::array<Recording, kArms>& recordings_;
};

/// Three balls reverse their order in a corridor, on states that are delayed and lost.
struct Episode {
  planner::Cell cell = test::corridor(kArms, -1.2, 2.0);
  std::array<Recording, kArms> recordings;
  planner::EpisodeOutcome outcome;

  Episode() {
    cell.timing.control_period = kPeriod;
    planner::CellConfiguration starts;
    planner::CellConfiguration goals;
    for (int i = 0; i < kArms; ++i) {
      starts.push_back(test::corridor_start(i, kArms));
      goals.push_back(test::corridor_goal(i, kArms));
    }
    planner::EpisodeOptions options;
    options.network = {.age = 2.0 * kPeriod, .jitter = kPeriod, .loss = 0.1};
    PeriodLog log(recordings);
    options.log = &log;
    outcome = simulate_episode(cell, starts, goals, options);
  }
};

const Episode& episode() {
  static const Episode once;
  return once;
}

/// Gives recorded answers and counts questions.
class RecordedSearches : public planner::SearchExecutor {
 public:
  explicit RecordedSearches(const Recording& recording) : recording_(recording) {}
  [[nodiscard]] planner::SearchAnswers answers() override { return recording_.periods[period_++].inputs.answers; }
  void ask(planner::SearchQuestions questions, const planner::SharedObstacles& /*obstacles*/) override {
    questions_ += questions.rollout.has_value() + questions.route.has_value() + questions.coupled_plan.has_value();
  }
  [[nodiscard]] int questions() const { return questions_; }

 private:
  const Recording& recording_;
  std::size_t period_ = 0;
  int questions_ = 0;
};

void expect_same_bits(const JointVector& a, const JointVector& b, std::size_t period, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what << " in period " << period;
  for (Eigen::Index j = 0; j < a.size(); ++j) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(a[j]), std::bit_cast<std::uint64_t>(b[j]))
        << what << "[" << j << "] in period " << period << ": " << a[j] << ", recorded: " << b[j];
  }
}

TEST(ServiceAndSimulation, UsesAllPartsOfThePlanner) {
  const planner::EpisodeOutcome& outcome = episode().outcome;
  int rollouts = 0;
  int routes = 0;
  int coupled_plans = 0;
  for (const planner::ArmOutcome& arm : outcome.arms) {
    EXPECT_EQ(arm.outcome, planner::TaskOutcome::kReached);
    rollouts += arm.rollouts;
    routes += arm.routes;
    coupled_plans += arm.coupled_plans;
  }
  EXPECT_GE(rollouts, 1);
  EXPECT_GE(coupled_plans, 1);
  (void)routes;
}

// A period is a function of the planner's memory and its inputs.
TEST(ServiceAndSimulation, RepeatsTheSetPointsFromRecordedInputs) {
  for (int self = 0; self < kArms; ++self) {
    const Recording& recording = episode().recordings[self];
    const planner::Cell& cell = episode().cell;
    planner::ArmPlanner planner(planner::CellGeometry(arms_of(cell), self), cell.arms[self].parameters,
                                recording.options);
    planner.receive({.obstacles = std::make_shared<const std::vector<world::Obstacle>>(cell.scene.obstacles)});
    for (std::size_t k = 0; k < recording.periods.size(); ++k) {
      const Period& period = recording.periods[k];
      planner::PeriodInputs inputs = period.inputs;
      inputs.arms = period.arms;
      inputs.obstacles = period.obstacles;
      planner.receive({.goal = period.goal});
      const planner::TickResult result = planner.step(inputs);
      (void)planner.plan_ahead(inputs, result);
      expect_same_bits(result.q, period.result.q, k, "q");
      expect_same_bits(result.qd, period.result.qd, k, "qd");
      ASSERT_FALSE(testing::Test::HasFatalFailure()) << "arm " << self;
    }
  }
}

/// Passes the recorded inputs to one planner of the service as messages.
class Service {
 public:
  Service(const planner::Cell& cell, int self, const Recording& recording)
      : cell_(cell), self_(self), searches_(recording), planner_(cell, self, node(self), recording.options) {
    msg::CellMode run;
    run.mode(msg::Mode::MODE_RUN);
    run.term(1);
    EXPECT_TRUE(mode_.apply(run, at(0)));
  }

  /// One period; returns the command message.
  const msg::ArmCommand& pass(const Period& period, std::size_t k) {
    const LivePlanner::Clock::time_point now = at(k);
    for (int i = 0; i < kArms; ++i) {
      if (i != self_ && period.arms[i].known) hear_arm(i, period.arms[i], now);
    }
    hear_own_arm(period.inputs.own, k);
    if (k == 0) {
      for (const world::Obstacle& obstacle : cell_.scene.obstacles) {
        msg::ObstacleShapes shapes;
        shapes.name(obstacle.name);
        shapes.obstacle(messages::to_message(obstacle));
        EXPECT_EQ(planner_.obstacles().apply(shapes, {}), std::nullopt);
      }
    }
    // Without obstacle states the simulated planner holds.
    if (!period.inputs.hold) hear_obstacles(period.obstacles, now);
    planner_.obstacles().join();

    const auto planned = planner_.step({.now = now,
                                        .mode = mode_,
                                        .term = 1,
                                        .commands = true,
                                        .continues = true,
                                        .hold = planner_.hold(now, mode_).has_value(),
                                        .goal = period.goal},
                                       searches_);
    EXPECT_TRUE(planned.has_value());
    if (planned) planner_.plan_ahead(*planned, searches_);
    return planner_.command();
  }
  [[nodiscard]] int questions() const { return searches_.questions(); }

 private:
  static std::string node(int arm) { return "planner/" + std::to_string(arm); }
  /// Beginning of period `k`.
  static LivePlanner::Clock::time_point at(std::size_t k) {
    return LivePlanner::Clock::time_point(std::chrono::hours(1) + static_cast<std::int64_t>(k) * kPeriodNs);
  }
  static LivePlanner::Clock::time_point sent(LivePlanner::Clock::time_point now, double age) {
    return now - std::llround(age / kPeriod) * kPeriodNs;
  }
  static std::int64_t stamp(LivePlanner::Clock::time_point time) { return time.time_since_epoch().count(); }
  [[nodiscard]] const std::string& name(int arm) const { return cell_.arms[arm].arm.name; }

  msg::ArmState state_of(int arm, const JointVector& q, const JointVector& qd, LivePlanner::Clock::time_point time) {
    msg::ArmState state;
    state.arm(name(arm));
    state.sequence_number(static_cast<std::uint64_t>(stamp(time)));
    state.stamp_ns(stamp(time));
    state.mode(msg::ArmMode::ARM_RUNNING);
    state.q(messages::to_message(q));
    state.qd(messages::to_message(qd));
    state.term(1);
    state.newest_term(1);
    state.planner(node(arm));
    return state;
  }

  /// Messages arrive when they are sent; the loop takes them now.
  void hear_arm(int arm, const planner::ArmObservation& seen, LivePlanner::Clock::time_point now) {
    const auto time = sent(now, seen.age);
    EXPECT_EQ(planner_.arms().apply(state_of(arm, seen.q, seen.qd, time), {}, time), std::nullopt);
    msg::GoalStatus status;
    status.arm(name(arm));
    status.goal(kGoal);
    status.state(seen.has_goal ? msg::GoalState::GOAL_ACTIVE : msg::GoalState::GOAL_REACHED);
    status.q_goal(messages::to_message(seen.q_goal));
    status.priority(seen.priority);
    EXPECT_EQ(planner_.arms().apply(status), std::nullopt);
    msg::CoupledPlanProgress progress;
    progress.arm(name(arm));
    progress.node(node(arm));
    if (seen.progress.proposer >= 0) progress.proposer(name(seen.progress.proposer));
    progress.number(seen.progress.number);
    progress.reached(seen.progress.reached);
    EXPECT_EQ(planner_.arms().apply(progress), std::nullopt);
    msg::CoupledPlan plan;
    plan.arm(name(arm));
    plan.node(node(arm));
    if (seen.proposal) {
      plan.number(seen.proposal->number);
      plan.points(static_cast<std::uint32_t>(seen.proposal->points.size()));
      for (const int one : seen.proposal->arms) plan.arms().push_back(name(one));
      for (const auto& point : seen.proposal->points) {
        for (const JointVector& q : point) plan.q().insert(plan.q().end(), q.begin(), q.end());
      }
    }
    EXPECT_EQ(planner_.arms().apply(plan), std::nullopt);
  }

  void hear_own_arm(const planner::OwnArmFeedback& own, std::size_t k) {
    msg::ArmState state = state_of(self_, own.state.q, own.state.qd, at(k));
    state.command_sequence_number(own.setpoint);
    state.command_age(own.setpoint_age);
    EXPECT_EQ(planner_.arms().apply(state, {}, at(k)), std::nullopt);
  }

  void hear_obstacles(const std::vector<world::ObstacleState>& states, LivePlanner::Clock::time_point now) {
    const auto time = sent(now, states.empty() ? 0.0 : states.front().age);
    world::ObstacleSnapshot snapshot;
    snapshot.sequence = static_cast<std::uint64_t>(stamp(time));
    snapshot.states = states;
    msg::ObstacleStates message = messages::to_message(snapshot, cell_.scene.obstacles);
    message.sequence_number(snapshot.sequence);
    message.stamp_ns(stamp(time));
    EXPECT_EQ(planner_.obstacles().apply(message, {}, time), std::nullopt);
  }

  const planner::Cell& cell_;
  int self_;
  CellModeView mode_;
  RecordedSearches searches_;
  LivePlanner planner_;
};

TEST(ServiceAndSimulation, CommandsTheSetPointsOfTheSimulation) {
  int questions = 0;
  for (int self = 0; self < kArms; ++self) {
    const Recording& recording = episode().recordings[self];
    Service service(episode().cell, self, recording);
    for (std::size_t k = 0; k < recording.periods.size(); ++k) {
      const msg::ArmCommand& command = service.pass(recording.periods[k], k);
      const planner::TickResult& recorded = recording.periods[k].result;
      EXPECT_EQ(command.sequence_number(), k + 1);
      expect_same_bits(Eigen::Map<const Eigen::VectorXd>(command.q().data(), std::ssize(command.q())), recorded.q, k,
                       "q");
      expect_same_bits(Eigen::Map<const Eigen::VectorXd>(command.qd().data(), std::ssize(command.qd())), recorded.qd, k,
                       "qd");
      ASSERT_FALSE(testing::Test::HasFailure()) << "arm " << self << ", period " << k;
    }
    questions += service.questions();
  }
  EXPECT_GT(questions, 0) << "the comparison must include searches";
}

// Such a driver continues to publish the last measured state.
TEST(LivePlannerHold, NamesTheFailureOfTheDevice) {
  const planner::Cell cell = test::corridor(kArms, -1.2, 2.0);
  LivePlanner planner(cell, 0, "planner/0", {});
  const LivePlanner::Clock::time_point failed(std::chrono::hours(1));
  const auto later = failed + std::chrono::seconds(10);
  msg::CellMode run;
  run.mode(msg::Mode::MODE_RUN);
  run.term(1);
  CellModeView mode;
  EXPECT_TRUE(mode.apply(run, failed));
  msg::ArmState state;
  state.arm(planner.name());
  state.q(messages::to_message(test::corridor_start(0, kArms)));
  state.qd(std::vector<double>(state.q().size()));
  state.sequence_number(1);
  EXPECT_EQ(planner.arms().apply(state, {}, failed), std::nullopt);
  EXPECT_EQ(planner.hold(later, mode)->kind(), msg::CauseKind::CAUSE_ARM_STATE_OLD);

  state.mode(msg::ArmMode::ARM_FAILED);
  state.cause(make_cause(msg::CauseKind::CAUSE_DEVICE_FAILED, planner.name(), "the cable is out"));
  state.sequence_number(2);
  EXPECT_EQ(planner.arms().apply(state, {}, failed), std::nullopt);
  const auto hold = planner.hold(later, mode);
  ASSERT_TRUE(hold);
  EXPECT_EQ(hold->kind(), msg::CauseKind::CAUSE_DEVICE_FAILED);
  EXPECT_TRUE(is_missing_input(*hold));
}

class NoSearches : public planner::SearchExecutor {
 public:
  [[nodiscard]] planner::SearchAnswers answers() override { return {}; }
  void ask(planner::SearchQuestions /*questions*/, const planner::SharedObstacles& /*obstacles*/) override {}
};

// If that state is newer than it seems, a set-point ahead of the arm would drive it faster and faster.
TEST(LivePlannerBegin, WaitsUntilAMovingArmStandsOrItsStateIsFresh) {
  const planner::Cell cell = test::corridor(kArms, -1.2, 2.0);
  using std::chrono::milliseconds;
  const auto begins = [&](double speed, milliseconds age, bool continues) {
    LivePlanner planner(cell, 0, "planner/0", {});
    NoSearches searches;
    const CellModeView mode;
    const LivePlanner::Clock::time_point measured(std::chrono::hours(1));
    msg::ArmState state;
    state.arm(planner.name());
    state.mode(msg::ArmMode::ARM_RUNNING);
    state.q(messages::to_message(test::corridor_start(0, kArms)));
    state.qd(std::vector<double>(state.q().size(), speed));
    state.sequence_number(1);
    EXPECT_EQ(planner.arms().apply(state, {}, measured), std::nullopt);
    if (continues) {
      EXPECT_TRUE(planner.step({.now = measured, .mode = mode}, searches));
    }
    return planner.step({.now = measured + age, .mode = mode, .continues = continues}, searches).has_value();
  };
  EXPECT_TRUE(begins(0.3, milliseconds(20), false));
  EXPECT_FALSE(begins(0.3, milliseconds(100), false));
  EXPECT_TRUE(begins(0.0, milliseconds(100), false));
  EXPECT_TRUE(begins(0.3, milliseconds(100), true));
}

}  // namespace
}  // namespace hecaton::services
