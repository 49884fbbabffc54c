#pragma once
/// The pose of a scripted obstacle at an instant of its script: a pure function of obstacle and time. Every process
/// that knows the scene and the world's time therefore knows the obstacle's pose.

#include <vector>

#include "world/model/pose.hpp"
#include "world/model/scene.hpp"

namespace hecaton::world {

struct MotionState {
  Pose X_WO = Pose::Identity();
  Twist velocity;  ///< of the origin of O, in W
};

/// True for motions that follow a script (waypoints, circle, sine, conveyor); false for static and dynamic ones.
[[nodiscard]] bool is_scripted(const Motion& motion);

/// Pose and velocity at `time` [s] of the script (any finite value; scripts also extend to negative times).
///
/// - static: the obstacle's own pose, at rest. Dynamic: its own pose and initial velocity, whatever the time.
/// - waypoints: at poses_W.front() at time 0; the obstacle's own pose plays no part.
/// - circle, conveyor: at the obstacle's own pose at time 0. Sine: around the obstacle's own pose.
///
/// The velocity is the derivative of the pose where that exists. At a waypoint it is the velocity at the beginning of
/// the next line. A conveyor's restart is a jump without velocity: its twist is always direction · speed.
[[nodiscard]] MotionState motion_at(const Obstacle& obstacle, double time);

/// The period of the script [s]; 0 when the obstacle stands or is not scripted.
[[nodiscard]] double script_period(const Obstacle& obstacle);

/// The greatest acceleration of the obstacle's origin during the script [m/s²]; 0 without script. Corners at waypoints,
/// where the velocity jumps, do not count: script_breaks().
[[nodiscard]] double greatest_acceleration(const Obstacle& obstacle);

/// An instant of a script at which pose or velocity jumps.
struct ScriptBreak {
  Pose X_WO = Pose::Identity();  ///< pose after the jump
  double velocity_change = 0.0;  ///< jump of the origin's velocity [m/s]
  double jump = 0.0;             ///< jump of the origin [m]
};

/// The jumps of one period: corners at waypoints where the direction changes, and a conveyor's restart.
[[nodiscard]] std::vector<ScriptBreak> script_breaks(const Obstacle& obstacle);

}  // namespace hecaton::world
