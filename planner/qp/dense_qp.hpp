#pragma once
/// A small dense quadratic programme: the nearest point to a target under linear inequalities and bounds.
///
///   minimise ½‖x − target‖²   subject to   G x ≤ h,   lower ≤ x ≤ upper
///
/// The solver is the dual active-set method of [Goldfarb83] with an identity Hessian. It starts at the target and adds
/// the most violated constraint until none is left. A target that satisfies all constraints costs almost nothing. No
/// allocation. Deterministic.

#include <array>
#include <cstdint>

#include "planner/model/limits.hpp"
#include "planner/model/memory_archive.hpp"

namespace hecaton::planner {

/// Capacity in rows of G. A tick with more near pairs keeps the nearest ones.
inline constexpr int kMaxRows = 64;

/// Arrays are valid up to `rows`; the rest is not initialised.
struct QpProblem {
  JointVector target;  ///< n
  JointVector lower;   ///< n, −infinity allowed
  JointVector upper;   ///< n, ≥ lower; +infinity allowed
  int rows = 0;
  Eigen::Matrix<double, kMaxRows, kMaxJoints, Eigen::RowMajor> G;  ///< rows × n in its top left corner
  std::array<double, kMaxRows> h;
  std::array<double, kMaxRows> norm;        ///< of each row of G
  std::array<std::uint32_t, kMaxRows> key;  ///< identifies a row between solves, for the warm start

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
  kInfeasible,      ///< no x satisfies the constraints; do not use x
  kIterationLimit,  ///< degenerate problem; x may violate constraints
};

/// Keys of the active constraints of the last solution. A default value is a cold start. A warm start changes the
/// number of iterations, never the solution.
struct QpWarmStart {
  std::array<std::uint32_t, kMaxJoints> key{};
  int count = 0;

  void describe(MemoryArchive& archive) {
    for (std::uint32_t& one : key) archive(one);
    archive.number(count, 0, kMaxJoints);
  }
};

struct QpSolution {
  QpStatus status = QpStatus::kOptimal;
  JointVector x;                             ///< n
  int iterations = 0;                        ///< number of added and dropped constraints
  int active = 0;                            ///< number of active constraints
  std::array<int, kMaxJoints> active_row{};  ///< index of a row of G; −1 − 2j: lower bound of j; −2 − 2j: upper bound
  std::array<double, kMaxJoints> multiplier{};
};

/// Solves `problem`. `warm`: initial guess of the active set, replaced by the new active set. Thread-safe.
[[nodiscard]] QpSolution solve(const QpProblem& problem, QpWarmStart& warm);

}  // namespace hecaton::planner
