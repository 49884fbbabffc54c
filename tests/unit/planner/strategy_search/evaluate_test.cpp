// The fast simulation against the planner's own kinematics and distances, and against itself told differently.

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

/// Configurations in a larger ball round the areas, so that arms are near each other, obstacles and themselves.
JointVector anywhere(const PlannedArm& planned, Random& random) {
  JointVector q = planned.arm.named.at(random.uniform() < 0.5 ? "left" : "right");
  for (Eigen::Index j = 0; j + 1 < q.size(); ++j) q[j] += random.uniform(-1.0, 1.0);
  return q;
}

// Whoever is clear to the kernel is at least that far away by exact distances, and the other way round.
TEST(FlatArmTest, IsClearWhereExactDistancesSaySo) {
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
        // Of the own base the kernel looks at nothing: no motion changes where that is.
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

TEST(EvaluateTest, IsTheSameOnEveryInstructionSet) {
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

/// Some of the grid's strategies have the same results in both problems, each with its tasks. Returns their faults.
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

// Distances in single precision must never decide what those in double precision would decide otherwise.
TEST(EvaluateTest, SinglePrecisionDecidesNothing) {
  std::int64_t faults = 0;
  for (const char* name : {"2a", "3a"}) {
    const StrategyProblem problem(scorbots(name));
    StrategyProblem exact(scorbots(name));
    EXPECT_LT(problem.flat().rounding, 1e-3) << "or it would be of little use";
    exact.flat().rounding = 10.0;  // more than any distance: each is looked at in double precision
    faults += expect_same(problem, problem.draw(5, 20), exact, exact.draw(5, 20));
  }
  EXPECT_GT(faults, 0);
}

// Nor must it matter whether straight ways were looked at beforehand, also after faults and beyond an arm's N.
TEST(EvaluateTest, LookingAtWaysBeforehandChangesNoResult) {
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

// Who repeats himself is not simulated until his time is over; nothing else may change by that.
TEST(EvaluateTest, FindingCyclesChangesNoResult) {
  const StrategyProblem problem(scorbots("2a"));
  const TaskSet tasks = problem.draw(2, 30);
  const std::vector<SystemStrategy> grid = StrategyGrid{}.of(problem);
  std::int64_t faults = 0;
  for (std::size_t i = 0; i < grid.size(); i += 23) {
    const Evaluation quick = evaluate(problem, tasks, grid[i]);
    const Evaluation slow = evaluate(problem, tasks, grid[i], {.find_cycles = false});
    EXPECT_EQ(quick.faults, slow.faults) << i;
    EXPECT_EQ(quick.time, slow.time) << i;
    EXPECT_LE(quick.arm_ticks, slow.arm_ticks);
    faults += quick.all_faults();
  }
  EXPECT_GT(faults, 20);
}

// One arm alone has nothing in its way: each task takes ‖q_F − q_I‖/Δ steps, rounded up.
TEST(EvaluateTest, WithoutOthersTheWayIsStraight) {
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

// Of the grid's strategies, some do not lead past each other.
TEST(EvaluateTest, TimeOverIsAFaultAndTheOthersBeginAnew) {
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
        over += t >= 200 * 33 ? 1 : 0;  // no way is shorter than 33 steps: 2.27 rad, less twice the spread
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

}  // namespace
}  // namespace hecaton::planner
