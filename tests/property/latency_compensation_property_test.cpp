// Delayed states never lead to a contact: docs/explanation/0006-latency-compensation.md against adversaries.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/local/latency_compensation.hpp"
#include "planner/methods/registry.hpp"
#include "planner/simulation/arm_model.hpp"
#include "planner/simulation/network_model.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

constexpr double kPeriod = 0.01;  // [s]
constexpr double kRadius = 0.05;  // of a planar point's ball [m]

// A pair on a line. The own body keeps a constant speed. The other body accelerates arbitrarily within its limits and
// keeps its damper. The true distance is never below least_distance().
TEST(LatencyCompensationProperty, LeastDistanceIsALowerBoundForAnyMotionWithinLimits) {
  Random random(11);
  double smallest_slack = 1.0;
  for (int trial = 0; trial < 20'000; ++trial) {
    const double security = random.uniform(0.01, 0.05);
    const double slope = random.uniform(0.5, 5.0);
    const double acceleration = random.uniform(1.0, 30.0);
    const double own_speed = random.uniform(-1.0, 1.0);
    const double age = random.uniform(0.0, 0.25);
    double distance = security + random.uniform(0.001, 0.5);
    const double other_speed = random.uniform(-1.5, slope * (distance - security));
    const double expected = distance - (own_speed + other_speed) * age;
    const double lazy = random.uniform(-0.2, 1.0);  // some do less than they may

    constexpr int kSteps = 2000;
    const double dt = age / kSteps;
    double speed = other_speed;
    for (int k = 0; k < kSteps; ++k) {
      const double faster = speed + lazy * acceleration * dt;
      speed = std::min(faster, slope * (distance - security));
      distance -= (own_speed + speed) * dt;
    }
    const double least =
        least_distance({expected, age, own_speed, own_speed, other_speed, acceleration}, security, slope);
    ASSERT_LE(least, expected);
    ASSERT_GE(distance, least - 2e-4) << "trial " << trial;
    smallest_slack = std::min(smallest_slack, distance - least);
  }
  EXPECT_LT(smallest_slack, 1e-3);  // the bound is tight
}

/// Lets an arm at `from` follow a straight trajectory, most of the time with a path tolerance.
void follow(ArmController& controller, const JointVector& from, const JointVector& to, double speed, Random& random) {
  TimedTrajectory trajectory;
  const double farthest = (to - from).cwiseAbs().maxCoeff();
  const double duration = std::max(0.2, farthest / (speed * random.uniform(0.2, 1.0)));
  trajectory.points = {{duration, to, joints({0.0, 0.0}), {}}};
  if (random.uniform() < 0.8) {
    trajectory.path_tolerance = joints({random.uniform(0.03, 0.3), random.uniform(0.03, 0.3)});
  }
  controller.set_goal(to, std::make_shared<const TimedTrajectory>(std::move(trajectory)));
}

struct Limits {
  double speed;         ///< [m/s]
  double acceleration;  ///< [m/s²]
};

struct DuelOptions {
  bool ages_known = true;   ///< the controllers know how old states are
  bool orders = false;      ///< the speed override of each arm changes all the time
  bool lags = false;        ///< both arms are behind their set-points, each as its own servo
  bool delay_known = true;  ///< the controllers know by how much
  bool aside = false;       ///< the balls are not on one line: they pass each other
  bool timed = false;       ///< goals are trajectories, most with path tolerances
  double oldest = 0.1;      ///< mean age of states, at most [s]
  std::uint64_t seed = 5;
};

/// Balls on a line under their real controllers, with delayed and lost states of each other. They get new goals all the
/// time, most of them beyond the other ball.
class Duel {
 public:
  Duel(Limits limits, const NetworkParameters& network, const DuelOptions& options, std::uint64_t seed)
      : random_(seed), options_(options) {
    for (const char* name : {"a", "b"}) {
      Arm arm = test::planar_point(name, kRadius);
      arm.limits.velocity.setConstant(limits.speed);
      arm.limits.acceleration.setConstant(limits.acceleration);
      arms_.push_back(arm);
    }
    LocalParameters parameters;
    parameters.method = built_in_method("local");  // no way around
    parameters.damper = {.influence_distance = 0.12, .security_distance = 0.03, .convergence_speed = 0.55};
    parameters.state_age_limit = 1.0;
    for (int i = 0; i < 2; ++i) {
      controllers_.emplace_back(CellGeometry(arms_, i), parameters, kPeriod, random_.next());
      if (options.lags) servos_[i] = random_servo();
      const double aside = options.aside ? random_.uniform(0.001, 0.1) : 0.0;
      drives_.emplace_back(arms_[i].limits, joints({i == 0 ? -0.6 : 0.6, aside}), 0.05, servos_[i], random_.next());
      channels_.emplace_back(network, random_.next());
    }
  }

  /// The smallest distance of the two balls in `seconds`.
  double run(double seconds) {
    double smallest = 10.0;
    for (double now = 0.0; now < seconds; now += kPeriod) {
      for (int i = 0; i < 2; ++i) {
        const JointState& measured = drives_[1 - i].measured();
        channels_[i].send(now, {measured.q, measured.qd, 0.0, true, true});
        channels_[i].receive(now);
        if (random_.uniform() < 0.02) set_goal(i);
        if (options_.orders && random_.uniform() < 0.03) order_speed(i);
      }
      for (int i = 0; i < 2; ++i) {
        std::array<ArmObservation, 2> seen;
        seen[1 - i] = channels_[i].newest();
        if (channels_[i].known() && options_.ages_known) seen[1 - i].age = channels_[i].age(now);
        seen[1 - i].speed = orders_[1 - i];
        const TickResult result = step(i, seen);
        drives_[i].command(result.q, result.qd, kPeriod);
      }
      ++number_;
      for (int k = 0; k < kDriveSteps; ++k) {
        for (ArmModel& drive : drives_) drive.step(kPeriod / kDriveSteps);
        smallest = std::min(smallest, (drives_[0].q() - drives_[1].q()).norm() - 2.0 * kRadius);
      }
    }
    return smallest;
  }

 private:
  static constexpr int kDriveSteps = 5;

  /// One of a maker, or any.
  ServoParameters random_servo() {
    const std::vector<ServoPreset>& presets = servo_presets();
    const auto one = static_cast<std::size_t>(random_.uniform(0.0, 2.0 * static_cast<double>(presets.size())));
    if (one < presets.size()) return presets[one].servo;
    const double dead_time = random_.uniform(0.0, 0.15);
    return {.dead_time = dead_time, .jitter = 0.02 * dead_time, .lag = random_.uniform(0.01, 0.03), .noise = 1e-5};
  }

  /// Without the delay: what measured positions say once they are corrected by it, and no more.
  TickResult step(int i, std::span<const ArmObservation> seen) {
    const JointState& measured = drives_[i].measured();
    if (!options_.lags || !options_.delay_known) {
      const bool first = number_ == 0 || !options_.lags;
      return controllers_[i].step(first ? MeasuredState{measured.q, measured.qd} : controllers_[i].setpoint(), seen, {},
                                  false);
    }
    OwnArmFeedback feedback;
    feedback.state = {measured.q, measured.qd};
    feedback.follows = true;
    feedback.setpoint = number_;
    feedback.setpoint_age = kPeriod;
    feedback.tracking_delay = servos_[i].delay();
    TickResult result = controllers_[i].step(feedback, seen, {}, false);
    controllers_[i].sent(number_ + 1);
    return result;
  }

  void set_goal(int i) {
    const JointVector beyond = drives_[1 - i].q() + 0.5 * (drives_[1 - i].q() - drives_[i].q());
    const JointVector away = joints({random_.uniform(0.0, i == 0 ? -1.0 : 1.0), 0.0});
    const JointVector to = random_.uniform() < 0.7 ? beyond : away;
    if (options_.timed) return follow(controllers_[i], drives_[i].q(), to, arms_[i].limits.velocity[0], random_);
    controllers_[i].set_goal(to);
  }

  void order_speed(int i) {
    orders_[i] = random_.uniform() < 0.4 ? 1.0 : random_.uniform(0.01, 1.0);
    controllers_[i].order_speed(orders_[i]);
  }

  Random random_;
  DuelOptions options_;
  std::array<ServoParameters, 2> servos_{};
  std::uint64_t number_ = 0;  ///< of the last set-points
  std::array<double, 2> orders_{1.0, 1.0};
  std::vector<Arm> arms_;
  std::vector<ArmController> controllers_;
  std::vector<ArmModel> drives_;
  std::vector<StateChannel<ArmObservation>> channels_;  ///< [receiver]
};

double smallest_of_duels(const DuelOptions& options) {
  Random random(options.seed);
  double smallest = 10.0;
  const bool slower = options.lags || options.aside;
  for (int trial = 0; trial < 150; ++trial) {
    const double speed = random.uniform(0.3, slower ? 1.5 : 3.0);
    const double age = random.uniform(0.0, options.oldest);
    // Beyond some acceleration the lag is no mere delay any more, and the planner loses track.
    const Limits limits{speed, speed / random.uniform(slower ? 0.15 : 0.05, 0.3)};
    const NetworkParameters network{.age = age, .jitter = random.uniform(0.0, age), .loss = 0.2, .burst = 2.0};
    smallest = std::min(smallest, Duel(limits, network, options, random.next()).run(6.0));
  }
  return smallest;
}

/// Execution times of a process that shares its processor: once a period, with stalls.
class Starved {
 public:
  Starved(double period, double share, double longest, std::uint64_t seed)
      : period_(period), share_(share), longest_(longest), random_(seed) {}

  /// True if the process runs at `now` [s]; skipped() then returns the number of missed periods.
  bool runs(double now) {
    if (now < due_ || now < stalled_until_) return false;
    skipped_ = static_cast<int>((now - due_) / period_ + 1e-6);
    due_ += (skipped_ + 1) * period_;
    if (random_.uniform() < share_) stalled_until_ = now + random_.uniform(0.0, longest_);
    return true;
  }
  [[nodiscard]] int skipped() const { return skipped_; }

 private:
  double period_, share_, longest_;
  Random random_;
  double due_ = 0.0;
  double stalled_until_ = 0.0;
  int skipped_ = 0;
};

/// A ball among static posts. Its planner and driver stall, and their messages are delayed.
class StarvedRun {
 public:
  /// `naive`: extrapolates the own arm at constant velocity, and compares it with the newest set-point. `timed`: goals
  /// are trajectories, most with path tolerances.
  StarvedRun(const NetworkParameters& network, double longest_stall, bool naive, bool timed, std::uint64_t seed)
      : random_(seed),
        naive_(naive),
        timed_(timed),
        planner_(kPeriod, 0.05, longest_stall, random_.next()),
        driver_(kStep, 0.01, longest_stall, random_.next()),
        commands_(network, random_.next()),
        states_(network, random_.next()) {
    arm_.limits.velocity.setConstant(1.5);
    arm_.limits.acceleration.setConstant(10.0);
    LocalParameters parameters;
    parameters.method = built_in_method("boundary_following");
    parameters.damper = {.influence_distance = 0.12, .security_distance = 0.03, .convergence_speed = 0.55};
    parameters.state_age_limit = 1.0;
    controller_.emplace(CellGeometry({arm_}, 0), parameters, kPeriod, random_.next());
    for (const auto& [x, y] : kPosts) {
      posts_.push_back(test::box_obstacle("post" + std::to_string(posts_.size()), {x, y, 0}, {kHalf, kHalf, kHalf}));
      standing_.push_back({posts_.back().X_WO, {}, 0.0});
    }
    controller_->set_obstacles(posts_);
    drive_.emplace(arm_.limits, joints({0.0, 0.0}), kTimeout);
  }

  struct Outcome {
    double smallest = 10.0;  ///< distance of the ball to a post [m]
    double way = 0.0;        ///< travelled distance [m]
  };
  Outcome run(double seconds) {
    Outcome outcome;
    for (double now = 0.0; now < seconds; now += kStep) {
      if (driver_.runs(now)) drive(now);
      if (planner_.runs(now)) plan(now);
      for (const auto& [x, y] : kPosts) {
        const Eigen::Vector2d off = (Eigen::Vector2d(drive_->q()) - Eigen::Vector2d(x, y)).cwiseAbs();
        outcome.smallest = std::min(outcome.smallest, (off.array() - kHalf).max(0.0).matrix().norm() - kRadius);
      }
      outcome.way += drive_->qd().norm() * kStep;
    }
    return outcome;
  }

 private:
  static constexpr double kStep = 0.002;
  static constexpr double kTimeout = 0.05;
  static constexpr double kHalf = 0.1;
  static constexpr std::array<std::array<double, 2>, 4> kPosts{{{0.5, 0}, {-0.5, 0.1}, {0, 0.55}, {0.05, -0.5}}};
  struct Command {
    MeasuredState setpoint;
    std::uint64_t number = 0;
  };

  // As ArmDriver::run(): the time of a stall passes without new commands.
  void drive(double now) {
    for (int k = driver_.skipped(); k > 0; --k) step();
    commands_.receive(now);
    if (commands_.known() && commands_.newest().number > number_) take(commands_.newest());
    step();
    const bool follows = drive_->mode() == DriveMode::kTracking;
    states_.send(now, {{drive_->q(), drive_->qd()}, 0.0, follows, number_, command_age_});
  }
  void take(const Command& command) {
    number_ = command.number;
    if (drive_->command(command.setpoint.q, command.setpoint.qd, kPeriod)) command_age_ = 0.0;
  }
  void step() {
    command_age_ += kStep;
    drive_->step(kStep);
  }

  // As PlannerService::run().
  void plan(double now) {
    if (naive_ && planner_.skipped() > 0) controller_->forget_setpoint();
    if (!naive_) controller_->skip(planner_.skipped() * kPeriod);
    states_.receive(now);
    if (!states_.known()) return;
    if (random_.uniform() < 0.01) {
      const JointVector to = joints({random_.uniform(-0.9, 0.9), random_.uniform(-0.9, 0.9)});
      if (timed_) {
        follow(*controller_, drive_->q(), to, arm_.limits.velocity[0], random_);
      } else {
        controller_->set_goal(to);
      }
    }
    OwnArmFeedback feedback = states_.newest();
    feedback.age = states_.age(now);
    const std::array<ArmObservation, 1> no_arms{};
    const TickResult result = step(feedback, no_arms);
    commands_.send(now, {{result.q, result.qd}, ++sent_});
    controller_->sent(sent_);
  }
  TickResult step(const OwnArmFeedback& feedback, std::span<const ArmObservation> no_arms) {
    if (!naive_) return controller_->step(feedback, no_arms, standing_, false);
    if (!feedback.follows) controller_->forget_setpoint();
    const MeasuredState kept{feedback.state.q + feedback.state.qd * feedback.age, feedback.state.qd};
    return controller_->step(kept, no_arms, standing_, false);
  }

  Random random_;
  bool naive_;
  bool timed_;
  Arm arm_ = test::planar_point("ball", kRadius);
  std::vector<world::Obstacle> posts_;
  std::vector<world::ObstacleState> standing_;
  std::optional<ArmController> controller_;
  std::optional<ArmModel> drive_;
  Starved planner_, driver_;
  StateChannel<Command> commands_;
  StateChannel<OwnArmFeedback> states_;
  std::uint64_t number_ = 0;  ///< of the set-point that the drive has
  double command_age_ = 0.0;
  std::uint64_t sent_ = 0;
};

StarvedRun::Outcome run_starved(bool naive, bool timed = false) {
  Random random(21);
  StarvedRun::Outcome all;
  for (int trial = 0; trial < 200; ++trial) {
    const double age = random.uniform(0.0, 0.1);
    const NetworkParameters network{.age = age, .jitter = random.uniform(0.0, age)};
    const double stall = random.uniform(0.0, 0.5);
    const auto one = StarvedRun(network, stall, naive, timed, random.next()).run(20.0);
    all.smallest = std::min(all.smallest, one.smallest);
    all.way += one.way;
  }
  return all;
}

TEST(LatencyCompensationProperty, ArmTouchesNothingWhenItsProcessesStall) {
  const auto outcome = run_starved(false);
  EXPECT_GT(outcome.smallest, 0.0);
  EXPECT_GT(outcome.way, 400.0) << "and it gets about, in 4000 s";
}

TEST(LatencyCompensationProperty, ArmOnTrajectoriesTouchesNothingWhenItsProcessesStall) {
  const auto outcome = run_starved(false, true);
  EXPECT_GT(outcome.smallest, 0.0);
  EXPECT_GT(outcome.way, 400.0) << "and it gets about, in 4000 s";
}

// The planner then assumes that an arm without set-points is nearer to its goal than it is, and commands it there.
TEST(LatencyCompensationProperty, ArmTouchesWhenItsOwnStateIsExtrapolatedAtConstantVelocity) {
  EXPECT_LT(run_starved(true).smallest, 0.0);
}

TEST(LatencyCompensationProperty, TwoArmsThatApproachEachOtherNeverTouch) {
  EXPECT_GT(smallest_of_duels({}), 0.02);  // dₛ is 0.03
}

TEST(LatencyCompensationProperty, TwoArmsOnTrajectoriesNeverTouch) {
  EXPECT_GT(smallest_of_duels({.timed = true}), 0.02);  // dₛ is 0.03
  EXPECT_GT(smallest_of_duels({.orders = true, .aside = true, .timed = true, .oldest = 0.2}), 0.02);
}

TEST(LatencyCompensationProperty, TwoArmsNeverTouchWhileTheirSpeedOverridesChange) {
  EXPECT_GT(smallest_of_duels({.orders = true}), 0.02);  // dₛ is 0.03
}

/// A ball under its real controller, and one that a person moves with a share of its limits. The person moves it
/// towards the first ball most of the time, and away again before that has no room left.
double smallest_beside_a_guided_arm(bool known_as_foreign, double share, std::uint64_t seed) {
  constexpr Limits kLimits{1.0, 8.0};
  Random random(seed);
  std::vector<Arm> arms;
  for (const char* name : {"a", "guided"}) {
    Arm arm = test::planar_point(name, kRadius);
    arm.limits.velocity.setConstant(kLimits.speed);
    arm.limits.acceleration.setConstant(kLimits.acceleration);
    arms.push_back(arm);
  }
  LocalParameters parameters;
  parameters.method = built_in_method("local");
  parameters.damper = {.influence_distance = 0.12, .security_distance = 0.03, .convergence_speed = 0.55};
  ArmController controller(CellGeometry(arms, 0), parameters, kPeriod, random.next());
  ArmModel drive(arms[0].limits, joints({0.0, 0.0}), 0.05);
  StateChannel<ArmObservation> channel({.age = 0.01, .jitter = 0.01, .loss = 0.1, .burst = 2.0}, random.next());
  MeasuredState guided{joints({1.0, 0.3}), joints({0.0, 0.0})};
  JointVector wanted = joints({0.0, 0.0});
  double smallest = 10.0;
  for (double now = 0.0; now < 20.0; now += kPeriod) {
    if (random.uniform() < 0.05) {
      const JointVector way = drive.q() - guided.q;
      const bool away = drive.q().norm() > 1.5 || random.uniform() < 0.2;
      wanted = (away ? -1.0 : 1.0) * way.normalized() * random.uniform(0.0, share * kLimits.speed);
      controller.set_goal(joints({random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)}));
    }
    const JointVector before = guided.qd;
    const double change = share * kLimits.acceleration * kPeriod;
    guided.qd += (wanted - before).cwiseMax(-change).cwiseMin(change);
    guided.q += 0.5 * (before + guided.qd) * kPeriod;
    ArmObservation state{guided.q, guided.qd, 0.0, true, false};
    state.foreign = known_as_foreign;
    channel.send(now, state);
    channel.receive(now);
    std::array<ArmObservation, 2> seen;
    seen[1] = channel.newest();
    if (channel.known()) seen[1].age = channel.age(now);
    const TickResult result = controller.step(MeasuredState{drive.q(), drive.qd()}, seen, {}, false);
    drive.command(result.q, result.qd, kPeriod);
    drive.step(kPeriod);
    smallest = std::min(smallest, (drive.q() - guided.q).norm() - 2.0 * kRadius);
  }
  return smallest;
}

TEST(LatencyCompensationProperty, ArmGivesWayToAnArmThatOthersMove) {
  double smallest = 10.0;
  for (std::uint64_t seed = 0; seed < 100; ++seed)
    smallest = std::min(smallest, smallest_beside_a_guided_arm(true, 0.4, seed));
  EXPECT_GT(smallest, 0.0);
}

// Margins are functions of an old state, its age and the full limits. They hold for every history of overrides: they
// shrink after the measured speed has fallen, and contain what the arm can gain by a higher order within the age.
TEST(LatencyCompensationProperty, MarginsHoldForEverySpeedOverrideButNotForTrustedOrders) {
  struct Moment {
    MeasuredState state;
    double ordered;
  };
  const Arm arm = test::planar_point();
  LocalParameters parameters;
  parameters.method = built_in_method("local");
  ArmController controller(CellGeometry({arm}, 0), parameters, kPeriod, 1);
  Random random(17);
  const std::array<ArmObservation, 1> no_arms{};
  std::vector<Moment> moments{{{joints({0, 0}), joints({0, 0})}, 1.0}};
  int broken_by_trust = 0;
  for (int k = 1; k < 30'000; ++k) {
    double ordered = moments.back().ordered;
    if (random.uniform() < 0.05) ordered = random.uniform() < 0.3 ? 1.0 : random.uniform(0.01, 1.0);
    if (random.uniform() < 0.02) {
      controller.set_goal(joints({random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)}));
    }
    controller.order_speed(ordered);
    const TickResult result = controller.step(moments.back().state, no_arms, {}, false);
    moments.push_back({{result.q, result.qd}, ordered});

    const int periods = std::min(k, 1 + static_cast<int>(random.uniform(0.0, 20.0)));
    const double age = periods * kPeriod;
    const Moment& then = moments[moments.size() - 1 - periods];
    const JointVector margin = 0.5 * age * age * arm.limits.acceleration;
    const JointVector foreseen = then.state.q + then.state.qd * age;
    ASSERT_TRUE(((result.q - foreseen).array().abs() <= margin.array() + 1e-9).all()) << "period " << k;

    JointVector q = result.q;
    JointVector qd = result.qd;
    stop_for(arm.limits, stop_time(arm.limits, qd), q, qd);
    const ReachableStopSet set = reachable_stop_set(arm.limits, then.state.q, then.state.qd, age);
    ASSERT_TRUE(((q - set.q).array().abs() <= set.position_uncertainty.array() + 1e-9).all()) << "period " << k;

    const JointVector most = then.ordered * arm.limits.velocity;
    const JointVector trusted = then.state.q + then.state.qd.cwiseMax(-most).cwiseMin(most) * age;
    broken_by_trust += ((result.q - trusted).array().abs() > margin.array() + 1e-9).any() ? 1 : 0;
  }
  EXPECT_GT(broken_by_trust, 100) << "an ordered speed is not a measured one";
}

TEST(LatencyCompensationProperty, TwoArmsComeTooNearWhenAgesAreIgnored) {
  EXPECT_LT(smallest_of_duels({.ages_known = false, .oldest = 0.2}), 0.02);
}

TEST(LatencyCompensationProperty, TwoArmsThatLagBehindTheirSetPointsNeverTouch) {
  EXPECT_GT(smallest_of_duels({.lags = true}), 0.02);  // dₛ is 0.03
}

TEST(LatencyCompensationProperty, TwoArmsThatPassEachOtherNeverTouch) {
  EXPECT_GT(smallest_of_duels({.aside = true, .oldest = 0.2}), 0.02);
  EXPECT_GT(smallest_of_duels({.lags = true, .aside = true}), 0.02);
}

TEST(LatencyCompensationProperty, TwoArmsComeTooNearWhenTheirLagIsIgnored) {
  EXPECT_LT(smallest_of_duels({.lags = true, .delay_known = false}), 0.02);
}

}  // namespace
}  // namespace hecaton::planner
