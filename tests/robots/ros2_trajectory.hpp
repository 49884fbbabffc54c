#pragma once
/// What a joint trajectory controller takes and follows: trajectories, and points between their points.

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include <idl/ros2/ros2PubSubTypes.h>

#include "tests/robots/ros2_messages.hpp"

namespace hecaton::test::ros2 {

struct Point {
  double at = 0.0;  // [s]
  Values q;
  Values qd;  // empty: none
};

inline Point between(const Point& a, const Point& b, double at) {
  const double T = b.at - a.at;
  if (at >= b.at || T <= 0.0) return {at, b.q, b.qd};
  const double t = at - a.at;
  Point result{at, Values(a.q.size()), Values(a.q.size())};
  for (std::size_t j = 0; j < a.q.size(); ++j) {
    const double d = b.q[j] - a.q[j];
    if (a.qd.empty() || b.qd.empty()) {
      result.q[j] = a.q[j] + d * t / T;
      result.qd[j] = d / T;
      continue;
    }
    const double c2 = (3 * d - (2 * a.qd[j] + b.qd[j]) * T) / (T * T);
    const double c3 = (-2 * d + (a.qd[j] + b.qd[j]) * T) / (T * T * T);
    result.q[j] = a.q[j] + t * (a.qd[j] + t * (c2 + t * c3));
    result.qd[j] = a.qd[j] + t * (2 * c2 + 3 * t * c3);
  }
  return result;
}

/// A trajectory as it comes from the network.
struct Received {
  struct Point {
    double at = 0.0;  // [s]
    Values q, qd, qdd, effort;
  };
  Names names;
  std::vector<Point> points;
  bool begins_later = false;  // it has a start time
};

inline Received received(const trajectory_msgs_msg_dds__JointTrajectory_& message) {
  Received result{copy(message.joint_names), {}, message.header.stamp.sec != 0 || message.header.stamp.nanosec != 0};
  for (std::uint32_t i = 0; i < message.points._length; ++i) {
    const auto& from = message.points._buffer[i];
    result.points.push_back({seconds(from.time_from_start), copy(from.positions), copy(from.velocities),
                             copy(from.accelerations), copy(from.effort)});
  }
  return result;
}

inline Received received(const trajectory_msgs::msg::JointTrajectory& message) {
  const auto& stamp = message.header().stamp();
  Received result{message.joint_names(), {}, stamp.sec() != 0 || stamp.nanosec() != 0};
  for (const auto& from : message.points()) {
    result.points.push_back({from.time_from_start().sec() + 1e-9 * from.time_from_start().nanosec(), from.positions(),
                             from.velocities(), from.accelerations(), from.effort()});
  }
  return result;
}

/// Throws a sentence for a trajectory that the controller refuses. Its points in the order of `joints`.
inline std::vector<Point> accepted_points(const Received& message, const Names& joints) {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw std::runtime_error(what);
  };
  const Names& names = message.names;
  require(!names.empty(), "no joint names");
  require(
      std::set(names.begin(), names.end()) == std::set(joints.begin(), joints.end()) && names.size() == joints.size(),
      "other joints, or a part of them (allow_partial_joints_goal is false)");
  require(!message.points.empty(), "an empty trajectory");
  std::vector<Point> points;
  for (const Received::Point& from : message.points) {
    const auto fits = [&](const Values& values) { return values.empty() || values.size() == names.size(); };
    require(from.q.size() == names.size(), "a point without all positions");
    require(fits(from.qd) && fits(from.qdd) && from.effort.empty(), "wrong sizes of a point");
    Point point{from.at, Values(names.size()), {}};
    require(points.empty() || point.at > points.back().at, "times do not increase");
    if (!from.qd.empty()) point.qd.resize(names.size());
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const auto place = static_cast<std::size_t>(std::find(names.begin(), names.end(), joints[j]) - names.begin());
      point.q[j] = from.q[place];
      if (!point.qd.empty()) point.qd[j] = from.qd[place];
    }
    points.push_back(std::move(point));
  }
  const Values& last = points.back().qd;
  require(std::all_of(last.begin(), last.end(), [](double v) { return std::abs(v) <= 1e-12; }),
          "the last point has a velocity (allow_nonzero_velocity_at_trajectory_end is false)");
  require(!message.begins_later, "a start time: not simulated");
  return points;
}

struct Trajectory {
  std::vector<Point> points;
  std::optional<Point> before;
  double at = 0.0;
};

}  // namespace hecaton::test::ros2
