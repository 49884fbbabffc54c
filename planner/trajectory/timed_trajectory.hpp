#pragma once
/// A joint trajectory with times, as a client sends it, and its interpolation.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planner/model/limits.hpp"
#include "planner/model/memory_archive.hpp"
#include "planner/trajectory/set_point_interpolator.hpp"

namespace hecaton::planner {

struct TimedPoint {
  double time = 0.0;  ///< since the start of the trajectory [s]
  JointVector q;      ///< [rad | m]
  JointVector qd;     ///< [rad/s | m/s]; empty: not given
  JointVector qdd;    ///< [rad/s² | m/s²]; empty: not given

  void describe(MemoryArchive& archive) { archive(time, q, qd, qdd); }
};

/// The state between two points. Linear without velocities, cubic with them, quintic with accelerations, too, as a
/// joint_trajectory_controller of ROS 2 interpolates. `time` is within the times of the points.
[[nodiscard]] JointState interpolate(const TimedPoint& from, const TimedPoint& to, double time);

/// Immutable once a goal has it: planners, standby planners and rollouts share it.
struct TimedTrajectory {
  static constexpr std::size_t kMostPoints = 4096;   ///< of one trajectory
  static constexpr std::size_t kMostValues = 32768;  ///< points times joints

  std::vector<TimedPoint> points;  ///< at least one; times grow; the last one is at rest
  JointVector path_tolerance;      ///< [rad | m]; infinite: this joint has none; empty: no joint has one

  [[nodiscard]] double duration() const { return points.back().time; }
  [[nodiscard]] const JointVector& end() const { return points.back().q; }
  /// The arm must stay near the path, and may not go around what blocks it.
  [[nodiscard]] bool has_path_tolerance() const;
  /// Index of the first point after `time`; the number of points when there is none.
  [[nodiscard]] std::size_t next_point(double time) const;
  /// The state at `time`, which is cut to the times of the points. At rest before the first and after the last.
  [[nodiscard]] JointState at(double time) const;

  void describe(MemoryArchive& archive) {
    archive.list(points, archive);
    archive(path_tolerance);
  }
};

/// Why an arm cannot follow `trajectory`, as one sentence: its sizes, times, values, limits, or the velocity at its
/// end. Nothing: it can.
[[nodiscard]] std::optional<std::string> objection(const TimedTrajectory& trajectory, const JointLimits& limits,
                                                   const std::vector<std::string>& joint_names);

}  // namespace hecaton::planner
