// The fast simulation against exact kinematics and distances, and against itself with other settings; statistics.

#include "planner/strategy_search/evaluate.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/random.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/simd/instruction_set.hpp"
#include "planner/strategy_search/search.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::planner {
namespace {

Cell scorbots(const char* problem) {
  return config::load_cell_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/scorbot_" + problem + ".yaml").cell;
}

Strategy strategy(double alpha, double beta, double direction) {
  Strategy s;
  s.coefficients[0] = alpha;
  s.coefficients[1] = beta;
  s.direction = direction;
  return s;
}

/// Configurations in a larger ball about the areas, so that arms are close to each other, to obstacles and to
/// themselves.
JointVector anywhere(const PlannedArm& planned, Random& random) {
  JointVector q = planned.arm.named.at(random.uniform() < 0.5 ? "left" : "right");
  for (Eigen::Index j = 0; j + 1 < q.size(); ++j) q[j] += random.uniform(-1.0, 1.0);
  return q;
}

// The kernel reports clear if and only if the exact distances are large enough.
TEST(FlatArmTest, IsClearIfExactDistancesAre) {
  const Cell cell = scorbots("3a");
  const StrategyProblem problem(cell);
  const std::vector<Arm> arms = arms_of(cell);
  std::vector<CellGeometry> geometries;
  for (int i = 0; i < 3; ++i) geometries.emplace_back(arms, i).set_obstacles(cell.scene.obstacles);
  std::vector<world::ObstacleState> obstacles;
  for (const world::Obstacle& obstacle : cell.scene.obstacles) obstacles.push_back({obstacle.X_WO, {}, 0.0});
  Random random(3);
  int clear_count = 0;
  int undecided = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<JointVector> q;
    std::vector<Kinematics> kinematics(3);
    const double* flat_q[kFlatArms] = {};
    for (int i = 0; i < 3; ++i) q.push_back(anywhere(cell.arms[i], random));
    for (int i = 0; i < 3; ++i) {
      flat_q[i] = q[i].data();
      forward_kinematics(*arms[i].model, arms[i].X_WB, q[i], kinematics[i]);
    }
    const unsigned clear = fastest_clear()(problem.flat(), flat_q, true);
    for (int i = 0; i < 3; ++i) {
      bool within = true;
      for (int j = 0; j < 4; ++j)
        within = within && q[i][j] >= arms[i].limits.lower[j] && q[i][j] <= arms[i].limits.upper[j];
      ExactDistance distance(geometries[i]);
      std::vector<Clearance> found(64);
      const int count =
          distance.clearances({&kinematics[i], kinematics, obstacles}, {.others = 0.06, .self = 0.06}, found);
      bool near = !within;
      bool nearly = false;
      for (int k = 0; k < count; ++k) {
        // The kernel ignores the fixed base of the arm.
        const bool self = found[k].counterpart == Counterpart::kSelf;
        const double limit = self ? problem.flat().self_distance : problem.flat().distance;
        near = near || found[k].distance < limit;
        nearly = nearly || std::abs(found[k].distance - limit) < 1e-6;
      }
      if (nearly) {
        ++undecided;
        continue;
      }
      EXPECT_EQ((clear >> i) & 1U, near ? 0U : 1U) << "trial " << trial << " arm " << i;
      clear_count += near ? 0 : 1;
    }
  }
  EXPECT_GT(clear_count, 500);
  EXPECT_LT(clear_count, 5500);
  EXPECT_LT(undecided, 10);
}

TEST(EvaluateTest, IsTheSameOnAllInstructionSets) {
  if (!has_avx2()) GTEST_SKIP();
  const StrategyProblem problem(scorbots("3a"));
  const TaskSet tasks = problem.draw(7, 40);
  const StrategyGrid grid;
  const std::vector<Strategy> own = grid.of_arm(2);
  Random random(11);
  for (int trial = 0; trial < 20; ++trial) {
    FlatStrategy flat[kFlatArms];
    for (int i = 0; i < 3; ++i) {
      const Strategy& s = own[random.next() % own.size()];
      for (int k = 0; k < 2; ++k) flat[i].coefficients[k] = s.coefficients[k];
      flat[i].direction = s.direction;
    }
    RunResult a;
    RunResult b;
    baseline::run_strategies(problem.flat(), tasks.flat, flat, {}, a);
    avx2::run_strategies(problem.flat(), tasks.flat, flat, {}, b);
    EXPECT_EQ(a.arm_ticks, b.arm_ticks);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(a.time[i], b.time[i]);
      EXPECT_EQ(a.faults[i], b.faults[i]);
    }
  }
}

/// Requires equal results of some strategies of the grid in both problems. Returns their faults.
std::int64_t expect_same(const StrategyProblem& a, const TaskSet& tasks_a, const StrategyProblem& b,
                         const TaskSet& tasks_b) {
  const std::vector<SystemStrategy> grid = StrategyGrid{{-2, 2}, {-1, 1}}.of(a);
  const std::size_t step = grid.size() / 9;
  std::int64_t faults = 0;
  for (std::size_t i = 0; i < grid.size(); i += step) {
    const Evaluation first = evaluate(a, tasks_a, grid[i]);
    const Evaluation second = evaluate(b, tasks_b, grid[i]);
    EXPECT_EQ(first.faults, second.faults) << i;
    EXPECT_EQ(first.time, second.time) << i;
    EXPECT_EQ(first.arm_ticks, second.arm_ticks) << i;
    faults += first.all_faults();
  }
  return faults;
}

// Distances in single precision must not change any decision of double precision.
TEST(EvaluateTest, SinglePrecisionChangesNoResult) {
  std::int64_t faults = 0;
  for (const char* name : {"2a", "3a"}) {
    const StrategyProblem problem(scorbots(name));
    StrategyProblem exact(scorbots(name));
    EXPECT_LT(problem.flat().rounding, 1e-3) << "a larger bound would be useless";
    exact.flat().rounding = 10.0;  // larger than all distances: each is computed in double precision
    faults += expect_same(problem, problem.draw(5, 20), exact, exact.draw(5, 20));
  }
  EXPECT_GT(faults, 0);
}

// Prechecked paths must not change results, also after faults and beyond an arm's N tasks.
TEST(EvaluateTest, PrecheckedPathsChangeNoResult) {
  std::int64_t faults = 0;
  for (const char* name : {"2a", "2c", "3a"}) {
    const StrategyProblem problem(scorbots(name));
    TaskSet known = problem.draw(6, 30);
    problem.precheck_paths(known);
    EXPECT_EQ(known.flat.paths[0].tasks, 30);
    faults += expect_same(problem, known, problem, problem.draw(6, 30));
  }
  EXPECT_GT(faults, 0);
}

// Cycle detection skips steps but changes no result.
TEST(EvaluateTest, CycleDetectionChangesNoResult) {
  const StrategyProblem problem(scorbots("2a"));
  const TaskSet tasks = problem.draw(2, 30);
  const std::vector<SystemStrategy> grid = StrategyGrid{}.of(problem);
  std::int64_t faults = 0;
  for (std::size_t i = 0; i < grid.size(); i += 23) {
    const Evaluation quick = evaluate(problem, tasks, grid[i]);
    const Evaluation slow = evaluate(problem, tasks, grid[i], {.detect_cycles = false});
    EXPECT_EQ(quick.faults, slow.faults) << i;
    EXPECT_EQ(quick.time, slow.time) << i;
    EXPECT_LE(quick.arm_ticks, slow.arm_ticks);
    faults += quick.all_faults();
  }
  EXPECT_GT(faults, 20);
}

// A single arm moves straight: each task takes ‖q_F − q_I‖/Δ steps, rounded up.
TEST(EvaluateTest, SingleArmMovesStraight) {
  Cell cell = scorbots("2a");
  cell.arms.resize(1);
  cell.tasks.problem.areas.erase("robot2");
  const StrategyProblem problem(cell);
  const TaskSet tasks = problem.draw(4, 100);
  std::vector<std::vector<std::int32_t>> times;
  static_cast<void>(evaluate(problem, tasks, {strategy(0, 1, 1)}, {.times = &times}));
  const double* from = tasks.starts[0].data();
  for (int k = 0; k < 100; ++k) {
    const int area = (k + 1) % 2;
    const double* to = &tasks.goals[0][(k * 2 + area) * 4];
    double length2 = 0.0;
    for (int j = 0; j < 4; ++j) length2 += (to[j] - from[j]) * (to[j] - from[j]);
    EXPECT_NEAR(times[0][k], std::ceil(std::sqrt(length2) / problem.flat().step - 1e-9), 0.0) << k;
    from = to;
  }
}

// With some strategies of the grid, the arms cannot pass each other.
TEST(EvaluateTest, TimeoutIsAFaultAndAllArmsRestart) {
  const StrategyProblem problem(scorbots("2a"));
  const TaskSet tasks = problem.draw(1, 20);
  int examined = 0;
  for (const SystemStrategy& candidate : StrategyGrid{}.of(problem)) {
    std::vector<std::vector<std::int32_t>> times;
    const Evaluation evaluation = evaluate(problem, tasks, candidate, {.times = &times});
    if (evaluation.all_faults() < 3) continue;
    EXPECT_EQ(evaluation.tasks, (std::vector<std::int64_t>{20, 20}));
    EXPECT_TRUE(evaluation.complete);
    for (int arm = 0; arm < 2; ++arm) {
      double sum = 0.0;
      std::int64_t over = 0;
      for (const std::int32_t t : times[arm]) {
        sum += t;
        over += t >= 200 * 33 ? 1 : 0;  // each path has at least 33 steps: 2.27 rad, less twice the spread
      }
      EXPECT_EQ(sum, evaluation.time[arm]);
      EXPECT_EQ(over, evaluation.faults[arm]);
    }
    const Evaluation aborted = evaluate(problem, tasks, candidate, {.stop_at_fault = true});
    EXPECT_EQ(aborted.all_faults(), 1);
    EXPECT_FALSE(aborted.complete);
    if (++examined == 20) break;
  }
  EXPECT_EQ(examined, 20);
}

// No fault in N: P(X ≤ 0) = (1 − p)^N = 2.5 % → p = 1 − 0.025^(1/N).
TEST(FaultBoundsTest, NoFaultInSomeTasks) {
  const FaultBounds bounds = fault_bounds(0, 4200);
  EXPECT_EQ(bounds.low, 0.0);
  EXPECT_NEAR(bounds.high, 1.0 - std::pow(0.025, 1.0 / 4200), 1e-12);
}

// The textbook example of exact limits: 2 of 10, 95 %: 0.0252 to 0.5561.
TEST(FaultBoundsTest, TwoOfTen) {
  const FaultBounds bounds = fault_bounds(2, 10);
  EXPECT_NEAR(bounds.low, 0.02521, 1e-5);
  EXPECT_NEAR(bounds.high, 0.55610, 1e-5);
}

TEST(FaultBoundsTest, AllFaultsAndNoTasks) {
  EXPECT_EQ(fault_bounds(7, 7).high, 1.0);
  EXPECT_NEAR(fault_bounds(7, 7).low, std::pow(0.025, 1.0 / 7), 1e-12);
  EXPECT_EQ(fault_bounds(0, 0).high, 1.0);
}

// a = 1, 3, 1, 3: mean 2, deviation 1; lag 1: Σ of three products of −1 over 4; lag 2: two of +1 over 4.
TEST(CorrelationTest, OfAnAlternatingSeries) {
  const std::vector<std::int32_t> a = {1, 3, 1, 3};
  const std::vector<double> own = correlations(a, a, 2);
  EXPECT_DOUBLE_EQ(own[0], -0.75);
  EXPECT_DOUBLE_EQ(own[1], 0.5);
  EXPECT_DOUBLE_EQ(correlation(a, a), 1.0);
  EXPECT_DOUBLE_EQ(correlation(a, {std::vector<std::int32_t>{3, 1, 3, 1}}), -1.0);
  EXPECT_DOUBLE_EQ(correlation(a, {std::vector<std::int32_t>{5, 5, 5, 5}}), 0.0);
}

}  // namespace
}  // namespace hecaton::planner
