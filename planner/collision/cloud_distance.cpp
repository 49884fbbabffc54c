#include "planner/collision/cloud_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/collision/exact_distance.hpp"

namespace hecaton::planner {
namespace {

using Eigen::Vector3d;
using world::kPointFan;
using world::PointBox;
using world::PointCloud;
using world::PointLeaf;
using world::PointNode;
using world::Pose;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A ball is behind a plane if it reaches through by less than this share of its distance, or this much [m]: a camera's
/// points are not flat.
constexpr double kThroughShare = 0.25;
constexpr double kThrough = 0.01;

/// The ball that gave a plane is behind it, whatever the rounding [m].
constexpr double kRounding = 1e-9;

/// Rounded outwards.
float lower(double x) {
  return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity());
}
float upper(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

/// The balls whose centres x have n · x ≥ offset, in the cloud's frame.
struct HalfSpaceOfBalls {
  Vector3d n;
  double offset;
};

/// A body in the frame P of a cloud, and the search for the ball nearest to it.
class BallSearch {
 public:
  BallSearch(const PlacedBody& a, const PointCloud& cloud, const Pose& X_WP)
      : cloud_(cloud),
        core_(a.core),
        X_PS_(X_WP.inverse(Eigen::Isometry) * a.X_WS),
        reach_(cloud.radius() + core_.radius) {
    Vector3d low;
    Vector3d high;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d n = X_PS_.linear().row(axis).transpose();
      high[axis] = n.dot(farthest(core_, n)) + X_PS_.translation()[axis];
      low[axis] = n.dot(farthest(core_, -n)) + X_PS_.translation()[axis];
      box_.low[axis] = lower(low[axis]);
      box_.high[axis] = upper(high[axis]);
      const Vector3d unit = Vector3d::Unit(axis);
      high_S_[axis] = farthest(core_, unit)[axis];
      low_S_[axis] = farthest(core_, -unit)[axis];
    }
    if (core_.core == Core::kSegment) {
      const Vector3d half = core_.half.z() * X_PS_.linear().col(2);
      p_ = X_PS_.translation() - half;
      d_ = 2.0 * half;
    } else {
      p_ = X_PS_.translation();
      d_ = Vector3d::Zero();
    }
    const double length2 = d_.squaredNorm();
    per_length2_ = length2 > 0.0 ? 1.0 / length2 : 0.0;
  }

  /// The nearest ball that no plane hides and that is nearer than `limit`.
  bool find(double limit, std::span<const HalfSpaceOfBalls> hidden) {
    hidden_ = hidden;
    best_ = limit;
    found_ = false;
    search(cloud_.nodes().front());
    return found_;
  }
  /// What find() has found, in P: a is the body, b the ball.
  [[nodiscard]] ShapeDistance answer() const {
    const SweptCore ball{Core::kPoint, cloud_.radius(), Vector3d::Zero(), Vector3d::Zero(), {}};
    return prepared_distance(core_, X_PS_, ball, Pose(Eigen::Translation3d(nearest_)));
  }
  [[nodiscard]] const Vector3d& centre() const { return nearest_; }

 private:
  [[nodiscard]] bool thin() const { return core_.core <= Core::kSegment; }

  [[nodiscard]] bool hides(const Vector3d& x) const {
    return std::any_of(hidden_.begin(), hidden_.end(),
                       [&](const HalfSpaceOfBalls& plane) { return plane.n.dot(x) >= plane.offset; });
  }
  /// All points in the box of the child are hidden by one plane.
  [[nodiscard]] bool hides_all(const PointNode& node, int k) const {
    return std::any_of(hidden_.begin(), hidden_.end(), [&](const HalfSpaceOfBalls& plane) {
      double least = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        const double n = plane.n[axis];
        least += n * static_cast<double>(n > 0.0 ? node.low[axis][k] : node.high[axis][k]);
      }
      return least >= plane.offset;
    });
  }
  /// Lower bound of the distance of balls in a box with this gap from the core's box.
  [[nodiscard]] double bound(float gap2) const {
    if (gap2 <= 0.0F && !thin()) return -kInfinity;
    return std::sqrt(static_cast<double>(gap2)) - reach_;
  }

  void search(const PointNode& node) {
    float gaps2[kPointFan];
    world::squared_gaps(node, box_, gaps2);
    // Near children first.
    int order[kPointFan];
    int count = 0;
    for (int k = 0; k < node.count; ++k) {
      if (bound(gaps2[k]) >= best_) continue;
      int place = count++;
      for (; place > 0 && gaps2[order[place - 1]] > gaps2[k]; --place) order[place] = order[place - 1];
      order[place] = k;
    }
    for (int i = 0; i < count; ++i) {
      const int k = order[i];
      if (bound(gaps2[k]) >= best_) return;
      if (hides_all(node, k)) continue;
      const int child = node.child[k];
      if (child >= 0) {
        search(cloud_.nodes()[static_cast<std::size_t>(child)]);
      } else {
        scan(cloud_.leaves()[static_cast<std::size_t>(~child)]);
      }
    }
  }

  void scan(const PointLeaf& leaf) {
    for (int k = 0; k < leaf.count; ++k) {
      const Vector3d x(static_cast<double>(leaf.p[0][k]), static_cast<double>(leaf.p[1][k]),
                       static_cast<double>(leaf.p[2][k]));
      if (!hidden_.empty() && hides(x)) continue;
      const double distance = thin() ? distance_of_thin(x) : distance_of(x);
      if (distance >= best_) continue;
      best_ = distance;
      nearest_ = x;
      found_ = true;
    }
  }

  [[nodiscard]] double distance_of_thin(const Vector3d& x) const {
    const Vector3d way = x - p_;
    const double t = std::clamp(way.dot(d_) * per_length2_, 0.0, 1.0);
    return (way - t * d_).norm() - reach_;
  }
  [[nodiscard]] double distance_of(const Vector3d& x) const {
    // The box of the core in its own frame bounds the distance.
    const Vector3d x_S = X_PS_.linear().transpose() * (x - X_PS_.translation());
    const double gap = (low_S_ - x_S).cwiseMax(x_S - high_S_).cwiseMax(0.0).norm();
    if (gap > 0.0 && gap - reach_ >= best_) return kInfinity;
    const SweptCore ball{Core::kPoint, cloud_.radius(), Vector3d::Zero(), Vector3d::Zero(), {}};
    return prepared_distance(core_, X_PS_, ball, Pose(Eigen::Translation3d(x))).distance;
  }

  const PointCloud& cloud_;
  const SweptCore& core_;
  Pose X_PS_;
  double reach_;  ///< both radii [m]
  PointBox box_{};
  Vector3d low_S_;
  Vector3d high_S_;
  Vector3d p_;  ///< one end of a thin core
  Vector3d d_;  ///< from there to the other
  double per_length2_ = 0.0;
  std::span<const HalfSpaceOfBalls> hidden_;
  double best_ = 0.0;
  bool found_ = false;
  Vector3d nearest_ = Vector3d::Zero();
};

ShapeDistance in_world(const ShapeDistance& in_P, const Pose& X_WP) {
  return {in_P.distance, X_WP * in_P.p_a_W, X_WP * in_P.p_b_W, X_WP.linear() * in_P.n_W};
}

}  // namespace

ShapeDistance cloud_distance(const PlacedBody& a, const PointCloud& cloud, const Pose& X_WP, double limit) {
  BallSearch search(a, cloud, X_WP);
  if (search.find(limit, {})) return in_world(search.answer(), X_WP);
  ShapeDistance far;
  far.distance = kInfinity;
  return far;
}

int nearest_balls(const PlacedBody& a, const PointCloud& cloud, const Pose& X_WP, double limit,
                  std::span<ShapeDistance> out) {
  BallSearch search(a, cloud, X_WP);
  HalfSpaceOfBalls planes[kMostBallPairs];
  const int most = std::min(static_cast<int>(out.size()), kMostBallPairs);
  int count = 0;
  while (count < most && search.find(limit, std::span(planes).first(static_cast<std::size_t>(count)))) {
    const ShapeDistance found = search.answer();
    const double through = std::min(kThrough, kThroughShare * std::max(found.distance, 0.0));
    planes[count] = {found.n_W, found.n_W.dot(search.centre()) - through - kRounding};
    out[static_cast<std::size_t>(count++)] = in_world(found, X_WP);
  }
  return count;
}

}  // namespace hecaton::planner
