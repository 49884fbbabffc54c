#include "planner/tick.hpp"

#include <array>

#include "planner/local/goal_objective.hpp"
#include "planner/local/velocity_constraints.hpp"
#include "planner/local/velocity_damper.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "tests/bench/fcl_peer.hpp"
#include "tests/bench/journeys.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr int kTicks = 5000;
constexpr int kPeerEvery = 5;        // FCL's pass takes a hundred of ours
constexpr double kInfluence = 0.12;  // [m]

/// Runs `timed(journeys, timings)` at every tick of many journeys, and FCL's pass over all pairs in turns with it.
template <typename Timed>
void along_journeys(benchmark::State& state, Journeys& journeys, const Timed& timed) {
  FclPeer fcl(journeys.geometry());
  std::vector<double> theirs;
  Timings ours;
  Timings peer;
  double rows = 0.0;
  int count = 0;
  for (auto _ : state) {
    set_iteration_time(state, timed(ours));
    if (count++ % kPeerEvery == 0) peer.measure([&] { fcl.distances(0, journeys.instant(), theirs); });
    const TickResult result = journeys.tick();
    rows += result.rows;
    journeys.advance(result);
  }
  report(state, ours, peer);
  state.counters["rows"] = benchmark::Counter(rows, benchmark::Counter::kAvgIterations);
}

/// The whole tick.
void whole(benchmark::State& state, LinkShapes shapes) {
  Journeys journeys(shapes);
  along_journeys(state, journeys, [&](Timings& timings) {
    const TickMemory before = journeys.memory();
    const double fastest =
        timings.measure([&] { journeys.memory() = before; }, [&] { benchmark::DoNotOptimize(journeys.tick()); });
    journeys.memory() = before;
    return fastest;
  });
}

/// The parts of a tick, each on the tick's own input.
class Parts {
 public:
  explicit Parts(const Journeys& journeys)
      : journeys_(journeys),
        geometry_(journeys.geometry()),
        distance_(geometry_),
        kinematics_(geometry_.arms().size()) {
    for (const Arm& arm : geometry_.arms()) stop_times_.push_back(longest_stop_time(arm.limits));
  }

  void kinematics() {
    const TickInput& input = journeys_.input();
    for (std::size_t i = 0; i < kinematics_.size(); ++i) {
      const Arm& arm = geometry_.arms()[i];
      forward_kinematics(*arm.model, arm.X_WB, i == 0 ? input.q : input.arms[i].q, kinematics_[i]);
    }
  }

  void distances() {
    const CellPoses poses{kinematics_.data(), kinematics_, journeys_.input().obstacles};
    near_count_ = distance_.clearances(poses, {kInfluence, 0.0, {}}, near_);
  }

  void rows() {
    const TickInput& input = journeys_.input();
    const DamperScene scene{geometry_,   kinematics_[0],  input.qd, input.tracking_error, kinematics_, input.arms,
                            stop_times_, input.obstacles, input.dt, journeys_.parameters};
    for (int k = 0; k < near_count_; ++k) rows_[k] = velocity_damper(scene, near_[k]);
  }

  void programme() {
    const TickInput& input = journeys_.input();
    const JointLimits& limits = geometry_.own_arm().limits;
    const VelocityBounds bounds = speed_and_position_bounds(limits, input.q, input.dt);
    problem_.rows = 0;
    problem_.lower = bounds.lower;
    problem_.upper = bounds.upper;
    problem_.target = goal_velocity(limits, input.q, input.q_goal, input.dt);
    for (int k = 0; k < near_count_; ++k) problem_.add_row(rows_[k].g, rows_[k].h, rows_[k].key);
    solution_ = solve(problem_, warm_);
  }

 private:
  const Journeys& journeys_;
  const CellGeometry& geometry_;
  ExactDistance distance_;
  std::vector<Kinematics> kinematics_;
  std::vector<double> stop_times_;
  std::array<Clearance, kMaxRows> near_;
  int near_count_ = 0;
  std::array<Row, kMaxRows> rows_;
  QpProblem problem_;
  QpWarmStart warm_;
  QpSolution solution_;
};

/// One part of the tick, after the parts before it ran untimed.
void part(benchmark::State& state, LinkShapes shapes, void (Parts::*timed)()) {
  Journeys journeys(shapes);
  Parts parts(journeys);
  along_journeys(state, journeys, [&](Timings& timings) {
    for (const auto before : {&Parts::kinematics, &Parts::distances, &Parts::rows}) {
      if (before == timed) break;
      (parts.*before)();
    }
    return timings.measure([&] { (parts.*timed)(); });
  });
}

/// Two readings of the clock, which every figure includes.
void clock(benchmark::State& state) {
  Timings timings;
  for (auto _ : state) set_iteration_time(state, timings.measure([] {}));
  report(state, timings);
}

[[maybe_unused]] const bool registered = [] {
  const auto add = [](const std::string& name, auto function, auto... arguments) {
    benchmark::RegisterBenchmark(("tick/" + name).c_str(), function, arguments...)
        ->Iterations(kTicks)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  };
  for (const auto& [name, shapes] :
       {std::pair<std::string, LinkShapes>{"capsules", LinkShapes::kFast}, {"cylinders", LinkShapes::kExact}}) {
    add(name, whole, shapes);
    add(name + "/kinematics_of_three_arms", part, shapes, &Parts::kinematics);
    add(name + "/distances_within_0.12_m", part, shapes, &Parts::distances);
    add(name + "/rows_of_its_pairs", part, shapes, &Parts::rows);
    add(name + "/quadratic_programme", part, shapes, &Parts::programme);
  }
  add("clock", clock);
  return true;
}();

}  // namespace
}  // namespace hecaton::bench
