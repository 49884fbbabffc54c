#include "planner/simulation/cell_simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include "planner/rollout/rollout_policy.hpp"
#include "planner/simulation/arm_bodies.hpp"
#include "planner/simulation/range_scanner.hpp"

namespace hecaton::planner {
namespace {

/// All arms blocked for this long: nothing will change any more unless an obstacle moves away [s].
constexpr double kHopeless = 10.0;

/// What this thread has had of the processor so far [µs].
double processor_us() {
  timespec spent;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &spent);
  return 1e6 * static_cast<double>(spent.tv_sec) + 1e-3 * static_cast<double>(spent.tv_nsec);
}

using ObstacleStates = std::vector<world::ObstacleState>;

class Episode {
 public:
  Episode(const Cell& cell, const CellConfiguration& starts, const EpisodeOptions& options)
      : cell_(cell), options_(options), world_(cell.scene, all_bodies(cell)) {
    const int n = static_cast<int>(cell.arms.size());
    world_.set_time(options.world_time);
    std::vector<Arm> arms;
    std::vector<LocalParameters> parameters;
    for (const PlannedArm& planned : cell.arms) {
      arms.push_back(planned.arm);
      parameters.push_back(planned.parameters);
    }
    Random random(options.seed);
    for (int i = 0; i < n; ++i) {
      controllers_.emplace_back(CellGeometry(arms, i), cell.arms[i].parameters, cell.timing.control_period,
                                random.next());
      controllers_.back().set_obstacles(cell.scene.obstacles);
      policies_.emplace_back(cell.arms[i].parameters, random.next());
      searches_.emplace_back(arms, parameters, i);
      searches_.back().set_obstacles(cell.scene.obstacles);
      drives_.emplace_back(cell.arms[i].arm.limits, starts[i], cell.timing.command_timeout);
      auto& row = channels_.emplace_back();
      for (int from = 0; from < n; ++from) row.emplace_back(options.network, random.next());
      obstacle_channels_.emplace_back(options.network, random.next());
    }
    for (const PlannedArm& planned : cell.arms) scanners_.emplace_back(planned, random.next());
    caster_.set_obstacles(world_.obstacles());
    outcome_.arms.resize(n);
    results_.resize(n);
    chatter_.resize(n);
    observations_.resize(n);
    publish_measured();
  }

  EpisodeOutcome run(const CellConfiguration& goals) {
    for (std::size_t i = 0; i < controllers_.size(); ++i) controllers_[i].set_goal(goals[i]);
    const double dt = cell_.timing.control_period;
    const auto periods = static_cast<long>(std::llround(cell_.tasks.time_limit / dt));
    double hopeless_for = 0.0;
    for (long period = 0; period < periods; ++period) {
      const double now = static_cast<double>(period) * dt;
      plan(now);
      move(dt);
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
    for (const RolloutSearch& search : searches_) outcome_.rollout_ticks += search.ticks();
    outcome_.referee = world_.referee().report();
    return outcome_;
  }

 private:
  static std::vector<world::ArmBodies> all_bodies(const Cell& cell) {
    std::vector<world::ArmBodies> bodies;
    for (const PlannedArm& planned : cell.arms) bodies.push_back(arm_bodies(planned.arm));
    return bodies;
  }

  /// Every arm and the world publish, then every planner ticks on what has reached it: nobody sees the others' next
  /// move. A planner runs beside its own arm's driver: between these two there is no network.
  void plan(double now) {
    const int n = static_cast<int>(controllers_.size());
    const world::ObstacleSnapshot snapshot = world_.snapshot();
    for (int to = 0; to < n; ++to) {
      for (int from = 0; from < n; ++from) {
        if (from != to) channels_[to][from].send(now, own_state(from));
      }
      obstacle_channels_[to].send(now, snapshot.states);
    }
    for (int i = 0; i < n; ++i) {
      listen(i, now);
      // A planner runs beside its own arm's sensors, too.
      for (const RangeScan& scan : scanners_[i].scan(now, drives_[i].q(), caster_, snapshot.states)) {
        controllers_[i].sense(scan);
      }
      policies_[i].prepare(controllers_[i]);
      const auto before = std::chrono::steady_clock::now();
      results_[i] = controllers_[i].step(MeasuredState{drives_[i].q(), drives_[i].qd()}, observations_, obstacles_,
                                         !obstacle_channels_[i].known() && controllers_[i].cspace() == nullptr);
      const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - before;
      if (options_.times != nullptr) {
        options_.times->tick_us.push_back(spent.count());
        options_.times->rollout_us -= processor_us();
      }
      think(i, obstacles_);
      if (options_.times != nullptr) options_.times->rollout_us += processor_us();
      drives_[i].command(results_[i].q, results_[i].qd, cell_.timing.control_period);
      ++outcome_.ticks;
    }
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
            controllers_[arm].claim()};
  }

  /// A period's share of the rollouts that a planner runs beside its ticks.
  void think(int i, std::span<const world::ObstacleState> obstacles) {
    const RolloutParameters& rollout = cell_.arms[i].parameters.rollout;
    if (rollout.candidates == 0) return;
    if (auto question = policies_[i].next(controllers_[i], results_[i], observations_, obstacles)) {
      searches_[i].begin(std::move(*question));
    } else if (searches_[i].busy()) {
      if (const auto answer = searches_[i].advance(rollout.ticks_per_period)) {
        policies_[i].answered();
        controllers_[i].begin(answer->manoeuvre);
        ++outcome_.arms[i].rollouts;
      }
    }
  }

  /// What planner `to` knows now, with the ages that it can tell: from the senders' spacing and its own clock.
  void listen(int to, double now) {
    for (int from = 0; from < static_cast<int>(controllers_.size()); ++from) {
      StateChannel<ArmObservation>& channel = channels_[to][from];
      if (from == to) continue;
      channel.receive(now);
      observations_[from] = channel.newest();
      if (channel.known()) observations_[from].age = channel.age(now);
    }
    StateChannel<ObstacleStates>& channel = obstacle_channels_[to];
    channel.receive(now);
    obstacles_ = channel.known() ? channel.newest() : ObstacleStates(cell_.scene.obstacles.size());
    for (world::ObstacleState& obstacle : obstacles_) obstacle.age = channel.known() ? channel.age(now) : 0.0;
  }

  void move(double dt) {
    const int steps = std::max(1, static_cast<int>(std::lround(dt / cell_.timing.driver_period)));
    for (ArmModel& drive : drives_) {
      for (int k = 0; k < steps; ++k) drive.step(dt / steps);
    }
    publish_measured();
    world_.step(dt);
  }

  void publish_measured() {
    for (int i = 0; i < static_cast<int>(drives_.size()); ++i) {
      set_measured(world_, i, cell_.arms[i].arm, drives_[i].q(), kinematics_);
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

  [[nodiscard]] CellConfiguration measured() const {
    CellConfiguration q;
    for (const ArmModel& drive : drives_) q.push_back(drive.q());
    return q;
  }

  const Cell& cell_;
  const EpisodeOptions& options_;
  world::BulletWorld world_;
  std::vector<ArmController> controllers_;
  std::vector<RolloutPolicy> policies_;
  std::vector<RolloutSearch> searches_;
  std::vector<ArmModel> drives_;
  std::vector<std::vector<StateChannel<ArmObservation>>> channels_;  ///< [receiver][sender]
  std::vector<StateChannel<ObstacleStates>> obstacle_channels_;      ///< [receiver]
  std::vector<ArmObservation> observations_;
  ObstacleStates obstacles_;
  std::vector<TickResult> results_;
  std::vector<ChatterCounter> chatter_;
  world::RayCaster caster_;
  std::vector<RangeScanner> scanners_;
  Kinematics kinematics_;
  EpisodeOutcome outcome_;
};

}  // namespace

EpisodeOutcome simulate_episode(const Cell& cell, const CellConfiguration& starts, const CellConfiguration& goals,
                                const EpisodeOptions& options) {
  return Episode(cell, starts, options).run(goals);
}

}  // namespace hecaton::planner
