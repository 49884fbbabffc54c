#pragma once
/// Conversion of planner and world values to messages and back. `from_message` checks the message (finite numbers,
/// sizes, unit quaternions, indices) and returns one sentence for an unusable one; it never throws. All functions are
/// pure and thread-safe.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <idl/common.h>
#include <idl/goal.h>
#include <idl/world.h>

#include "planner/model/limits.hpp"
#include "planner/model/range_sensor.hpp"
#include "planner/model/tool_goal.hpp"
#include "planner/trajectory/timed_trajectory.hpp"
#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::messages {

/// A value, or a sentence that says why there is none.
template <class V>
struct [[nodiscard]] Converted {
  std::optional<V> value;
  std::string error;

  explicit operator bool() const { return value.has_value(); }
  const V& operator*() const { return *value; }
  const V* operator->() const { return &*value; }
};

[[nodiscard]] std::vector<double> to_message(const planner::JointVector& q);
/// Writes into a field of a reused message; allocates only while the field grows. For messages of each period.
void to_message(const planner::JointVector& q, std::vector<double>& field);
[[nodiscard]] msg::Vec3 to_message(const Eigen::Vector3d& vector);
[[nodiscard]] msg::Pose to_message(const world::Pose& pose);
[[nodiscard]] msg::Twist to_message(const world::Twist& twist);
[[nodiscard]] msg::ToolGoal to_message(const planner::ToolGoal& goal);
[[nodiscard]] msg::TimedTrajectory to_message(const planner::TimedTrajectory& trajectory);
[[nodiscard]] msg::PlacedShape to_message(const world::PlacedShape& shape);
[[nodiscard]] msg::Motion to_message(const world::Motion& motion);
[[nodiscard]] msg::Obstacle to_message(const world::Obstacle& obstacle);
[[nodiscard]] msg::Separation to_message(const world::Separation& separation);

/// `obstacles` in the order of the snapshot. Throws std::invalid_argument when their numbers differ. The caller sets
/// term and stamp.
[[nodiscard]] msg::ObstacleStates to_message(const world::ObstacleSnapshot& snapshot,
                                             std::span<const world::Obstacle> obstacles);

/// The caller sets names, sequence number and stamp.
[[nodiscard]] msg::RangeScan to_message(const planner::RangeScan& scan, const planner::RangeSensor& sensor);

/// The name of a value for a sentence, in up to three parts ("ArmState of ", arm, ": q") that are joined only when
/// needed. It refers to its parts and must not outlive the call that it is passed to.
class ValueName {
 public:
  ValueName(const char* whole) : parts_{whole} {}         // NOLINT(google-explicit-constructor)
  ValueName(const std::string& whole) : parts_{whole} {}  // NOLINT(google-explicit-constructor)
  ValueName(std::string_view first, std::string_view second, std::string_view third) : parts_{first, second, third} {}

  [[nodiscard]] std::string text() const { return std::string(parts_[0]).append(parts_[1]).append(parts_[2]); }

 private:
  std::array<std::string_view, 3> parts_;
};

/// `size`: expected number of joints; -1: any up to kMaxJoints. Allocates only when it refuses the values.
Converted<planner::JointVector> joints_from_message(std::span<const double> values, const ValueName& what,
                                                    int size = -1);
Converted<Eigen::Vector3d> from_message(const msg::Vec3& vector, const std::string& what);
Converted<world::Pose> from_message(const msg::Pose& pose, const std::string& what);
/// Tolerances of 0 become the defaults.
Converted<planner::ToolGoal> from_message(const msg::ToolGoal& goal, const std::string& what);
/// Checks sizes and times; planner::objection() checks it against an arm.
Converted<planner::TimedTrajectory> from_message(const msg::TimedTrajectory& trajectory, const std::string& what,
                                                 int joints);
Converted<world::Twist> from_message(const msg::Twist& twist, const std::string& what);
Converted<world::PlacedShape> from_message(const msg::PlacedShape& shape, const std::string& what);
Converted<world::Motion> from_message(const msg::Motion& motion, const std::string& what);
/// Its sentences name the obstacle.
Converted<world::Obstacle> from_message(const msg::Obstacle& obstacle);
Converted<world::Separation> from_message(const msg::Separation& separation, const std::string& what);

/// Its sentences name the sensor.
Converted<std::vector<planner::RangeReading>> from_message(const msg::RangeScan& scan);

struct NamedSnapshot {
  world::ObstacleSnapshot snapshot;
  std::vector<std::string> names;  ///< of the states, in the same order
};
/// `age`: time since the message's arrival, on the reader's clock [s].
Converted<NamedSnapshot> from_message(const msg::ObstacleStates& states, double age);

}  // namespace hecaton::messages
