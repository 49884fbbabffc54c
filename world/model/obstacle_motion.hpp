#pragma once
/// Where a scripted obstacle is at an instant of its script: a pure function of (obstacle, time), so that every process
/// that knows the scene and the world's time knows the obstacle's place.

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
/// The velocity is the derivative of the pose wherever that exists. At a waypoint, where it does not, it is the
/// velocity with which the next stretch begins. A conveyor's restart is a jump, never a velocity: its twist is always
/// direction · speed.
[[nodiscard]] MotionState motion_at(const Obstacle& obstacle, double time);

/// After how long the script begins anew [s]; 0 when the obstacle stands or is not scripted.
[[nodiscard]] double script_period(const Obstacle& obstacle);

/// No point of the script's way is left with a greater acceleration of the obstacle's origin [m/s²]. The corners of
/// waypoints, where the velocity changes at once, do not count; what is not scripted has none.
[[nodiscard]] double greatest_acceleration(const Obstacle& obstacle);

/// An instant of a script at which no acceleration leads from what was to what comes.
struct ScriptBreak {
  Pose X_WO = Pose::Identity();  ///< from where it goes on
  double velocity_change = 0.0;  ///< of the origin, at once [m/s]
  double jump = 0.0;             ///< of the origin, at once [m]
};

/// Of one round: the corners of waypoints at which the direction changes, a conveyor's restart.
[[nodiscard]] std::vector<ScriptBreak> script_breaks(const Obstacle& obstacle);

}  // namespace hecaton::world
