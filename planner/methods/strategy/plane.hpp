#pragma once
/// The on-line stage of [Mediavilla02] on plain arrays: the plane of a strategy and the steps in it. Compiled once for
/// each instruction set (planner/simd), because the simulation of the off-line stage inlines it.

#include "planner/simd/lanes.hpp"

namespace hecaton::planner::HECATON_ISA {

/// Capacity in avoiding joints; equal to kMaxJoints of planner/model.
inline constexpr int kPlaneJoints = 16;

inline double dot_of(const double* a, const double* b, int n) {
  double sum = 0.0;
  for (int j = 0; j < n; ++j) sum += a[j] * b[j];
  return sum;
}

/// Order of the axes in Gram–Schmidt. Arms use the first order; the other two serve comparisons.
enum BasisOrder { kFromSecondAxis = 0, kFromLastAxis = 1, kFromFirstAxis = 2 };

inline int basis_axis(BasisOrder order, int k, int n) {
  if (order == kFromLastAxis) return n - 1 - k;
  return order == kFromFirstAxis ? k : (k + 1) % n;
}

/// Rows v₁ … v_{n−1}: see null_space_basis() in planner/methods/strategy/strategy.hpp.
inline void null_space(const double* u1, int n, double (*v)[kPlaneJoints], BasisOrder order = kFromSecondAxis) {
  constexpr double kLeast = 1e-6;
  int found = 0;
  for (int k = 0; k < n && found < n - 1; ++k) {
    double* w = v[found];
    for (int j = 0; j < n; ++j) w[j] = 0.0;
    w[basis_axis(order, k, n)] = 1.0;
    // Two passes limit rounding errors for nearly parallel axes.
    for (int pass = 0; pass < 2; ++pass) {
      const double along = dot_of(w, u1, n);
      for (int j = 0; j < n; ++j) w[j] -= along * u1[j];
      for (int i = 0; i < found; ++i) {
        const double part = dot_of(w, v[i], n);
        for (int j = 0; j < n; ++j) w[j] -= part * v[i][j];
      }
    }
    const double length = sqrt(dot_of(w, w, n));
    if (length < kLeast) continue;
    for (int j = 0; j < n; ++j) w[j] /= length;
    ++found;
  }
}

/// eq. 7: u₂ = λ (v₁ + α v₂ + β v₃ + …) / √(1 + α² + β² + …).
inline void strategy_direction(const double* u1, int n, const double* coefficients, double direction, double* u2,
                               BasisOrder order = kFromSecondAxis) {
  double v[kPlaneJoints][kPlaneJoints] = {};
  null_space(u1, n, v, order);
  double squares = 1.0;
  for (int j = 0; j < n; ++j) u2[j] = v[0][j];
  for (int i = 0; i + 2 < n; ++i) {
    squares += coefficients[i] * coefficients[i];
    for (int j = 0; j < n; ++j) u2[j] += coefficients[i] * v[i + 1][j];
  }
  const double scale = direction / sqrt(squares);
  for (int j = 0; j < n; ++j) u2[j] *= scale;
}

/// A point of the plane: q = q_I + x u₁ + y u₂.
struct PlanePoint {
  double x = 0.0;
  double y = 0.0;
};

/// The position of the arm in its plane, and the side to which it turns.
struct PlaneState {
  PlanePoint at;
  double side = 1.0;  ///< 1: as in the strategy; −1: the local direction is reversed
};

/// The direction uᶠ = (a, b) towards the goal (distance, 0). The direction uᵀ across it is (−b, a), which is u₂ on the
/// straight line.
struct PlaneFrame {
  double a = 1.0;
  double b = 0.0;
  double left = 0.0;  ///< distance to the goal [rad]
};

inline PlaneFrame plane_frame(const PlanePoint& at, double distance) {
  const double x = distance - at.x;
  const double y = -at.y;
  if (y == 0.0 && x > 0.0) return {1.0, 0.0, x};  // shortcut on the straight line
  const double left = sqrt(x * x + y * y);
  if (!(left > 0.0)) return {};
  return {x / left, y / left, left};
}

inline constexpr int kNeighbours = 5;
/// Offsets of the neighbours in steps along uᶠ and uᵀ, in the order of the paper's list. By "closest to its objective"
/// the fifth would precede the fourth.
inline constexpr double kForward[kNeighbours] = {1.0, 1.0, 0.0, -1.0, -1.0};
inline constexpr double kSideways[kNeighbours] = {0.0, 1.0, 1.0, 1.0, 0.0};

/// The k-th neighbour. A step towards the goal ends there.
inline PlanePoint neighbour(const PlaneState& state, const PlaneFrame& frame, double distance, double step, int k) {
  if (k == 0 && frame.left <= step) return {distance, 0.0};
  const double f = step * kForward[k];
  const double t = step * kSideways[k] * state.side;
  return {state.at.x + f * frame.a - t * frame.b, state.at.y + f * frame.b + t * frame.a};
}

}  // namespace hecaton::planner::HECATON_ISA
