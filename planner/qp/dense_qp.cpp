#include "planner/qp/dense_qp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hecaton::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Tolerance of a constraint, scaled to a unit normal.
constexpr double kViolation = 1e-10;
/// Below this a normal counts as linearly dependent on the active ones.
constexpr double kDependent = 1e-11;
/// Keys of bounds are above all keys of rows.
constexpr std::uint32_t kBoundKey = 0x8000'0000U;

/// Constraints are numbered rows first, then lower bounds, then upper bounds; each is aᵀx ≤ b with ‖a‖ = 1.
class Solver {
 public:
  Solver(const QpProblem& problem, QpSolution& solution)
      : problem_(problem),
        scale_(problem.norm),
        n_(static_cast<int>(problem.target.size())),
        solution_(solution),
        x_(problem.target) {}

  void run(QpWarmStart& warm) {
    if (target_is_feasible()) {
      publish(warm);
      return;
    }
    reset_factors();
    solution_.status = feasible_rows() ? QpStatus::kOptimal : QpStatus::kInfeasible;
    if (solution_.status == QpStatus::kOptimal) {
      start_from(warm);
      iterate();
    }
    publish(warm);
  }

 private:
  using Square = Eigen::Matrix<double, kMaxJoints, kMaxJoints>;

  [[nodiscard]] int constraints() const { return problem_.rows + 2 * n_; }

  /// A row with ‖g‖ = 0 is either always or never satisfied.
  [[nodiscard]] bool feasible_rows() const {
    for (int i = 0; i < problem_.rows; ++i) {
      if (scale_[i] < kDependent && problem_.h[i] < -kViolation) return false;
    }
    return true;
  }

  /// True in most ticks; the target is then the solution.
  [[nodiscard]] bool target_is_feasible() const {
    for (int j = 0; j < n_; ++j) {
      if (!(x_[j] >= problem_.lower[j] && x_[j] <= problem_.upper[j])) return false;
    }
    for (int i = 0; i < problem_.rows; ++i) {
      if (!(problem_.G.row(i).head(n_).dot(x_) <= problem_.h[i])) return false;
    }
    return true;
  }

  /// Violation of the constraint by x; ≤ 0: satisfied.
  [[nodiscard]] double violation(int c) const {
    if (c < problem_.rows) {
      if (scale_[c] < kDependent) return -kInfinity;
      return (problem_.G.row(c).head(n_).dot(x_) - problem_.h[c]) / scale_[c];
    }
    const int j = c - problem_.rows;
    return j < n_ ? problem_.lower[j] - x_[j] : x_[j - n_] - problem_.upper[j - n_];
  }

  /// d = Jᵀ a for the constraint's unit normal a (outward: aᵀx ≤ b).
  void project_normal(int c, JointVector& d) const {
    if (c < problem_.rows) {
      d.noalias() = J_.topLeftCorner(n_, n_).transpose() * problem_.G.row(c).head(n_).transpose();
      d /= scale_[c];
      return;
    }
    const int j = c - problem_.rows;
    if (j < n_) {
      d = -J_.row(j).head(n_).transpose();
    } else {
      d = J_.row(j - n_).head(n_).transpose();
    }
  }

  void reset_factors() {
    J_.topLeftCorner(n_, n_).setIdentity();
    active_ = 0;
  }

  /// Appends the constraint with d = Jᵀa to the factorisation N = J₁R: Givens rotations of J's free columns put the
  /// part of d beyond the active ones into its first free entry.
  void append(int c, double multiplier, JointVector& d) {
    for (int k = n_ - 1; k > active_; --k) {
      const double length = std::hypot(d[k - 1], d[k]);
      if (length == 0.0) continue;
      const double cosine = d[k - 1] / length;
      const double sine = d[k] / length;
      rotate_columns(k - 1, k, cosine, sine);
      d[k - 1] = length;
      d[k] = 0.0;
    }
    R_.col(active_).head(active_ + 1) = d.head(active_ + 1);
    set_[active_] = c;
    multiplier_[active_] = multiplier;
    ++active_;
  }

  /// Removes the k-th active constraint and restores R to triangular form.
  void drop(int k) {
    for (int j = k; j < active_ - 1; ++j) {
      R_.col(j).head(j + 2) = R_.col(j + 1).head(j + 2);
      set_[j] = set_[j + 1];
      multiplier_[j] = multiplier_[j + 1];
    }
    --active_;
    for (int j = k; j < active_; ++j) {
      const double length = std::hypot(R_(j, j), R_(j + 1, j));
      if (length == 0.0) continue;
      const double cosine = R_(j, j) / length;
      const double sine = R_(j + 1, j) / length;
      for (int col = j; col < active_; ++col) {
        const double upper = R_(j, col);
        const double lower = R_(j + 1, col);
        R_(j, col) = cosine * upper + sine * lower;
        R_(j + 1, col) = cosine * lower - sine * upper;
      }
      rotate_columns(j, j + 1, cosine, sine);
    }
  }

  void rotate_columns(int a, int b, double cosine, double sine) {
    for (int i = 0; i < n_; ++i) {
      const double first = J_(i, a);
      const double second = J_(i, b);
      J_(i, a) = cosine * first + sine * second;
      J_(i, b) = cosine * second - sine * first;
    }
  }

  [[nodiscard]] bool is_active(int c) const {
    return std::find(set_.begin(), set_.begin() + active_, c) != set_.begin() + active_;
  }

  /// Initialises the active set from the warm start. Keeps only constraints with non-negative multipliers at the
  /// minimum under these equalities, as the dual method requires.
  void start_from(const QpWarmStart& warm) {
    for (int i = 0; i < warm.count && active_ < n_; ++i) {
      const int c = find(warm.key[i]);
      if (c < 0 || is_active(c) || (c < problem_.rows && scale_[c] < kDependent)) continue;
      if (c >= problem_.rows && !std::isfinite(violation(c))) continue;
      JointVector d(n_);
      project_normal(c, d);
      if (d.tail(n_ - active_).norm() > 1e-6) append(c, 0.0, d);
    }
    while (active_ > 0) {
      x_ = problem_.target;
      // Minimum on the equalities: x = target − N u with R Rᵀ-free substitution u = R⁻¹R⁻ᵀ(Nᵀ target − b).
      JointVector u(active_);
      for (int k = 0; k < active_; ++k) u[k] = violation(set_[k]);
      const auto R = R_.topLeftCorner(active_, active_).triangularView<Eigen::Upper>();
      R.transpose().solveInPlace(u);
      const JointVector y = u;
      R.solveInPlace(u);
      Eigen::Index worst = 0;
      if (u.minCoeff(&worst) >= 0.0) {
        x_.noalias() -= J_.topLeftCorner(n_, active_) * y;
        for (int k = 0; k < active_; ++k) multiplier_[k] = u[k];
        return;
      }
      drop(static_cast<int>(worst));
    }
    x_ = problem_.target;
  }

  void iterate() {
    const int limit = 20 * (n_ + problem_.rows + 1);
    while (true) {
      int worst = -1;
      double most = kViolation;
      for (int c = 0; c < constraints(); ++c) {
        const double v = violation(c);
        if (v > most && !is_active(c)) {
          most = v;
          worst = c;
        }
      }
      if (worst < 0) return;
      if (!satisfy(worst, limit)) return;
    }
  }

  /// Moves x until `c` holds, keeping the active ones; drops those whose multiplier would become negative.
  bool satisfy(int c, int limit) {
    double new_multiplier = 0.0;
    while (true) {
      if (++solution_.iterations > limit) {
        solution_.status = QpStatus::kIterationLimit;
        return false;
      }
      JointVector d(n_);
      project_normal(c, d);
      const double free_part = d.tail(n_ - active_).squaredNorm();  // zᵀa: how fast a primal step reduces the violation
      JointVector r = d.head(active_);
      R_.topLeftCorner(active_, active_).triangularView<Eigen::Upper>().solveInPlace(r);

      int blocking = -1;
      double dual_step = kInfinity;
      for (int k = 0; k < active_; ++k) {
        if (r[k] > kDependent && multiplier_[k] / r[k] < dual_step) {
          dual_step = multiplier_[k] / r[k];
          blocking = k;
        }
      }
      const bool primal_possible = free_part > kDependent;
      const double primal_step = primal_possible ? violation(c) / free_part : kInfinity;
      const double step = std::min(dual_step, primal_step);
      if (step == kInfinity) {
        solution_.status = QpStatus::kInfeasible;
        return false;
      }
      if (primal_possible) {
        x_.noalias() -= step * (J_.block(0, active_, n_, n_ - active_) * d.tail(n_ - active_));
      }
      for (int k = 0; k < active_; ++k) multiplier_[k] = std::max(0.0, multiplier_[k] - step * r[k]);
      new_multiplier += step;
      if (primal_possible && primal_step <= dual_step) {
        append(c, new_multiplier, d);
        return true;
      }
      drop(blocking);
    }
  }

  [[nodiscard]] std::uint32_t name(int c) const {
    return c < problem_.rows ? problem_.key[c] : kBoundKey + static_cast<std::uint32_t>(c - problem_.rows);
  }

  [[nodiscard]] int find(std::uint32_t key) const {
    if (key >= kBoundKey) {
      const auto bound = key - kBoundKey;
      return bound < static_cast<std::uint32_t>(2 * n_) ? problem_.rows + static_cast<int>(bound) : -1;
    }
    for (int i = 0; i < problem_.rows; ++i) {
      if (problem_.key[i] == key) return i;
    }
    return -1;
  }

  void publish(QpWarmStart& warm) {
    solution_.x = x_;
    solution_.active = active_;
    warm.count = active_;
    for (int k = 0; k < active_; ++k) {
      const int c = set_[k];
      warm.key[k] = name(c);
      const int bound = c - problem_.rows;
      const double unit = bound < 0 ? scale_[c] : 1.0;
      solution_.active_row[k] = bound < 0 ? c : (bound < n_ ? -1 - 2 * bound : -2 - 2 * (bound - n_));
      solution_.multiplier[k] = multiplier_[k] / unit;
    }
  }

  const QpProblem& problem_;
  const std::array<double, kMaxRows>& scale_;  ///< ‖g‖ of each row
  int n_;
  QpSolution& solution_;
  JointVector x_;
  Square J_;  ///< orthogonal; its first `active_` columns span the active normals
  Square R_;  ///< upper triangular: N = J₁ R
  int active_ = 0;
  std::array<int, kMaxJoints> set_{};
  std::array<double, kMaxJoints> multiplier_{};
};

}  // namespace

QpSolution solve(const QpProblem& problem, QpWarmStart& warm) {
  QpSolution solution;
  Solver(problem, solution).run(warm);
  return solution;
}

}  // namespace hecaton::planner
