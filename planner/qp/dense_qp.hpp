#pragma once
/// A small dense quadratic programme: the point nearest to a target under linear inequalities and bounds.
///
///   minimise ½‖x − target‖²   subject to   G x ≤ h,   lower ≤ x ≤ upper
///
/// Solved by the dual active-set method of [Goldfarb83] with an identity Hessian: it starts at the target and adds the
/// most violated constraint until none is left, so a tick without near obstacles costs nothing. No allocation.

#include <array>
#include <cstdint>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// The most rows of G. A tick that has more near pairs keeps the nearest ones.
inline constexpr int kMaxRows = 64;

/// Arrays are filled up to `rows`, the rest is left as it is: a problem is made in every tick.
struct QpProblem {
  JointVector target;  ///< n
  JointVector lower;   ///< n, −infinity allowed
  JointVector upper;   ///< n, ≥ lower; +infinity allowed
  int rows = 0;
  Eigen::Matrix<double, kMaxRows, kMaxJoints, Eigen::RowMajor> G;  ///< rows × n in its top left corner
  std::array<double, kMaxRows> h;
  std::array<double, kMaxRows> norm;        ///< of each row of G
  std::array<std::uint32_t, kMaxRows> key;  ///< names a row from solve to solve, for the warm start

  /// Appends g · x ≤ bound. False when the problem is full.
  bool add_row(const JointVector& g, double bound, std::uint32_t name) {
    if (rows == kMaxRows) return false;
    G.row(rows).head(g.size()) = g.transpose();
    h[rows] = bound;
    norm[rows] = g.norm();
    key[rows] = name;
    ++rows;
    return true;
  }
};

enum class QpStatus : std::uint8_t {
  kOptimal,
  kInfeasible,      ///< no x satisfies the constraints; x is the last iterate and must not be used
  kIterationLimit,  ///< gave up on a degenerate problem; x may violate constraints
};

/// The constraints that were active at the last solution, by name. A default value is a cold start. A warm start
/// changes the number of iterations, never the solution.
struct QpWarmStart {
  std::array<std::uint32_t, kMaxJoints> key{};
  int count = 0;
};

struct QpSolution {
  QpStatus status = QpStatus::kOptimal;
  JointVector x;                             ///< n
  int iterations = 0;                        ///< constraints added or dropped
  int active = 0;                            ///< how many constraints hold with equality and a multiplier > 0
  std::array<int, kMaxJoints> active_row{};  ///< index of a row of G; −1 − 2j: lower bound of j; −2 − 2j: upper bound
  std::array<double, kMaxJoints> multiplier{};
};

/// Solves `problem`; `warm` is read as the first guess of the active set and replaced by the new one.
[[nodiscard]] QpSolution solve(const QpProblem& problem, QpWarmStart& warm);

}  // namespace hecaton::planner
