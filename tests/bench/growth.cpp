#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include "planner/tick.hpp"
#include "tests/bench/benches.hpp"
#include "tests/bench/grid_cell.hpp"
#include "tests/bench/pairs_cell.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr double kPeriod = 0.002;  // 500 Hz [s]
constexpr int kPeriods = 1000;
constexpr int kMeasuredAlone = 20;  // every so many periods
constexpr double kWarmUp = 0.2;     // of the periods

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
  void measure_alone(std::span<const ArmObservation> arms, Timings& timings) {
    input.arms = arms;
    const TickMemory before = memory;
    TickResult result;
    timings.measure([&] { memory = before; }, [&] { result = tick(geometry, parameters, input, memory, scratch); });
    memory = before;
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
    const auto start = std::chrono::steady_clock::now();
    for (auto& planner : planners_) planner->step(observations_);
    const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - start;
    publish();
    return spent.count() / static_cast<double>(planners_.size());
  }

  void measure_alone(Timings& timings) {
    for (auto& planner : planners_) planner->measure_alone(observations_, timings);
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

}  // namespace

void run_growth(Output output) {
  std::vector<Row> rows;
  for (const int count : {3, 10, 30, 100}) {
    Cell cell(count);
    Row alone{Timings("tick of one of " + std::to_string(count) + " arms, on a core of its own"), nullptr};
    Row row{Timings("tick of one of " + std::to_string(count) + " arms, all on one core, mean of a period"), nullptr};
    double total = 0.0;
    for (int k = 0; k < kPeriods; ++k) {
      const double mean = cell.period();
      total += mean * count;
      if (k >= kWarmUp * kPeriods) row.ours.add(mean);
      if (k % kMeasuredAlone == 0) cell.measure_alone(alone.ours);
    }
    std::fprintf(stderr, "%3d arms: %.1f rows a tick, ticks of 1 s at %.0f Hz in %.3f s of one core\n", count,
                 cell.rows() / kPeriods, 1.0 / kPeriod, total * 1e-6 / (kPeriods * kPeriod));
    rows.push_back(std::move(alone));
    rows.push_back(std::move(row));
  }
  print(output, rows);
}

}  // namespace hecaton::bench
