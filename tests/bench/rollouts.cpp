#include <array>

#include "planner/rollout/rollout_simulation.hpp"
#include "tests/bench/fcl_peer.hpp"
#include "tests/bench/pairs_cell.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr double kPeriod = 0.010;  // [s]
constexpr int kSteps = 300;        // of a rollout
constexpr int kRollouts = 100;
constexpr int kWarmUp = 5;

/// Three arms with random goals.
std::array<RolloutArm, 3> draw_arms(PairsCell& cell) {
  const Instant from = cell.draw();
  const Instant to = cell.draw();
  std::array<RolloutArm, 3> arms;
  for (int i = 0; i < 3; ++i) {
    arms[i].q = from.q[i];
    arms[i].qd = JointVector::Zero(6);
    arms[i].q_goal = to.q[i];
    arms[i].has_goal = arms[i].plans = true;
  }
  return arms;
}

/// The cell at the end of a rollout.
Instant instant_of(const RolloutSimulation& simulation, const CellGeometry& geometry,
                   std::span<const world::ObstacleState> obstacles) {
  Instant now;
  for (int i = 0; i < simulation.arms(); ++i) {
    const Arm& arm = geometry.arms()[i];
    forward_kinematics(*arm.model, arm.X_WB, simulation.arm(i).q, now.kinematics.emplace_back());
  }
  now.obstacles.assign(obstacles.begin(), obstacles.end());
  return now;
}

/// The mean tick of rollouts of three arms, one after the other on one core; beside it FCL's pass over all pairs of an
/// arm where each rollout has led.
void rollouts(benchmark::State& state, bool among_boxes) {
  PairsCell cell(20060521);
  RolloutSimulation simulation(cell.geometry().arms(), std::vector<LocalParameters>(3), kPeriod);
  const std::size_t boxes = among_boxes ? cell.obstacles().size() : 0;
  simulation.set_obstacles(std::span(cell.obstacles()).first(boxes));
  CellGeometry geometry(cell.geometry().arms(), 0);
  geometry.set_obstacles(std::span(cell.obstacles()).first(boxes));
  FclPeer fcl(geometry);
  std::vector<double> theirs;
  Timings peer;
  std::vector<world::ObstacleState> states;
  const auto run = [&] {
    states = cell.draw().obstacles;
    simulation.begin(draw_arms(cell), std::span(states).first(boxes));
    return time_once([&] {
             for (int k = 0; k < kSteps; ++k) simulation.step();
           }) /
           (3.0 * kSteps);
  };
  for (int k = 0; k < kWarmUp; ++k) run();
  Timings ticks;
  for (auto _ : state) {
    const double tick = run();
    ticks.add(tick);
    set_iteration_time(state, tick);
    const Instant now = instant_of(simulation, geometry, std::span(states).first(boxes));
    peer.measure([&] { fcl.distances(0, now, theirs); });
  }
  report(state, ticks, peer);
  state.counters["ticks_per_s"] = 1e6 * static_cast<double>(state.iterations()) / ticks.total();
}

BENCHMARK_CAPTURE(rollouts, alone, false)->Iterations(kRollouts)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(rollouts, among_20_boxes, true)
    ->Iterations(kRollouts)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
