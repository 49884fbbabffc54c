#include "planner/simulation/cell_simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "planner/arm_planner/search_executor.hpp"
#include "planner/goal_check.hpp"
#include "planner/simulation/arm_in_world.hpp"
#include "planner/simulation/thread_pool.hpp"

namespace hecaton::planner {
namespace {

/// An episode ends when all arms are blocked for this long [s].
constexpr double kStallTimeout = 10.0;
/// Ticks of so many arms take some 50 µs, of the order of what it costs to wake a thread.
constexpr int kArmsPerThread = 10;
/// Configurations that the route search of a live planner checks in one control period: 0.33 µs each, on a processor
/// that it shares.
constexpr std::uint64_t kChecksPerPeriod = 10'000;

int useful_threads(int threads, int arms) {
  return std::clamp(arms / kArmsPerThread, 1, std::max(1, threads));
}

double microseconds_since(std::chrono::steady_clock::time_point then) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - then).count();
}

/// Processor time of this thread [µs].
double processor_us() {
  timespec spent;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &spent);
  return 1e6 * static_cast<double>(spent.tv_sec) + 1e-3 * static_cast<double>(spent.tv_nsec);
}

std::vector<world::ArmBodies> all_bodies(const Cell& cell) {
  std::vector<world::ArmBodies> bodies;
  for (const PlannedArm& planned : cell.arms) bodies.push_back(arm_bodies(planned.arm));
  return bodies;
}

/// Runs an arm's searches in virtual time: an answer arrives after as many control periods as the search thread of a
/// live planner would need. The result depends on no clock.
class VirtualTimeSearches : public SearchExecutor {
 public:
  /// The input of all searches; outlives them.
  struct Scene {
    std::vector<Arm> arms;
    std::vector<LocalParameters> parameters;
    SharedObstacles obstacles;
    double control_period = 0.010;  ///< [s]
  };
  /// `self`: index of the own arm.
  VirtualTimeSearches(const Scene& scene, int self) : scene_(&scene), self_(self) {}

  [[nodiscard]] SearchAnswers answers() override {
    now_ = static_cast<double>(periods_++) * scene_->control_period;
    SearchAnswers answers;
    if (rollouts_ && rollouts_->busy()) {
      answers.rollout = rollouts_->advance(scene_->parameters[self_].rollout.ticks_per_period);
    }
    answers.route = due(routes_);
    answers.coupled_plan = due(coupled_plans_);
    return answers;
  }

  /// The obstacles stay those of the scene.
  void ask(SearchQuestions questions, const SharedObstacles& /*obstacles*/) override {
    if (questions.rollout) {
      if (!rollouts_) {
        rollouts_ = std::make_unique<RolloutSearch>(scene_->arms, scene_->parameters, self_);
        rollouts_->set_obstacles(*scene_->obstacles);
      }
      rollouts_->begin(std::move(*questions.rollout));
    }
    if (questions.coupled_plan) begin(coupled_plans_, *questions.coupled_plan);
    if (questions.route) begin(routes_, *questions.route);
  }

  /// Ticks of single arms that all rollouts simulated.
  [[nodiscard]] std::uint64_t rollout_ticks() const { return rollouts_ ? rollouts_->ticks() : 0; }

 private:
  struct PendingSearch {
    std::unique_ptr<RouteSearch> search;  ///< null until the first question
    std::optional<RouteAnswer> answer;
    double arrives = 0.0;  ///< when the planner gets the answer [s]
  };

  [[nodiscard]] std::optional<RouteAnswer> due(PendingSearch& pending) const {
    if (!pending.answer || now_ < pending.arrives) return std::nullopt;
    return std::exchange(pending.answer, std::nullopt);
  }

  void begin(PendingSearch& pending, const RouteQuestion& question) const {
    if (!pending.search) {
      pending.search = std::make_unique<RouteSearch>(scene_->arms, scene_->parameters, self_);
      pending.search->set_obstacles(*scene_->obstacles);
    }
    pending.answer = pending.search->answer(question);
    const auto periods = 1 + pending.answer->checks / kChecksPerPeriod;  // whole ones
    pending.arrives = now_ + (static_cast<double>(periods) - 0.5) * scene_->control_period;
  }

  const Scene* scene_;
  int self_;
  long periods_ = 0;
  double now_ = 0.0;                         ///< [s]
  std::unique_ptr<RolloutSearch> rollouts_;  ///< null until the first question: most arms of a large cell never ask
  PendingSearch routes_;
  PendingSearch coupled_plans_;
};

/// One arm: driver, sensors and searches. Its planner is in Episode::planners_.
struct SimulatedArm {
  ArmPlannerOptions options;
  VirtualTimeSearches searches;
  ArmModel drive;
  double tracking_delay = 0.0;       ///< of the drive [s]
  DelayedObservations observations;  ///< what its planner knows of other arms
  RangeScanner scanner;
  PeriodEvents events = {};    ///< of the next period
  Kinematics kinematics = {};  ///< as measured
  TickResult result = {};      ///< of the last period
  ReversalCounter reversals = {};
  double tick_us = 0.0;    ///< of the last tick, on the machine's clock [µs]
  double search_us = 0.0;  ///< processor time of the last period's searches [µs]
};

class Episode {
 public:
  Episode(const Cell& cell, const CellConfiguration& starts, const EpisodeOptions& options)
      : cell_(cell),
        options_(options),
        search_scene_{arms_of(cell), parameters_of(cell),
                      std::make_shared<const std::vector<world::Obstacle>>(cell.scene.obstacles),
                      cell.timing.control_period},
        world_(cell.scene, all_bodies(cell)),
        threads_(useful_threads(options.threads, static_cast<int>(cell.arms.size())),
                 static_cast<int>(cell.arms.size())) {
    const int n = static_cast<int>(cell.arms.size());
    world_.set_time(options.world_time);
    caster_.set_obstacles(world_.obstacles());
    outcome_.arms.resize(n);
    Random random(options.seed);
    std::vector<ArmPlannerOptions> planner_options(n);
    std::vector<DelayedObservations> observations;
    for (int i = 0; i < n; ++i) {
      planner_options[i].control_period = cell.timing.control_period;
      planner_options[i].motion_seed = random.next();
      planner_options[i].rollout_seed = random.next();
      planner_options[i].route_seed = options.seed + static_cast<std::uint64_t>(i);
      observations.emplace_back(options.network, i, n, static_cast<int>(cell.scene.obstacles.size()), random);
    }
    for (int i = 0; i < n; ++i) {
      planners_.emplace_back(CellGeometry(search_scene_.arms, i), cell.arms[i].parameters, planner_options[i]);
      planners_.back().receive({.obstacles = search_scene_.obstacles});
      arms_.push_back({.options = planner_options[i],
                       .searches = VirtualTimeSearches(search_scene_, i),
                       .drive = drive(i, starts[i]),
                       .tracking_delay = options.servos.empty() ? 0.0 : options.servos[i].delay(),
                       .observations = std::move(observations[i]),
                       .scanner = RangeScanner(cell.arms[i], random.next())});
      measure(i);
    }
    publish_measured();
  }

  EpisodeOutcome run(const CellConfiguration& goals) {
    for (std::size_t i = 0; i < arms_.size(); ++i) arms_[i].events.goal = GoalChange{goals[i]};
    const double dt = cell_.timing.control_period;
    const auto periods = static_cast<long>(std::llround(cell_.tasks.time_limit / dt));
    double stalled_for = 0.0;
    const auto began = std::chrono::steady_clock::now();
    if (options_.log != nullptr) options_.log->begin(goals);
    for (long period = 0; period < periods; ++period) {
      const double now = static_cast<double>(period) * dt;
      plan_and_move(now, dt);
      world_.step(dt);
      outcome_.duration = now + dt;
      record(outcome_.duration, goals);
      if (options_.observe) options_.observe(outcome_.duration, measured(), planners_);
      if (all_reached()) break;
      if (options_.ended && options_.ended()) {
        outcome_.ended_early = true;
        break;
      }
      const bool all_blocked = std::all_of(arms_.begin(), arms_.end(), [](const SimulatedArm& arm) {
        return arm.result.status == TickStatus::kBlocked || arm.result.status == TickStatus::kReached;
      });
      stalled_for = all_blocked ? stalled_for + dt : 0.0;
      if (stalled_for > kStallTimeout) {
        declare_blocked();
        break;
      }
    }
    if (options_.times != nullptr) options_.times->run_us += microseconds_since(began);
    log_moment(outcome_.duration);
    declare_stalled();
    explain(goals);
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      const ArmPlanner::Counts counts = planners_[i].counts();
      outcome_.arms[i].rollouts = counts.rollouts;
      outcome_.arms[i].routes = counts.routes;
      outcome_.arms[i].coupled_plans = counts.coupled_plans;
      outcome_.rollout_ticks += arms_[i].searches.rollout_ticks();
    }
    outcome_.contact_report = world_.contact_monitor().report();
    if (options_.log != nullptr) options_.log->end(outcome_);
    return outcome_;
  }

 private:
  [[nodiscard]] ArmModel drive(int i, const JointVector& start) const {
    const JointLimits& limits = cell_.arms[i].arm.limits;
    if (options_.servos.empty()) return {limits, start, cell_.timing.command_timeout};
    return {limits, start, cell_.timing.command_timeout, options_.servos[i],
            options_.seed + static_cast<std::uint64_t>(i)};
  }

  /// All arms and the world publish; then each planner ticks on what has reached it, and its drive follows. No planner
  /// sees another arm's next state, so that the order of the arms does not matter.
  void plan_and_move(double now, double dt) {
    log_moment(now);
    auto instant = std::make_shared<CellInstant>();
    for (std::size_t i = 0; i < arms_.size(); ++i) instant->arms.push_back(own_state(i));
    instant->obstacles = world_.snapshot().states;
    caster_.place(world_.present());
    threads_.for_each([&](int i) {
      arms_[i].observations.update(now, instant);
      plan(i, now);
      move(i, dt);
    });
    publish_measured();
    outcome_.ticks += arms_.size();
    if (options_.times == nullptr) return;
    for (const SimulatedArm& arm : arms_) {
      options_.times->tick_us.push_back(arm.tick_us);
      options_.times->rollout_us += arm.search_us;
    }
  }

  void log_moment(double now) const {
    if (options_.log == nullptr) return;
    std::vector<JointState> measured;
    for (const SimulatedArm& arm : arms_) measured.push_back(arm.drive.measured());
    options_.log->publish({now, measured, world_.snapshot(), world_.contact_monitor().report()});
  }

  /// There is no network between a planner and its own driver and sensors. The drive gets each set-point at once.
  void plan(int i, double now) {
    SimulatedArm& arm = arms_[i];
    ArmPlanner& planner = planners_[i];
    const std::vector<RangeScan> scans = arm.scanner.scan(now, arm.drive.q(), caster_);
    arm.events.scans = scans;
    const bool timed = options_.times != nullptr;
    double spent = timed ? processor_us() : 0.0;
    PeriodInputs inputs;
    inputs.answers = arm.searches.answers();
    arm.search_us = timed ? processor_us() - spent : 0.0;
    inputs.own.state = {arm.drive.measured().q, arm.drive.measured().qd};
    inputs.own.tracking_delay = arm.tracking_delay;
    inputs.own.follows = true;
    inputs.own.setpoint = number_;
    inputs.own.setpoint_age = cell_.timing.control_period;
    inputs.number = number_ + 1;
    inputs.arms = arm.observations.arms();
    inputs.obstacles = arm.observations.obstacles();
    inputs.hold = !arm.observations.knows_obstacles() && planner.controller().guide() == nullptr;
    planner.receive(arm.events);

    const auto before = std::chrono::steady_clock::now();
    arm.result = planner.step(inputs);
    arm.tick_us = microseconds_since(before);
    spent = timed ? processor_us() : 0.0;
    arm.searches.ask(planner.plan_ahead(inputs, arm.result), search_scene_.obstacles);
    if (timed) arm.search_us += processor_us() - spent;
    if (options_.log != nullptr) options_.log->plan({i, arm.options, arm.events, inputs, arm.result, planner, now});
    arm.events = {};
    arm.drive.command(arm.result.q, arm.result.qd, cell_.timing.control_period);
  }

  [[nodiscard]] ArmObservation own_state(std::size_t i) const {
    const ArmController& controller = planners_[i].controller();
    const JointState& measured = arms_[i].drive.measured();
    return {measured.q,
            measured.qd,
            0.0,
            true,
            true,
            controller.under_way(),
            controller.goal().value_or(JointVector()),
            controller.priority(),
            {},
            planners_[i].progress(),
            planners_[i].proposal()};
  }

  void move(int i, double dt) {
    const int steps = std::max(1, static_cast<int>(std::lround(dt / cell_.timing.driver_period)));
    for (int k = 0; k < steps; ++k) arms_[i].drive.step(dt / steps);
    measure(i);
  }

  void measure(int i) {
    const Arm& arm = search_scene_.arms[i];
    forward_kinematics(*arm.model, arm.X_WB, arms_[i].drive.q(), arms_[i].kinematics);
  }

  void publish_measured() {
    for (int i = 0; i < static_cast<int>(arms_.size()); ++i) {
      const Kinematics& at = arms_[i].kinematics;
      world_.set_arm(i, std::span<const Pose>(at.X_WL).first(at.links), at.X_WT);
    }
  }

  void record(double now, const CellConfiguration& goals) {
    ++number_;
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      const TickResult& result = arms_[i].result;
      ArmOutcome& arm = outcome_.arms[i];
      arm.subspaces_drawn = result.subspaces_drawn;
      arm.relaxed_ticks += result.relaxed ? 1 : 0;
      arm.yielding_ticks += result.yields_to >= 0 ? 1 : 0;
      arms_[i].reversals.add(result.qd, cell_.arms[i].arm.limits, result.near, cell_.timing.control_period);
      arm.reversals = arms_[i].reversals.total();
      // As live: the set-point and the measured position are at the goal.
      const bool reached =
          result.status == TickStatus::kReached && !error_at_goal(cell_.arms[i].arm, arms_[i].drive.q(), goals[i],
                                                                  cell_.arms[i].parameters.goal_tolerance, nullptr);
      if (reached && arm.outcome != TaskOutcome::kReached) {
        arm.outcome = TaskOutcome::kReached;
        arm.time = now;
      }
      if (arm.outcome != TaskOutcome::kReached) arm.time = now;
    }
  }

  [[nodiscard]] bool all_reached() const {
    return std::all_of(outcome_.arms.begin(), outcome_.arms.end(),
                       [](const ArmOutcome& arm) { return arm.outcome == TaskOutcome::kReached; });
  }

  void declare_blocked() {
    for (ArmOutcome& arm : outcome_.arms) {
      if (arm.outcome != TaskOutcome::kReached) arm.outcome = TaskOutcome::kBlocked;
    }
  }

  /// An arm that timed out and whose progress had stalled counts as blocked.
  void declare_stalled() {
    for (std::size_t i = 0; i < planners_.size(); ++i) {
      ArmOutcome& arm = outcome_.arms[i];
      if (arm.outcome == TaskOutcome::kTimedOut && planners_[i].controller().goal_progress().stalled()) {
        arm.outcome = TaskOutcome::kBlocked;
      }
    }
  }

  /// Says for each arm that has not reached its goal what kept it away in the last period.
  void explain(const CellConfiguration& goals) {
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      ArmOutcome& arm = outcome_.arms[i];
      if (arm.outcome != TaskOutcome::kReached) arm.reason = reason_of(i, goals[i], arm.outcome);
    }
  }

  [[nodiscard]] std::string reason_of(std::size_t i, const JointVector& goal, TaskOutcome outcome) const {
    const ArmController& controller = planners_[i].controller();
    const TickResult& result = arms_[i].result;
    const JointVector& q = arms_[i].drive.q();
    if (result.status == TickStatus::kReached) {
      const auto error = error_at_goal(cell_.arms[i].arm, q, goal, cell_.arms[i].parameters.goal_tolerance, nullptr);
      return error ? "the drive does not follow: " + *error : "it has left its goal again";
    }
    if (result.status == TickStatus::kStaleInput) {
      return result.stale_arm < 0
                 ? "the states of the obstacles are missing or too old"
                 : "the state of arm " + cell_.arms[result.stale_arm].arm.name + " is missing or too old";
    }
    if (result.status == TickStatus::kHolding) return "no state of the obstacles has been received";
    if (controller.guide() != nullptr && !result.has_binding) {
      if (auto no_path = controller.guide()->no_path_reason(q)) return *no_path;
    }
    std::string reason = outcome == TaskOutcome::kTimedOut ? "still on its way at the time limit" : "no progress";
    if (result.yields_to >= 0) reason += ", yields to arm " + cell_.arms[result.yields_to].arm.name;
    const bool blocked = result.status == TickStatus::kBlocked;
    if (!result.has_binding) return blocked ? reason + " within the joint limits" : reason;
    const CellGeometry& geometry = controller.geometry();
    char distance[32];
    std::snprintf(distance, sizeof distance, "%.0f mm", result.binding.distance * 1e3);
    return reason + ": " + geometry.own_name(result.binding) + " – " + geometry.other_name(result.binding) + ", " +
           distance;
  }

  [[nodiscard]] CellConfiguration measured() const {
    CellConfiguration q;
    for (const SimulatedArm& arm : arms_) q.push_back(arm.drive.q());
    return q;
  }

  const Cell& cell_;
  const EpisodeOptions& options_;
  VirtualTimeSearches::Scene search_scene_;
  world::BulletWorld world_;
  world::RayCaster caster_;
  std::vector<ArmPlanner> planners_;
  std::vector<SimulatedArm> arms_;
  std::uint64_t number_ = 0;  ///< of the last set-points
  ThreadPool threads_;
  EpisodeOutcome outcome_;
};

}  // namespace

EpisodeOutcome simulate_episode(const Cell& cell, const CellConfiguration& starts, const CellConfiguration& goals,
                                const EpisodeOptions& options) {
  return Episode(cell, starts, options).run(goals);
}

}  // namespace hecaton::planner
