#include <memory>

#include "planner/tick.hpp"
#include "tests/bench/grid_cell.hpp"
#include "tests/bench/pairs_cell.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr double kPeriod = 0.002;  // 500 Hz [s]
constexpr int kPeriods = 1000;
constexpr int kMeasuredAlone = 20;  // every so many periods
constexpr int kWarmUp = 200;        // periods

/// One arm that always goes somewhere.
struct Planner {
  Planner(const std::vector<Arm>& arms, int self)
      : geometry(arms, self),
        scratch(geometry),
        memory{LocalMemory(static_cast<std::uint64_t>(self) + 1)},
        random(static_cast<std::uint64_t>(self) + 1) {
    input.dt = kPeriod;
    input.q = JointVector::Zero(geometry.own_arm().model->joints());
    input.qd = input.q;
    input.has_goal = true;
    draw_goal();
  }

  /// Reaching forward, at the height where arms meet: neighbours get into each other's way.
  void draw_goal() {
    input.q_goal = input.q;
    for (double& angle : input.q_goal) angle = uniform(random, -1.5, 1.5);
    input.q_goal[0] = uniform(random, -3.0, 3.0);
    input.q_goal[1] = uniform(random, 0.3, 1.5);
  }

  /// The tick that comes next, timed as on a core of its own: with its data in that core's cache.
  double measure_alone(std::span<const ArmObservation> arms, Timings& timings) {
    input.arms = arms;
    const TickMemory before = memory;
    TickResult result;
    const double fastest =
        timings.measure([&] { memory = before; }, [&] { result = tick(geometry, parameters, input, memory, scratch); });
    memory = before;
    return fastest;
  }

  void step(std::span<const ArmObservation> arms) {
    input.arms = arms;
    const TickResult result = tick(geometry, parameters, input, memory, scratch);
    input.q = result.q;
    input.qd = result.qd;
    rows += result.rows;
    if (result.status == TickStatus::kReached || result.status == TickStatus::kBlocked) draw_goal();
  }

  CellGeometry geometry;
  LocalParameters parameters;
  TickScratch scratch;
  TickMemory memory;
  TickInput input;
  std::mt19937_64 random;
  long rows = 0;
};

/// A cell whose arms all tick on each other's last state, as fast as they can.
class Cell {
 public:
  explicit Cell(int count) : observations_(count) {
    const std::vector<Arm> arms = grid_of_arms(count);
    for (int i = 0; i < count; ++i) planners_.push_back(std::make_unique<Planner>(arms, i));
    publish();
  }

  /// One control period; the time that a tick took on average [µs].
  double period() {
    const double spent = time_once([&] {
      for (auto& planner : planners_) planner->step(observations_);
    });
    publish();
    return spent / static_cast<double>(planners_.size());
  }

  /// The mean of all arms' next ticks [µs].
  double measure_alone(Timings& timings) {
    double sum = 0.0;
    for (auto& planner : planners_) sum += planner->measure_alone(observations_, timings);
    return sum / static_cast<double>(planners_.size());
  }

  [[nodiscard]] double rows() const {
    long sum = 0;
    for (const auto& planner : planners_) sum += planner->rows;
    return static_cast<double>(sum) / static_cast<double>(planners_.size());
  }

 private:
  void publish() {
    for (std::size_t i = 0; i < planners_.size(); ++i) {
      observations_[i] = {planners_[i]->input.q, planners_[i]->input.qd, 0.0, true, true};
    }
  }

  std::vector<ArmObservation> observations_;
  std::vector<std::unique_ptr<Planner>> planners_;
};

/// All ticks of a period on one core, mean of the period; and how much of that core one second at 500 Hz takes.
void all_on_one_core(benchmark::State& state) {
  const int count = static_cast<int>(state.range(0));
  Cell cell(count);
  for (int k = 0; k < kWarmUp; ++k) cell.period();
  Timings ticks;
  for (auto _ : state) {
    const double mean = cell.period();
    ticks.add(mean);
    set_iteration_time(state, mean);
  }
  report(state, ticks);
  const auto periods = static_cast<double>(state.iterations());
  state.counters["rows"] = cell.rows() / (periods + kWarmUp);
  state.counters["core_use"] = ticks.total() * 1e-6 * count / (periods * kPeriod);
}

/// One arm's tick with its data in the cache of a core of its own, every so many periods.
void on_a_core_of_its_own(benchmark::State& state) {
  Cell cell(static_cast<int>(state.range(0)));
  Timings ticks;
  for (auto _ : state) {
    for (int k = 0; k < kMeasuredAlone; ++k) cell.period();
    set_iteration_time(state, cell.measure_alone(ticks));
  }
  report(state, ticks);
}

void cells(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("arms")->Arg(3)->Arg(10)->Arg(30)->Arg(100)->UseManualTime()->Unit(benchmark::kMicrosecond);
}

BENCHMARK(on_a_core_of_its_own)
    ->Name("growth/on_a_core_of_its_own")
    ->Iterations(kPeriods / kMeasuredAlone)
    ->Apply(cells);
BENCHMARK(all_on_one_core)->Name("growth/all_on_one_core")->Iterations(kPeriods)->Apply(cells);

}  // namespace
}  // namespace hecaton::bench
