#include "planner/simulation/cell_simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>
#include <optional>

#include "planner/rollout/rollout_policy.hpp"
#include "planner/route/composite_policy.hpp"
#include "planner/route/route_policy.hpp"
#include "planner/simulation/arm_bodies.hpp"
#include "planner/simulation/cell_news.hpp"
#include "planner/simulation/crew.hpp"
#include "planner/simulation/range_scanner.hpp"

namespace hecaton::planner {
namespace {

/// All arms blocked for this long: nothing will change any more unless an obstacle moves away [s].
constexpr double kHopeless = 10.0;
/// Configurations that a planner's second thread looks at in a control period, in a search for a route: a third of a
/// microsecond each, and it shares its processor.
constexpr std::uint64_t kChecksPerPeriod = 10'000;
/// So that a thread has some 50 µs of ticks to do: a choice, of the order of what waking it costs.
constexpr int kArmsPerThread = 10;

int threads_worth(int threads, int arms) {
  return std::clamp(arms / kArmsPerThread, 1, std::max(1, threads));
}

double microseconds_since(std::chrono::steady_clock::time_point then) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - then).count();
}

/// What this thread has had of the processor so far [µs].
double processor_us() {
  timespec spent;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &spent);
  return 1e6 * static_cast<double>(spent.tv_sec) + 1e-3 * static_cast<double>(spent.tv_nsec);
}

class Episode {
 public:
  Episode(const Cell& cell, const CellConfiguration& starts, const EpisodeOptions& options)
      : cell_(cell),
        options_(options),
        world_(cell.scene, all_bodies(cell)),
        crew_(threads_worth(options.threads, static_cast<int>(cell.arms.size())), static_cast<int>(cell.arms.size())) {
    const int n = static_cast<int>(cell.arms.size());
    world_.set_time(options.world_time);
    for (const PlannedArm& planned : cell.arms) {
      arms_.push_back(planned.arm);
      parameters_.push_back(planned.parameters);
    }
    Random random(options.seed);
    for (int i = 0; i < n; ++i) {
      controllers_.emplace_back(CellGeometry(arms_, i), parameters_[i], cell.timing.control_period, random.next());
      controllers_.back().set_obstacles(cell.scene.obstacles);
      policies_.emplace_back(parameters_[i], random.next());
      routes_.emplace_back(RoutePolicy(parameters_[i], options.seed + static_cast<std::uint64_t>(i)));
      companies_.emplace_back(CompositePolicy(parameters_[i], options.seed + static_cast<std::uint64_t>(i)));
      drives_.emplace_back(arms_[i].limits, starts[i], cell.timing.command_timeout);
      news_.emplace_back(options.network, i, n, static_cast<int>(cell.scene.obstacles.size()), random);
    }
    for (const PlannedArm& planned : cell.arms) scanners_.emplace_back(planned, random.next());
    caster_.set_obstacles(world_.obstacles());
    outcome_.arms.resize(n);
    searches_.resize(n);
    results_.resize(n);
    kinematics_.resize(n);
    spent_.resize(n);
    chatter_.resize(n);
    for (int i = 0; i < n; ++i) measure(i);
    publish_measured();
  }

  EpisodeOutcome run(const CellConfiguration& goals) {
    for (std::size_t i = 0; i < controllers_.size(); ++i) controllers_[i].set_goal(goals[i]);
    const double dt = cell_.timing.control_period;
    const auto periods = static_cast<long>(std::llround(cell_.tasks.time_limit / dt));
    double hopeless_for = 0.0;
    const auto began = std::chrono::steady_clock::now();
    for (long period = 0; period < periods; ++period) {
      const double now = static_cast<double>(period) * dt;
      plan_and_move(now, dt);
      world_.step(dt);
      outcome_.duration = now + dt;
      record(outcome_.duration);
      if (options_.observe) options_.observe(outcome_.duration, measured(), controllers_);
      if (all_reached()) break;
      const bool all_blocked = std::all_of(results_.begin(), results_.end(), [](const TickResult& result) {
        return result.status == TickStatus::kBlocked || result.status == TickStatus::kReached;
      });
      hopeless_for = all_blocked ? hopeless_for + dt : 0.0;
      if (hopeless_for > kHopeless) {
        declare_blocked();
        break;
      }
    }
    if (options_.times != nullptr) options_.times->run_us += microseconds_since(began);
    declare_hopeless();
    for (const auto& search : searches_) outcome_.rollout_ticks += search ? search->ticks() : 0;
    outcome_.referee = world_.referee().report();
    return outcome_;
  }

 private:
  static std::vector<world::ArmBodies> all_bodies(const Cell& cell) {
    std::vector<world::ArmBodies> bodies;
    for (const PlannedArm& planned : cell.arms) bodies.push_back(arm_bodies(planned.arm));
    return bodies;
  }

  /// What one arm's planner took in a period [µs].
  struct Spent {
    double tick = 0.0;     ///< on the machine's clock
    double rollout = 0.0;  ///< of the processor
  };

  /// Every arm and the world publish, then every planner ticks on what has reached it, and its drive follows: nobody
  /// sees the others' next move, so that it does not matter who is first.
  void plan_and_move(double now, double dt) {
    auto instant = std::make_shared<CellInstant>();
    for (std::size_t i = 0; i < controllers_.size(); ++i) instant->arms.push_back(own_state(static_cast<int>(i)));
    instant->obstacles = world_.snapshot().states;
    crew_.for_each([&](int i) {
      news_[i].hear(now, instant);
      plan(i, now, instant->obstacles);
      move(i, dt);
    });
    publish_measured();
    outcome_.ticks += controllers_.size();
    if (options_.times == nullptr) return;
    for (const Spent& spent : spent_) {
      options_.times->tick_us.push_back(spent.tick);
      options_.times->rollout_us += spent.rollout;
    }
  }

  /// A planner runs beside its own arm's driver and sensors: between these there is no network.
  void plan(int i, double now, std::span<const world::ObstacleState> in_sight) {
    for (const RangeScan& scan : scanners_[i].scan(now, drives_[i].q(), caster_, in_sight)) controllers_[i].sense(scan);
    policies_[i].prepare(controllers_[i]);
    const auto before = std::chrono::steady_clock::now();
    const bool hold = !news_[i].knows_obstacles() && controllers_[i].guide() == nullptr;
    results_[i] = controllers_[i].step(MeasuredState{drives_[i].q(), drives_[i].qd()}, news_[i].arms(),
                                       news_[i].obstacles(), hold);
    spent_[i].tick = microseconds_since(before);
    const bool timed = options_.times != nullptr;
    const double thinks_from = timed ? processor_us() : 0.0;
    think(i);
    plan_route(i, now);
    if (timed) spent_[i].rollout = processor_us() - thinks_from;
    drives_[i].command(results_[i].q, results_[i].qd, cell_.timing.control_period);
  }

  [[nodiscard]] ArmObservation own_state(int arm) const {
    const auto& goal = controllers_[arm].goal();
    return {drives_[arm].q(),
            drives_[arm].qd(),
            0.0,
            true,
            true,
            controllers_[arm].under_way(),
            goal.value_or(JointVector()),
            controllers_[arm].claim(),
            {},
            companies_[arm].policy.progress(),
            companies_[arm].policy.proposal()};
  }

  /// A period's share of the rollouts that a planner runs beside its ticks.
  void think(int i) {
    const RolloutParameters& rollout = parameters_[i].rollout;
    if (rollout.candidates == 0) return;
    if (auto question = policies_[i].next(controllers_[i], results_[i], news_[i].arms(), news_[i].obstacles())) {
      if (!searches_[i]) {  // most arms of a large cell never ask
        searches_[i] = std::make_unique<RolloutSearch>(arms_, parameters_, i);
        searches_[i]->set_obstacles(cell_.scene.obstacles);
      }
      searches_[i]->begin(std::move(*question));
    } else if (searches_[i] && searches_[i]->busy()) {
      if (const auto answer = searches_[i]->advance(rollout.ticks_per_period)) {
        policies_[i].answered();
        controllers_[i].begin(answer->manoeuvre);
        ++outcome_.arms[i].rollouts;
      }
    }
  }

  /// Policies that ask for ways, whose answers come when the configurations that they took could have been looked at.
  template <class Policy>
  struct Asking {
    explicit Asking(Policy asks) : policy(std::move(asks)) {}
    Policy policy;
    std::unique_ptr<RouteSearch> search;  ///< null until the first question
    std::optional<RouteAnswer> answer;    ///< known to the arm `at` this time [s]
    double at = 0.0;
  };

  void plan_route(int i, double now) {
    ArmController& controller = controllers_[i];
    ask(companies_[i], i, now, [&](const RouteAnswer& answer) { companies_[i].policy.answered(answer); });
    outcome_.arms[i].composites = companies_[i].policy.proposed();
    if (companies_[i].policy.takes_part()) {
      routes_[i].policy.drop();
      return;
    }
    ask(routes_[i], i, now, [&](const RouteAnswer& answer) { routes_[i].policy.answered(answer, controller); });
    outcome_.arms[i].routes = routes_[i].policy.found();
  }

  template <class Policy, class Answered>
  void ask(Asking<Policy>& asking, int i, double now, const Answered& answered) {
    if (asking.answer && now >= asking.at) {
      answered(*asking.answer);
      asking.answer.reset();
    }
    const auto question = asking.policy.next(controllers_[i], results_[i], news_[i].arms(), news_[i].obstacles());
    if (!question) return;
    if (!asking.search) {
      asking.search = std::make_unique<RouteSearch>(arms_, parameters_, i);
      asking.search->set_obstacles(cell_.scene.obstacles);
    }
    asking.answer = asking.search->answer(*question);
    const auto periods = static_cast<double>(1 + asking.answer->checks / kChecksPerPeriod);
    asking.at = now + (periods - 0.5) * cell_.timing.control_period;
  }

  void move(int i, double dt) {
    const int steps = std::max(1, static_cast<int>(std::lround(dt / cell_.timing.driver_period)));
    for (int k = 0; k < steps; ++k) drives_[i].step(dt / steps);
    measure(i);
  }

  void measure(int i) { forward_kinematics(*arms_[i].model, arms_[i].X_WB, drives_[i].q(), kinematics_[i]); }

  void publish_measured() {
    for (int i = 0; i < static_cast<int>(kinematics_.size()); ++i) {
      const Kinematics& at = kinematics_[i];
      world_.set_arm(i, std::span<const Pose>(at.X_WL).first(at.links), at.X_WT);
    }
  }

  void record(double now) {
    for (std::size_t i = 0; i < results_.size(); ++i) {
      ArmOutcome& arm = outcome_.arms[i];
      arm.redraws = results_[i].redraws;
      arm.relaxed_ticks += results_[i].relaxed ? 1 : 0;
      arm.yielding_ticks += results_[i].yields_to >= 0 ? 1 : 0;
      chatter_[i].add(results_[i].qd, cell_.arms[i].arm.limits, results_[i].near, cell_.timing.control_period);
      arm.chatter = chatter_[i].total();
      const bool reached = results_[i].status == TickStatus::kReached;
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

  /// Who had not come nearer for long when its time was over found no way.
  void declare_hopeless() {
    for (std::size_t i = 0; i < controllers_.size(); ++i) {
      ArmOutcome& arm = outcome_.arms[i];
      if (arm.outcome == TaskOutcome::kTimedOut && controllers_[i].approach().hopeless()) {
        arm.outcome = TaskOutcome::kBlocked;
      }
    }
  }

  [[nodiscard]] CellConfiguration measured() const {
    CellConfiguration q;
    for (const ArmModel& drive : drives_) q.push_back(drive.q());
    return q;
  }

  const Cell& cell_;
  const EpisodeOptions& options_;
  world::BulletWorld world_;
  world::RayCaster caster_;
  std::vector<Arm> arms_;
  std::vector<LocalParameters> parameters_;
  std::vector<ArmController> controllers_;
  std::vector<RolloutPolicy> policies_;
  std::vector<std::unique_ptr<RolloutSearch>> searches_;  ///< null until the first question
  std::vector<Asking<RoutePolicy>> routes_;
  std::vector<Asking<CompositePolicy>> companies_;
  std::vector<ArmModel> drives_;
  std::vector<CellNews> news_;
  std::vector<RangeScanner> scanners_;
  std::vector<Kinematics> kinematics_;  ///< as measured
  std::vector<TickResult> results_;
  std::vector<Spent> spent_;  ///< in the last period
  std::vector<ChatterCounter> chatter_;
  Crew crew_;
  EpisodeOutcome outcome_;
};

}  // namespace

EpisodeOutcome simulate_episode(const Cell& cell, const CellConfiguration& starts, const CellConfiguration& goals,
                                const EpisodeOptions& options) {
  return Episode(cell, starts, options).run(goals);
}

}  // namespace hecaton::planner
