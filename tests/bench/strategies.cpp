#include "planner/local/random.hpp"
#include "planner/strategy_search/search.hpp"
#include "services/config/cell_file.hpp"
#include "tests/bench/fcl_peer.hpp"
#include "tests/bench/run_benchmarks.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

Cell scorbots(const std::string& problem) {
  return config::load_cell_file(HECATON_SOURCE_DIR "/deploy/cells/scorbot_" + problem + ".yaml").cell;
}

/// FCL's distances of one arm to all others and to the tables, as the cost of a step without self-pairs.
class FclStep {
 public:
  explicit FclStep(const Cell& cell) : cell_(cell), geometry_(arms_of(cell), 0) {
    geometry_.set_obstacles(cell.scene.obstacles);
    peer_ = std::make_unique<FclPeer>(geometry_);
    for (const world::Obstacle& obstacle : cell.scene.obstacles) {
      now_.obstacles.push_back({obstacle.X_WO, {}, 0.0});
    }
    now_.kinematics.resize(cell.arms.size());
  }
  /// Arms anywhere between their first two areas.
  void draw(Random& random) {
    now_.q.clear();
    for (std::size_t i = 0; i < cell_.arms.size(); ++i) {
      const Arm& arm = cell_.arms[i].arm;
      const std::vector<std::string>& areas = cell_.tasks.problem.areas.at(arm.name);
      const JointVector& from = arm.named.at(areas[0]);
      now_.q.push_back(from + random.uniform() * (arm.named.at(areas[1]) - from));
      forward_kinematics(*arm.model, arm.X_WB, now_.q.back(), now_.kinematics[i]);
    }
  }
  void run() { peer_->distances(0, now_, distances_); }

 private:
  const Cell& cell_;
  CellGeometry geometry_;
  std::unique_ptr<FclPeer> peer_;
  Instant now_;
  std::vector<double> distances_;
};

struct Sums {
  Timings strategies;   ///< each strategy's evaluation, processor time [µs]
  double before = 0.0;  ///< common preparation [µs]
  std::uint64_t ticks = 0;
  std::vector<SystemStrategy> faultless;
};

Sums run_round(const StrategyProblem& problem, const std::vector<SystemStrategy>& candidates, int tasks_each,
               std::uint64_t seed) {
  Sums sums;
  TaskSet tasks;
  sums.before = processor_time_once([&] {
    tasks = problem.draw(seed, tasks_each);
    problem.precheck_paths(tasks);
  });
  for (const SystemStrategy& candidate : candidates) {
    show_progress(static_cast<double>(&candidate - candidates.data()), static_cast<double>(candidates.size()),
                  "strategies");
    Evaluation evaluation;
    sums.strategies.add(
        processor_time_once([&] { evaluation = evaluate(problem, tasks, candidate, {.stop_at_fault = true}); }));
    sums.ticks += evaluation.arm_ticks;
    if (evaluation.all_faults() == 0) sums.faultless.push_back(candidate);
  }
  return sums;
}

/// R3 and P6: the grid of a problem, 300 tasks of each arm until the first fault; then two sets of 1800 for those
/// without.
void strategies(benchmark::State& state, const std::string& name, bool confirm) {
  const Cell cell = scorbots(name);
  const StrategyProblem problem(cell);
  const std::vector<SystemStrategy> grid = StrategyGrid{}.of(problem);
  std::vector<SystemStrategy> candidates = confirm ? run_round(problem, grid, 300, 1).faultless : grid;
  FclStep step(cell);
  Random random(2002);
  Timings fcl;
  for (auto _ : state) {
    Timings all;
    std::uint64_t ticks = 0;
    std::vector<SystemStrategy> left = candidates;
    double total = 0.0;
    for (int set = 0; set < (confirm ? 2 : 1); ++set) {
      Sums sums = run_round(problem, left, confirm ? 1800 : 300, confirm ? 2 + set : 1);
      left = std::move(sums.faultless);
      ticks += sums.ticks;
      total += sums.before + sums.strategies.total();
      all = std::move(sums.strategies);
    }
    for (int k = 0; k < 2000; ++k) {
      step.draw(random);
      fcl.measure([&] { step.run(); });
    }
    set_iteration_time(state, total);
    report(state, all);
    const double tick_us = total / static_cast<double>(ticks);
    state.counters["total_s"] = 1e-6 * total;
    state.counters["faultless"] = static_cast<double>(left.size());
    state.counters["ticks_per_s"] = 1e6 / tick_us;
    state.counters["tick_us"] = tick_us;
    state.counters["fcl_us"] = fcl.percentile(0.5);
    state.counters["ratio"] = fcl.percentile(0.5) / tick_us;
  }
}

BENCHMARK_CAPTURE(strategies, screening_2a, "2a", false)->Iterations(1)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(strategies, confirmation_2a, "2a", true)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
