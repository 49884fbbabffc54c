#pragma once
/// The point of a convex set that is nearest to the origin, from its support function: GJK [Gilbert88]. The
/// sub-algorithm tries every sub-simplex, and the result has a proved lower bound of the distance.
///
/// FCL's GJK fails when four support points are coplanar, or when a support point returns after its removal. These are
/// 0.1 % of random pairs of polytopes, with errors up to centimetres.

#include <array>
#include <cmath>

#include <Eigen/Core>

namespace hecaton::planner {

struct NearestPoint {
  std::array<Eigen::Vector3d, 4> direction;         ///< unit; the combination of their support points is nearest
  std::array<double, 4> weight{};                   ///< ≥ 0, sum 1
  int rank = 0;                                     ///< number of directions; 0: origin inside, or too near to tell
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< that combination: its norm bounds the distance from above [m]
  Eigen::Vector3d n = Eigen::Vector3d::Zero();      ///< unit, from the point to the origin
  double at_least = 0.0;                            ///< lower bound of the distance, proved by n [m]
};

namespace detail {

/// Weights of the point nearest to the origin in the hull of `old` points w₀ … and the newest one, which is part of the
/// solution. False when rounding hides any progress below `upper` [m].
inline bool nearest_in_simplex(const std::array<Eigen::Vector3d, 4>& w, int old, double upper,
                               std::array<double, 4>& weight) {
  constexpr double kIndependent = 1e-12;  // of determinants relative to their Hadamard bound; below, a face suffices
  // With the newest point c as origin and edges eᵢ = wᵢ − c, the nearest point c + Σ λᵢ eᵢ solves Eᵀ E λ = −Eᵀ c.
  const Eigen::Vector3d& c = w[old];
  std::array<Eigen::Vector3d, 3> e;
  std::array<double, 3> f{};
  std::array<std::array<double, 3>, 3> g{};
  for (int i = 0; i < old; ++i) {
    e[i] = w[i] - c;
    f[i] = -e[i].dot(c);
    for (int j = 0; j <= i; ++j) g[i][j] = g[j][i] = e[i].dot(e[j]);
  }
  double nearest2 = upper * upper;
  // Norms of the points themselves: the same from Gram products would lose small distances to cancellation.
  const auto take = [&](const Eigen::Vector3d& point) {
    const double distance2 = point.squaredNorm();
    if (distance2 >= nearest2) return false;
    nearest2 = distance2;
    weight.fill(0.0);
    return true;
  };
  bool found = take(c);
  if (found) weight[old] = 1.0;
  for (int i = 0; i < old; ++i) {
    if (f[i] <= 0.0 || f[i] >= g[i][i]) continue;
    const double lambda = f[i] / g[i][i];
    if (!take(c + lambda * e[i])) continue;
    weight[i] = lambda;
    weight[old] = 1.0 - lambda;
    found = true;
  }
  for (int i = 0; i < old; ++i) {
    for (int j = i + 1; j < old; ++j) {
      const double determinant = g[i][i] * g[j][j] - g[i][j] * g[i][j];
      if (determinant <= kIndependent * g[i][i] * g[j][j]) continue;
      const double a = g[j][j] * f[i] - g[i][j] * f[j];
      const double b = g[i][i] * f[j] - g[i][j] * f[i];
      if (a <= 0.0 || b <= 0.0 || a + b >= determinant) continue;
      const double lambda_i = a / determinant;
      const double lambda_j = b / determinant;
      if (!take(c + lambda_i * e[i] + lambda_j * e[j])) continue;
      weight[i] = lambda_i;
      weight[j] = lambda_j;
      weight[old] = 1.0 - lambda_i - lambda_j;
      found = true;
    }
  }
  if (old < 3) return found;
  const Eigen::Vector3d cross = e[1].cross(e[2]);
  const double volume = e[0].dot(cross);
  if (volume * volume <= kIndependent * g[0][0] * g[1][1] * g[2][2]) return found;
  const Eigen::Vector3d lambda =
      Eigen::Vector3d(c.dot(cross), c.dot(e[2].cross(e[0])), c.dot(e[0].cross(e[1]))) / -volume;
  if (lambda.minCoeff() < 0.0 || lambda.sum() > 1.0) return found;
  weight = {lambda[0], lambda[1], lambda[2], 1.0 - lambda.sum()};
  return true;
}

}  // namespace detail

/// `support(n)`: a point of the set that is farthest along the unit vector n. `start`: the first direction.
template <typename Support>
NearestPoint nearest_point(const Support& support, const Eigen::Vector3d& start) {
  constexpr int kIterations = 100;
  constexpr double kInside = 1e-10;  // [m]
  constexpr double kGap = 1e-10;     // between upper and lower bound [m]
  constexpr double kClearly = 1e-8;  // [m]

  std::array<Eigen::Vector3d, 4> w;
  NearestPoint best;
  const double length = start.norm();
  best.direction[0] = length > 0.0 ? Eigen::Vector3d(start / length) : Eigen::Vector3d::UnitX();
  best.weight[0] = 1.0;
  best.rank = 1;
  best.point = w[0] = support(best.direction[0]);
  double upper = best.point.norm();
  for (int iteration = 0; iteration < kIterations && upper > kInside; ++iteration) {
    const Eigen::Vector3d n = best.point / -upper;
    const Eigen::Vector3d newest = support(n);
    const double lower = -n.dot(newest);
    // The latest direction belongs to `point`; an earlier one is kept only where it proves clearly more.
    if (iteration == 0 || lower > best.at_least - kClearly) {
      best.at_least = lower;
      best.n = n;
    }
    if (upper - lower <= kGap) break;
    w[best.rank] = newest;
    best.direction[best.rank] = n;
    std::array<double, 4> weight{};
    if (!detail::nearest_in_simplex(w, best.rank, upper, weight)) break;
    int rank = 0;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (int i = 0; i <= best.rank; ++i) {
      if (weight[i] <= 0.0) continue;
      w[rank] = w[i];
      best.direction[rank] = best.direction[i];
      best.weight[rank] = weight[i];
      point += weight[i] * w[i];
      ++rank;
    }
    best.rank = rank;
    best.point = point;
    upper = rank == 4 ? 0.0 : point.norm();
  }
  if (upper <= kInside) best.rank = 0;
  return best;
}

}  // namespace hecaton::planner
