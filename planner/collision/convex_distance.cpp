#include "planner/collision/convex_distance.hpp"

#include "planner/collision/expanding_polytope.hpp"
#include "planner/collision/nearest_point.hpp"

namespace hecaton::planner {
namespace {

using Eigen::Vector3d;

/// Cores nearer than this [m] count as overlapping: the direction between nearest points is too noisy.
constexpr double kCoreTouching = 1e-6;
/// Overlapping cores are moved apart by this more than their depth, to find their deepest points from outside [m].
constexpr double kApart = 1e-4;
/// A direction must be this much better to replace another [m].
constexpr double kBetter = 1e-8;
constexpr int kPolishRounds = 4;

/// A ⊖ B in the frame of a, B moved by a shift.
class Difference {
 public:
  Difference(const SweptCore& a, const world::Pose& X_WA, const SweptCore& b, const world::Pose& X_WB)
      : a_(a),
        b_(b),
        R_AB_(X_WA.linear().transpose() * X_WB.linear()),
        p_AB_(X_WA.linear().transpose() * (X_WB.translation() - X_WA.translation())) {}

  void shift(const Vector3d& by) { p_AB_ += by; }
  [[nodiscard]] Vector3d between_centres() const { return p_AB_ + R_AB_ * b_.centre - a_.centre; }
  [[nodiscard]] Vector3d support(const Vector3d& n) const {
    return farthest(a_, n) - R_AB_ * farthest(b_, -(R_AB_.transpose() * n)) - p_AB_;
  }
  [[nodiscard]] Vector3d support_of_a(const Vector3d& n) const { return farthest(a_, n); }

 private:
  const SweptCore& a_;
  const SweptCore& b_;
  Eigen::Matrix3d R_AB_;
  Vector3d p_AB_;
};

/// A ⊖ what B sweeps, in the frame of a.
class SweptDifference {
 public:
  SweptDifference(const Difference& begin, const Vector3d& way, const Sweep& sweep)
      : begin_(begin), way_(way), radius_begin_(sweep.radius_begin), radius_end_(sweep.radius_end) {}

  [[nodiscard]] Vector3d between_centres() const { return begin_.between_centres() + 0.5 * way_; }
  [[nodiscard]] Vector3d support(const Vector3d& n) const {
    const Vector3d at_begin = begin_.support(n);
    const bool end_is_farther = radius_end_ - n.dot(way_) > radius_begin_;
    return end_is_farther ? Vector3d(at_begin - way_ + radius_end_ * n) : Vector3d(at_begin + radius_begin_ * n);
  }
  [[nodiscard]] Vector3d support_of_a(const Vector3d& n) const { return begin_.support_of_a(n); }

 private:
  const Difference& begin_;
  Vector3d way_;
  double radius_begin_;
  double radius_end_;
};

/// In the frame of a.
struct Answer {
  double distance = 0.0;            ///< proved by n [m]
  Vector3d n = Vector3d::Zero();    ///< from a to b
  Vector3d p_a = Vector3d::Zero();  ///< nearest point on a
};

/// Distance 0: overlapping, or too near to tell.
template <class AnyDifference>
Answer separation(const AnyDifference& difference) {
  const NearestPoint nearest =
      nearest_point([&](const Vector3d& n) { return difference.support(n); }, difference.between_centres());
  if (nearest.rank == 0 || nearest.at_least <= 0.0) return {};
  Answer answer{nearest.at_least, nearest.n, Vector3d::Zero()};
  for (int i = 0; i < nearest.rank; ++i) {
    answer.p_a += nearest.weight[i] * difference.support_of_a(nearest.direction[i]);
  }
  return answer;
}

Answer penetration(const Difference& difference, const Answer& touching) {
  ExpandingPolytope polytope;
  LeastDepth best = polytope.least_depth([&](const Vector3d& n) { return difference.support(n); });
  if (-touching.distance < best.depth && touching.distance > 0.0) {
    best.depth = -touching.distance;
    best.n = touching.n;
  }
  // The cores, moved apart along the best direction, give the direction of their nearest points. It is the same if that
  // was a minimum, and mostly a better one if the polytope was full before it was exact.
  Vector3d p_a = difference.support_of_a(best.n);
  for (int round = 0; round < kPolishRounds; ++round) {
    Difference parted = difference;
    parted.shift((best.depth + kApart) * best.n);
    const Answer apart = separation(parted);
    if (apart.distance <= 0.0) break;
    const double depth = apart.n.dot(difference.support(apart.n));
    p_a = apart.p_a;
    if (depth >= best.depth - kBetter) break;
    best.depth = depth;
    best.n = apart.n;
  }
  return {-best.depth, best.n, p_a};
}

ShapeDistance in_world(const Answer& answer, const world::Pose& X_WA) {
  ShapeDistance result;
  result.distance = answer.distance;
  result.n_W = X_WA.linear() * answer.n;
  result.p_a_W = X_WA * answer.p_a;
  result.p_b_W = result.p_a_W + result.distance * result.n_W;
  return result;
}

}  // namespace

ShapeDistance convex_distance(const SweptCore& a, const world::Pose& X_WA, const SweptCore& b,
                              const world::Pose& X_WB) {
  const Difference difference(a, X_WA, b, X_WB);
  Answer answer = separation(difference);
  if (answer.distance <= kCoreTouching) answer = penetration(difference, answer);
  return in_world(answer, X_WA);
}

ShapeDistance sweep_distance(const SweptCore& a, const world::Pose& X_WA, const SweptCore& b, const world::Pose& X_WB,
                             const Sweep& sweep) {
  const Difference begin(a, X_WA, b, X_WB);
  return in_world(separation(SweptDifference(begin, X_WA.linear().transpose() * sweep.way_W, sweep)), X_WA);
}

}  // namespace hecaton::planner
