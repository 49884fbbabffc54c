#pragma once
/// Values to messages and back. What comes from the wire is checked (finite numbers, sizes, unit quaternions, indices):
/// a message that cannot be used is refused with one sentence, never with an exception.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <idl/common.h>
#include <idl/world.h>

#include "planner/model/limits.hpp"
#include "planner/model/range_sensor.hpp"
#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"
#include "world/sim/contact_referee.hpp"

namespace hecaton::bus {

/// A value, or the sentence that says why there is none.
template <class V>
struct [[nodiscard]] Converted {
  std::optional<V> value;
  std::string error;

  explicit operator bool() const { return value.has_value(); }
  const V& operator*() const { return *value; }
  const V* operator->() const { return &*value; }
};

[[nodiscard]] std::vector<double> to_message(const planner::JointVector& q);
[[nodiscard]] msg::Vec3 to_message(const Eigen::Vector3d& vector);
[[nodiscard]] msg::Pose to_message(const world::Pose& pose);
[[nodiscard]] msg::Twist to_message(const world::Twist& twist);
[[nodiscard]] msg::PlacedShape to_message(const world::PlacedShape& shape);
[[nodiscard]] msg::Motion to_message(const world::Motion& motion);
[[nodiscard]] msg::Obstacle to_message(const world::Obstacle& obstacle);
[[nodiscard]] msg::Separation to_message(const world::Separation& separation);

/// `obstacles` in the order of the snapshot. Throws std::invalid_argument when their numbers differ.
/// Term and stamp are left to the caller.
[[nodiscard]] msg::ObstacleStates to_message(const world::ObstacleSnapshot& snapshot,
                                             std::span<const world::Obstacle> obstacles);

/// Names, number and stamp are left to the caller.
[[nodiscard]] msg::RangeScan to_message(const planner::RangeScan& scan, const planner::RangeSensor& sensor);

/// `what` names the value in the sentence, e.g. "ArmState of arm1: q". `size`: number of joints, −1: any up to
/// kMaxJoints.
Converted<planner::JointVector> joints_from_message(const std::vector<double>& values, const std::string& what,
                                                    int size = -1);
Converted<Eigen::Vector3d> from_message(const msg::Vec3& vector, const std::string& what);
Converted<world::Pose> from_message(const msg::Pose& pose, const std::string& what);
Converted<world::Twist> from_message(const msg::Twist& twist, const std::string& what);
Converted<world::PlacedShape> from_message(const msg::PlacedShape& shape, const std::string& what);
Converted<world::Motion> from_message(const msg::Motion& motion, const std::string& what);
/// Names the obstacle in its sentences.
Converted<world::Obstacle> from_message(const msg::Obstacle& obstacle);
Converted<world::Separation> from_message(const msg::Separation& separation, const std::string& what);

/// Names the sensor in its sentences.
Converted<std::vector<planner::RangeReading>> from_message(const msg::RangeScan& scan);

struct NamedSnapshot {
  world::ObstacleSnapshot snapshot;
  std::vector<std::string> names;  ///< of the states, same order
};
/// `age`: since the message arrived, on the reader's clock [s].
Converted<NamedSnapshot> from_message(const msg::ObstacleStates& states, double age);

/// "static", "waypoints", "circle", "sine", "conveyor" or "dynamic".
[[nodiscard]] std::string motion_name(msg::MotionKind kind);
/// "box 0.4 × 0.4 × 0.2 m" (full sizes), for people.
[[nodiscard]] std::string shape_text(const msg::PlacedShape& shape);

}  // namespace hecaton::bus
