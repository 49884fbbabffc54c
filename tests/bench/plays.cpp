#include <array>

#include "planner/rollout/played_cell.hpp"
#include "tests/bench/fcl_peer.hpp"
#include "tests/bench/pairs_cell.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr double kPeriod = 0.010;  // [s]
constexpr int kSteps = 300;        // of a play
constexpr int kPlays = 100;
constexpr int kWarmUp = 5;

/// Three arms that all go somewhere.
std::array<PlayedArm, 3> draw_arms(PairsCell& cell) {
  const Instant from = cell.draw();
  const Instant to = cell.draw();
  std::array<PlayedArm, 3> arms;
  for (int i = 0; i < 3; ++i) {
    arms[i].q = from.q[i];
    arms[i].qd = JointVector::Zero(6);
    arms[i].q_goal = to.q[i];
    arms[i].has_goal = arms[i].plans = true;
  }
  return arms;
}

/// Where a play has led.
Instant instant_of(const PlayedCell& played, const CellGeometry& geometry,
                   std::span<const world::ObstacleState> obstacles) {
  Instant now;
  for (int i = 0; i < played.arms(); ++i) {
    const Arm& arm = geometry.arms()[i];
    forward_kinematics(*arm.model, arm.X_WB, played.arm(i).q, now.kinematics.emplace_back());
  }
  now.obstacles.assign(obstacles.begin(), obstacles.end());
  return now;
}

/// The mean tick of plays of three arms, one after the other on one core; beside it FCL's pass over all pairs of an arm
/// where each play has led.
void plays(benchmark::State& state, bool among_boxes) {
  PairsCell cell(20060521);
  PlayedCell played(cell.geometry().arms(), std::vector<LocalParameters>(3), kPeriod);
  const std::size_t boxes = among_boxes ? cell.obstacles().size() : 0;
  played.set_obstacles(std::span(cell.obstacles()).first(boxes));
  CellGeometry geometry(cell.geometry().arms(), 0);
  geometry.set_obstacles(std::span(cell.obstacles()).first(boxes));
  FclPeer fcl(geometry);
  std::vector<double> theirs;
  Timings peer;
  std::vector<world::ObstacleState> states;
  const auto play = [&] {
    states = cell.draw().obstacles;
    played.begin(draw_arms(cell), std::span(states).first(boxes));
    return time_once([&] {
             for (int k = 0; k < kSteps; ++k) played.step();
           }) /
           (3.0 * kSteps);
  };
  for (int k = 0; k < kWarmUp; ++k) play();
  Timings ticks;
  for (auto _ : state) {
    const double tick = play();
    ticks.add(tick);
    set_iteration_time(state, tick);
    const Instant now = instant_of(played, geometry, std::span(states).first(boxes));
    peer.measure([&] { fcl.distances(0, now, theirs); });
  }
  report(state, ticks, peer);
  state.counters["ticks_per_s"] = 1e6 * static_cast<double>(state.iterations()) / ticks.total();
}

BENCHMARK_CAPTURE(plays, alone, false)->Iterations(kPlays)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(plays, among_20_boxes, true)->Iterations(kPlays)->UseManualTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
