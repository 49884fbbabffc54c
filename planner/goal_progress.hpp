#pragma once
/// The progress of an arm towards its goal: the points of a planned route, and whether the distance still shrinks.

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "planner/local/goal_objective.hpp"

namespace hecaton::planner {

class Route {
 public:
  /// From now on by these points; the last one is the goal. Empty: straight to it.
  void take(std::vector<JointVector> points) {
    points_ = std::move(points);
    next_ = 0;
  }
  void leave() { take({}); }

  /// Points that the arm at q is near enough to count as passed.
  void pass(const JointLimits& limits, const JointVector& q) {
    while (under_way() && joint_difference(limits, q, points_[next_]).cwiseAbs().maxCoeff() < kPassed) ++next_;
  }
  /// There is a point to go to before the goal.
  [[nodiscard]] bool under_way() const { return next_ + 1 < points_.size(); }
  /// To go to now; only under way.
  [[nodiscard]] const JointVector& next() const { return points_[next_]; }
  /// What is left, up to the goal; empty when not under way.
  [[nodiscard]] std::span<const JointVector> left() const {
    return under_way() ? std::span(points_).subspan(next_) : std::span<const JointVector>();
  }
  /// From q by all points that are left [rad | m]; only under way.
  [[nodiscard]] double length(const JointLimits& limits, const JointVector& q) const {
    double sum = joint_difference(limits, q, next()).norm();
    for (std::size_t i = next_; i + 1 < points_.size(); ++i) {
      sum += joint_difference(limits, points_[i], points_[i + 1]).norm();
    }
    return sum;
  }

 private:
  static constexpr double kPassed = 0.1;  // every joint within this [rad | m]

  std::vector<JointVector> points_;
  std::size_t next_ = 0;
};

class ProgressMonitor {
 public:
  /// A new goal.
  void restart() { *this = {}; }

  /// One period of `dt` [s] at `distance` = ‖q_goal − q‖ [rad | m], in which the arm was free to plan.
  void note(double distance, double dt) {
    if (distance < kNearer * nearest_) {
      nearest_ = distance;
      without_progress_ = 0.0;
    } else {
      without_progress_ += dt;
    }
  }

  /// Since it was nearer than ever before [s].
  [[nodiscard]] double time_without_progress() const { return without_progress_; }
  /// There may be no way: it has looked for one so long.
  [[nodiscard]] bool stalled() const { return without_progress_ > kStallTimeout; }

 private:
  static constexpr double kNearer = 0.98;        // of the nearest so far
  static constexpr double kStallTimeout = 10.0;  // [s]

  double nearest_ = std::numeric_limits<double>::infinity();
  double without_progress_ = 0.0;
};

}  // namespace hecaton::planner
