#include <array>
#include <chrono>
#include <cstdio>

#include "planner/rollout/played_cell.hpp"
#include "tests/bench/benches.hpp"
#include "tests/bench/pairs_cell.hpp"

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

/// The mean tick of each play, one after the other on one core.
Timings measure_plays(const std::string& name, PairsCell& cell, std::span<const world::Obstacle> obstacles) {
  PlayedCell played(cell.geometry().arms(), std::vector<LocalParameters>(3), kPeriod);
  played.set_obstacles(obstacles);
  Timings timings(name);
  double total = 0.0;
  for (int play = -kWarmUp; play < kPlays; ++play) {
    const std::vector<world::ObstacleState> states = cell.draw().obstacles;
    played.begin(draw_arms(cell), std::span(states).first(obstacles.size()));
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < kSteps; ++k) played.step();
    const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - start;
    if (play < 0) continue;
    timings.add(spent.count() / (3.0 * kSteps));
    total += spent.count();
  }
  std::fprintf(stderr, "%s: %.2f million ticks a second of one core\n", name.c_str(), 3.0 * kSteps * kPlays / total);
  return timings;
}

}  // namespace

void run_plays(Output output) {
  PairsCell cell(20060521);
  const Timings alone = measure_plays("tick in a play of three arms", cell, {});
  const Timings boxes = measure_plays("tick in a play of three arms among 20 boxes", cell, cell.obstacles());
  print(output, {{alone, nullptr}, {boxes, nullptr}});
}

}  // namespace hecaton::bench
