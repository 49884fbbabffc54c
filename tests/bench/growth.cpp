#include <memory>

#include "planner/tick.hpp"
#include "tests/bench/fcl_peer.hpp"
#include "tests/bench/grid_cell.hpp"
#include "tests/bench/pairs_cell.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr double kPeriod = 0.002;  // 500 Hz [s]
constexpr int kPeriods = 1000;
constexpr int kMeasuredAlone = 20;   // every so many periods
constexpr int kWarmUp = 200;         // periods
constexpr int kPeerEvery = 50;       // periods
constexpr double kInfluence = 0.12;  // of the peer's broad phase [m]; a tick's own depends on what may happen

/// One arm that always has a goal.
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

  /// Positions in front of the arm, at the height where arms meet, so that neighbours block each other.
  void draw_goal() {
    input.q_goal = input.q;
    for (double& angle : input.q_goal) angle = uniform(random, -1.5, 1.5);
    input.q_goal[0] = uniform(random, -3.0, 3.0);
    input.q_goal[1] = uniform(random, 0.3, 1.5);
  }

  /// The next tick, timed with its data in the cache, as on a core of its own.
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

/// A cell in which all arms tick on each other's last state, without waiting.
class Cell {
 public:
  explicit Cell(int count) : observations_(count) {
    const std::vector<Arm> arms = grid_of_arms(count);
    for (int i = 0; i < count; ++i) planners_.push_back(std::make_unique<Planner>(arms, i));
    publish();
  }

  /// One control period. Returns the mean time of a tick [µs].
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

  [[nodiscard]] int arms() const { return static_cast<int>(planners_.size()); }
  [[nodiscard]] const CellGeometry& geometry() const { return planners_.front()->geometry; }

  [[nodiscard]] Instant instant() const {
    Instant now;
    for (const auto& planner : planners_) {
      const Arm& arm = planner->geometry.own_arm();
      forward_kinematics(*arm.model, arm.X_WB, planner->input.q, now.kinematics.emplace_back());
    }
    return now;
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

/// Time of FCL for the distances of one arm to all others, for each arm in turn.
class Peer {
 public:
  explicit Peer(const Cell& cell) : cell_(cell), fcl_(cell.geometry()) {}

  void measure() {
    const int arm = next_++ % cell_.arms();
    const Instant now = cell_.instant();
    pairs_.measure([&] { fcl_.distances(arm, now, distances_); });
    tree_.measure([&] { fcl_.distances_by_tree(arm, now, kInfluence, distances_); });
  }

  /// Called between ticks.
  void report(benchmark::State& state, const Timings& ticks) const {
    bench::report(state, ticks, pairs_);
    state.counters["tree_p50_us"] = tree_.percentile(0.5);
    state.counters["tree_ratio"] = tree_.percentile(0.5) / ticks.percentile(0.5);
  }

 private:
  const Cell& cell_;
  FclPeer fcl_;
  int next_ = 0;
  std::vector<double> distances_;
  Timings pairs_;  ///< of all pairs, one by one
  Timings tree_;   ///< of those within the influence distance
};

/// All ticks of a period on one core, mean of the period; and how much of that core one second at 500 Hz takes.
void all_on_one_core(benchmark::State& state) {
  const int count = static_cast<int>(state.range(0));
  Cell cell(count);
  for (int k = 0; k < kWarmUp; ++k) cell.period();
  Peer peer(cell);
  Timings ticks;
  int period = 0;
  for (auto _ : state) {
    const double mean = cell.period();
    ticks.add(mean);
    set_iteration_time(state, mean);
    if (period++ % kPeerEvery == 0) peer.measure();
  }
  peer.report(state, ticks);
  const auto periods = static_cast<double>(state.iterations());
  state.counters["rows"] = cell.rows() / (periods + kWarmUp);
  state.counters["core_use"] = ticks.total() * 1e-6 * count / (periods * kPeriod);
}

/// One arm's tick with its data in the cache of a core of its own, every so many periods.
void on_a_core_of_its_own(benchmark::State& state) {
  Cell cell(static_cast<int>(state.range(0)));
  Peer peer(cell);
  Timings ticks;
  for (auto _ : state) {
    for (int k = 0; k < kMeasuredAlone; ++k) cell.period();
    set_iteration_time(state, cell.measure_alone(ticks));
    peer.measure();
  }
  peer.report(state, ticks);
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
