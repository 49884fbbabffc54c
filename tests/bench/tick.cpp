#include "planner/tick.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/goal_objective.hpp"
#include "planner/local/limit_rows.hpp"
#include "planner/local/velocity_damper.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "tests/bench/benches.hpp"
#include "tests/bench/pairs_cell.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr double kPeriod = 0.010;  // [s]
constexpr int kJourneys = 20;
constexpr int kExactJourneys = 5;
constexpr int kTicksAJourney = 250;

/// The two other arms swing about where they were drawn, out of step.
void swing(const CellGeometry& geometry, const Instant& start, double time, std::vector<ArmObservation>& arms) {
  constexpr double kAmplitude = 0.4;  // [rad]
  constexpr double kRate = 1.5;       // [rad/s]
  for (int i = 1; i < static_cast<int>(geometry.arms().size()); ++i) {
    const double phase = kRate * time + i;
    arms[i].q = start.q[i].array() + kAmplitude * std::sin(phase);
    arms[i].qd = JointVector::Constant(start.q[i].size(), kAmplitude * kRate * std::cos(phase));
    arms[i].known = true;
    arms[i].plans = true;
  }
}

/// A start from which the arm can set off: nothing nearer than this [m].
constexpr double kFree = 0.03;

Instant draw_start(PairsCell& cell, ExactDistance& distance) {
  std::array<Clearance, 1> one;
  while (true) {
    Instant instant = cell.draw();
    const CellPoses poses{instant.kinematics.data(), instant.kinematics, instant.obstacles};
    if (distance.clearances(poses, {kFree, 0.0, {}}, one) == 0) return instant;
  }
}

/// What a tick consists of, timed one by one on the tick's own input.
class Parts {
 public:
  Parts(const CellGeometry& geometry, const std::string& geometry_name)
      : placing(geometry_name + "kinematics of three arms"),
        pass(geometry_name + "distances, 0.12 m"),
        dampers(geometry_name + "rows of its pairs"),
        programme(geometry_name + "one quadratic programme with them"),
        geometry_(geometry),
        distance_(geometry),
        kinematics_(geometry.arms().size()) {
    for (const Arm& arm : geometry.arms()) stop_times_.push_back(longest_stop_time(arm.limits));
  }

  void measure(const TickInput& input, const LocalParameters& parameters) {
    placing.measure([&] { place(input); });
    int near = 0;
    pass.measure([&] {
      near = distance_.clearances({kinematics_.data(), kinematics_, input.obstacles}, {kInfluence, 0.0, {}}, near_);
    });
    const DamperScene scene{geometry_,   kinematics_[0], input.qd,    input.tracking_error,
                            kinematics_, input.arms,     stop_times_, input.obstacles,
                            input.dt,    parameters};
    dampers.measure([&] {
      for (int k = 0; k < near; ++k) rows_[k] = velocity_damper(scene, near_[k]);
    });
    programme.measure([&] { solve_rows(input, near); });
  }

  static constexpr double kInfluence = 0.12;  // [m]
  Timings placing;
  Timings pass;
  Timings dampers;
  Timings programme;

 private:
  void place(const TickInput& input) {
    for (std::size_t i = 0; i < kinematics_.size(); ++i) {
      const Arm& arm = geometry_.arms()[i];
      forward_kinematics(*arm.model, arm.X_WB, i == 0 ? input.q : input.arms[i].q, kinematics_[i]);
    }
  }

  void solve_rows(const TickInput& input, int count) {
    const JointLimits& limits = geometry_.own_arm().limits;
    const VelocityBounds bounds = speed_and_position_bounds(limits, input.q, input.dt);
    problem_.rows = 0;
    problem_.lower = bounds.lower;
    problem_.upper = bounds.upper;
    problem_.target = goal_velocity(limits, input.q, input.q_goal, input.dt);
    for (int k = 0; k < count; ++k) problem_.add_row(rows_[k].g, rows_[k].h, rows_[k].key);
    solution_ = solve(problem_, warm_);
  }

  const CellGeometry& geometry_;
  ExactDistance distance_;
  std::vector<Kinematics> kinematics_;
  std::vector<double> stop_times_;
  std::array<Clearance, kMaxRows> near_;
  std::array<planner::Row, kMaxRows> rows_;
  QpProblem problem_;
  QpWarmStart warm_;
  QpSolution solution_;
};

/// Journeys of one arm among the others and the boxes; `name`: of the geometry that is measured.
void measure_journeys(LinkShapes shapes, const std::string& name, int journeys, Output output) {
  PairsCell cell(20060521, shapes);
  const CellGeometry& geometry = cell.geometry();
  ExactDistance distance(geometry);
  FclPairs fcl(geometry);
  TickScratch scratch(geometry);
  Parts parts(geometry, "  " + name + ", ");
  LocalParameters parameters;
  Timings whole("whole tick, " + name + ", 192 pairs");
  Timings fcl_pass("fcl::distance, " + name + ", all 192 pairs, nearest points");
  std::vector<double> theirs;
  double rows = 0.0;
  int most_rows = 0;
  for (int journey = 0; journey < journeys; ++journey) {
    Instant instant = draw_start(cell, distance);
    const Instant start = instant;
    std::vector<ArmObservation> arms(geometry.arms().size());
    TickMemory memory{LocalMemory(static_cast<std::uint64_t>(journey) + 1)};
    TickInput input;
    input.dt = kPeriod;
    input.q = start.q[0];
    input.qd = JointVector::Zero(input.q.size());
    input.has_goal = true;
    input.q_goal = cell.draw().q[0];
    input.arms = arms;
    input.obstacles = instant.obstacles;
    for (int k = 0; k < kTicksAJourney; ++k) {
      swing(geometry, start, k * kPeriod, arms);
      const TickMemory before = memory;
      TickResult result;
      whole.measure([&] { memory = before; }, [&] { result = tick(geometry, parameters, input, memory, scratch); });
      parts.measure(input, parameters);
      for (std::size_t i = 0; i < arms.size(); ++i) {
        const Arm& arm = geometry.arms()[i];
        forward_kinematics(*arm.model, arm.X_WB, i == 0 ? input.q : arms[i].q, instant.kinematics[i]);
      }
      fcl_pass.measure([&] { fcl.distances(instant, theirs); });
      rows += result.rows;
      most_rows = std::max(most_rows, result.rows);
      input.q = result.q;
      input.qd = result.qd;
      if (result.status == TickStatus::kReached) input.q_goal = cell.draw().q[0];
    }
  }
  print(output, {{whole, &fcl_pass},
                 {parts.placing, &fcl_pass},
                 {parts.pass, &fcl_pass},
                 {parts.dampers, &fcl_pass},
                 {parts.programme, &fcl_pass},
                 {readings_of_the_clock(), nullptr}});
  std::fprintf(stderr, "%s: rows a tick: %.1f, at most %d\n", name.c_str(), rows / (journeys * kTicksAJourney),
               most_rows);
}

}  // namespace

void run_tick(Output output) {
  measure_journeys(LinkShapes::kFast, "capsules", kJourneys, output);
  measure_journeys(LinkShapes::kExact, "cylinders", kExactJourneys, output);
}

}  // namespace hecaton::bench
