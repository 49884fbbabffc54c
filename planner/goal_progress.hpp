#pragma once
/// The progress of an arm towards its goal: along the points of a planned route, and by its distance.

#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "planner/local/goal_objective.hpp"
#include "planner/model/memory_archive.hpp"

namespace hecaton::planner {

/// The points that a global planner found, and the next one to visit.
class Route {
 public:
  /// Replaces the route. The last point is the goal. Empty: no route.
  void take(std::vector<JointVector> points) {
    points_ = std::move(points);
    next_ = 0;
  }

  /// Skips the points that are near `q` [rad | m].
  void pass(const JointLimits& limits, const JointVector& q) {
    while (under_way() && joint_difference(limits, q, points_[next_]).cwiseAbs().maxCoeff() < kPassed) ++next_;
  }
  /// True while a point remains before the goal.
  [[nodiscard]] bool under_way() const { return next_ + 1 < points_.size(); }
  /// The next point [rad | m]. Precondition: under_way().
  [[nodiscard]] const JointVector& next() const { return points_[next_]; }
  /// The remaining points up to the goal; empty when not under way.
  [[nodiscard]] std::span<const JointVector> left() const {
    return under_way() ? std::span(points_).subspan(next_) : std::span<const JointVector>();
  }
  /// Length from q along all remaining points [rad | m]. Precondition: under_way().
  [[nodiscard]] double length(const JointLimits& limits, const JointVector& q) const {
    double sum = joint_difference(limits, q, next()).norm();
    for (std::size_t i = next_; i + 1 < points_.size(); ++i) {
      sum += joint_difference(limits, points_[i], points_[i + 1]).norm();
    }
    return sum;
  }

  void describe(MemoryArchive& archive) {
    archive.list(points_, archive);
    auto next = static_cast<int>(next_);
    archive.number(next, 0, static_cast<std::int64_t>(points_.size()));
    next_ = static_cast<std::size_t>(next);
  }

 private:
  static constexpr double kPassed = 0.1;  // every joint within this [rad | m]

  std::vector<JointVector> points_;
  std::size_t next_ = 0;
};

/// Measures for how long the distance to the goal has not shrunk. An arm that follows boundaries may move forever
/// without progress.
class ProgressMonitor {
 public:
  /// Call for a new goal.
  void restart() { *this = {}; }

  /// Notes one period of `dt` [s] at `distance` = ‖q_goal − q‖ [rad | m]. Call only while the arm is free to plan.
  void note(double distance, double dt) {
    if (distance < kNearer * nearest_) {
      nearest_ = distance;
      without_progress_ = 0.0;
    } else {
      without_progress_ += dt;
    }
  }

  /// Notes one period of `dt` [s] on a trajectory, whose distance from its end may grow.
  void note_motion(bool moves, double dt) { without_progress_ = moves ? 0.0 : without_progress_ + dt; }

  /// Time since the distance was last at least 2 % below its previous minimum [s].
  [[nodiscard]] double time_without_progress() const { return without_progress_; }
  /// True after 10 s without progress: there may be no path.
  [[nodiscard]] bool stalled() const { return without_progress_ > kStallTimeout; }

  void describe(MemoryArchive& archive) { archive(nearest_, without_progress_); }

 private:
  static constexpr double kNearer = 0.98;        // of the minimum so far
  static constexpr double kStallTimeout = 10.0;  // [s]

  double nearest_ = std::numeric_limits<double>::infinity();
  double without_progress_ = 0.0;
};

}  // namespace hecaton::planner
