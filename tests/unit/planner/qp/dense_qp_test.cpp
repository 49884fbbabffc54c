// The solver against hand-solved problems, the optimality conditions, and an independent solver (cvxopt).
#include "planner/qp/dense_qp.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

namespace hecaton::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

QpProblem unbounded(int n) {
  QpProblem problem;
  problem.target = JointVector::Zero(n);
  problem.lower = JointVector::Constant(n, -kInfinity);
  problem.upper = JointVector::Constant(n, kInfinity);
  return problem;
}

QpProblem random_problem(std::mt19937_64& random, int n, int rows, double tightness) {
  std::normal_distribution<double> normal;
  QpProblem problem = unbounded(n);
  for (int j = 0; j < n; ++j) {
    problem.target[j] = 2.0 * normal(random);
    problem.lower[j] = -1.5;
    problem.upper[j] = 1.5;
  }
  for (int i = 0; i < rows; ++i) {
    JointVector g(n);
    for (int j = 0; j < n; ++j) g[j] = normal(random);
    problem.add_row(g, tightness * std::abs(normal(random)) - 0.05, static_cast<std::uint32_t>(i));
  }
  return problem;
}

double worst_violation(const QpProblem& problem, const JointVector& x) {
  double worst = 0.0;
  for (int i = 0; i < problem.rows; ++i) {
    worst = std::max(worst, problem.G.row(i).head(x.size()).dot(x) - problem.h[i]);
  }
  for (int j = 0; j < x.size(); ++j) worst = std::max({worst, problem.lower[j] - x[j], x[j] - problem.upper[j]});
  return worst;
}

/// ‖x − target + Σ u a‖: zero at the optimum together with u ≥ 0, feasibility and complementarity.
double stationarity(const QpProblem& problem, const QpSolution& solution) {
  JointVector residual = solution.x - problem.target;
  for (int k = 0; k < solution.active; ++k) {
    const int c = solution.active_row[k];
    if (c >= 0) {
      residual += solution.multiplier[k] * problem.G.row(c).head(residual.size()).transpose();
    } else {
      const bool lower = (-c) % 2 == 1;
      const int j = lower ? (-c - 1) / 2 : (-c - 2) / 2;
      residual[j] += (lower ? -1.0 : 1.0) * solution.multiplier[k];
    }
  }
  return residual.norm();
}

TEST(DenseQp, ReturnsTheTargetWithoutConstraints) {
  QpProblem problem = unbounded(3);
  problem.target << 1.0, -2.0, 3.0;
  QpWarmStart warm;
  const QpSolution solution = solve(problem, warm);
  EXPECT_EQ(solution.status, QpStatus::kOptimal);
  EXPECT_EQ(solution.x, problem.target);
  EXPECT_EQ(solution.iterations, 0);
}

TEST(DenseQp, ProjectsOntoAPlaneAndACorner) {
  // Target (2, 2); x + y ≤ 2 alone projects to (1, 1); with x ≤ 0.5 as well the corner is (0.5, 1.5).
  QpProblem problem = unbounded(2);
  problem.target << 2.0, 2.0;
  JointVector g(2);
  g << 1.0, 1.0;
  problem.add_row(g, 2.0, 7);
  QpWarmStart warm;
  EXPECT_NEAR((solve(problem, warm).x - Eigen::Vector2d(1.0, 1.0)).norm(), 0.0, 1e-12);
  problem.upper[0] = 0.5;
  const QpSolution corner = solve(problem, warm);
  EXPECT_NEAR((corner.x - Eigen::Vector2d(0.5, 1.5)).norm(), 0.0, 1e-12);
  EXPECT_EQ(corner.active, 2);
}

TEST(DenseQp, ReportsInfeasibility) {
  QpProblem problem = unbounded(2);
  JointVector g(2);
  g << 1.0, 0.0;
  problem.add_row(g, -1.0, 1);   // x ≤ −1
  problem.add_row(-g, -1.0, 2);  // x ≥ 1
  QpWarmStart warm;
  EXPECT_EQ(solve(problem, warm).status, QpStatus::kInfeasible);
}

TEST(DenseQp, ZeroRowIsInfeasibleOnlyWhenViolated) {
  QpProblem problem = unbounded(2);
  problem.add_row(JointVector::Zero(2), 0.0, 1);
  QpWarmStart warm;
  EXPECT_EQ(solve(problem, warm).status, QpStatus::kOptimal);
  problem.add_row(JointVector::Zero(2), -0.1, 2);
  EXPECT_EQ(solve(problem, warm).status, QpStatus::kInfeasible);
}

TEST(DenseQp, SolvesDuplicatedAndNearlyParallelRows) {
  QpProblem problem = unbounded(3);
  problem.target << 1.0, 1.0, 1.0;
  JointVector g(3);
  g << 1.0, 2.0, -1.0;
  for (int i = 0; i < 10; ++i) {
    problem.add_row(g, 0.5, static_cast<std::uint32_t>(i));
    g[2] += 1e-13;
  }
  QpWarmStart warm;
  const QpSolution solution = solve(problem, warm);
  ASSERT_EQ(solution.status, QpStatus::kOptimal);
  EXPECT_LT(worst_violation(problem, solution.x), 1e-9);
  // target − (gᵀt − 0.5)/‖g‖² g = (1,1,1) − 1.5/6 (1, 2, −1)
  EXPECT_NEAR((solution.x - Eigen::Vector3d(0.75, 0.5, 1.25)).norm(), 0.0, 1e-9);
}

TEST(DenseQp, OptimalityConditionsHoldOnRandomProblems) {
  std::mt19937_64 random(20061);
  int feasible = 0;
  for (int trial = 0; trial < 100'000; ++trial) {
    const int n = 1 + static_cast<int>(random() % 8);
    const QpProblem problem = random_problem(random, n, static_cast<int>(random() % 40), trial % 2 == 0 ? 0.3 : 2.0);
    QpWarmStart warm;
    const QpSolution solution = solve(problem, warm);
    ASSERT_NE(solution.status, QpStatus::kIterationLimit);
    if (solution.status != QpStatus::kOptimal) continue;
    ++feasible;
    ASSERT_LT(worst_violation(problem, solution.x), 1e-8);
    ASSERT_LT(stationarity(problem, solution), 1e-7);
    for (int k = 0; k < solution.active; ++k) ASSERT_GE(solution.multiplier[k], 0.0);
  }
  EXPECT_GT(feasible, 50'000);
}

TEST(DenseQp, WarmStartChangesIterationsNotTheSolution) {
  std::mt19937_64 random(77);
  std::normal_distribution<double> normal;
  long cold_iterations = 0;
  long warm_iterations = 0;
  for (int trial = 0; trial < 5'000; ++trial) {
    QpProblem problem = random_problem(random, 6, 20, 0.5);
    QpWarmStart warm;
    if (solve(problem, warm).status != QpStatus::kOptimal) continue;
    for (int j = 0; j < 6; ++j) problem.target[j] += 0.02 * normal(random);  // the next tick: almost the same problem
    QpWarmStart cold;
    const QpSolution expected = solve(problem, cold);
    const QpSolution actual = solve(problem, warm);
    ASSERT_EQ(expected.status, actual.status);
    if (expected.status != QpStatus::kOptimal) continue;
    ASSERT_LT((expected.x - actual.x).norm(), 1e-8);
    cold_iterations += expected.iterations;
    warm_iterations += actual.iterations;
  }
  EXPECT_LT(2 * warm_iterations, cold_iterations);
}

/// Writes the problems, lets cvxopt solve them, reads "status x1 … xn" back.
TEST(DenseQp, AgreesWithCvxopt) {
  const auto folder = std::filesystem::temp_directory_path() / ("hecaton_qp_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::mt19937_64 random(4711);
  std::vector<QpProblem> problems;
  std::ofstream file(folder / "problems.txt");
  file.precision(17);
  for (int i = 0; i < 400; ++i) {
    problems.push_back(random_problem(random, 2 + i % 6, 3 + i % 25, i % 2 == 0 ? 0.3 : 2.0));
    const QpProblem& p = problems.back();
    file << p.target.size() << ' ' << p.rows << '\n'
         << p.target.transpose() << '\n'
         << p.lower.transpose() << '\n'
         << p.upper.transpose() << '\n';
    for (int r = 0; r < p.rows; ++r) file << p.G.row(r).head(p.target.size()) << ' ' << p.h[r] << '\n';
  }
  file.close();
  const std::string command = "/usr/bin/python3 " HECATON_SOURCE_DIR "/tests/unit/planner/qp/cvxopt_oracle.py " +
                              (folder / "problems.txt").string() + " " + (folder / "solutions.txt").string();
  ASSERT_EQ(std::system(command.c_str()), 0) << "needs the Debian package python3-cvxopt";
  std::ifstream answers(folder / "solutions.txt");
  int compared = 0;
  int infeasible = 0;
  for (const QpProblem& problem : problems) {
    std::string status;
    ASSERT_TRUE(answers >> status);
    JointVector expected(problem.target.size());
    for (auto& value : expected) answers >> value;
    QpWarmStart warm;
    const QpSolution solution = solve(problem, warm);
    if (status == "optimal") {
      ASSERT_EQ(solution.status, QpStatus::kOptimal);
      EXPECT_LT((solution.x - expected).norm(), 2e-5);
      ++compared;
    } else if (status == "infeasible") {
      EXPECT_EQ(solution.status, QpStatus::kInfeasible);
      ++infeasible;
    }
  }
  EXPECT_GT(compared, 200);
  EXPECT_GT(infeasible, 20);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace hecaton::planner
