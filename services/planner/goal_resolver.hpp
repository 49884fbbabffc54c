#pragma once
/// Resolves goals of clients to joint configurations, in a background thread: inverse kinematics must not delay a
/// control period.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <idl/cause.h>
#include <idl/goal.h>

#include "planner/arm_planner/search_executor.hpp"
#include "planner/collision/cell_geometry.hpp"
#include "planner/model/inverse_kinematics.hpp"
#include "planner/model/tool_goal.hpp"
#include "planner/trajectory/timed_trajectory.hpp"
#include "services/runtime/progress_watchdog.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::services {

/// A goal with the state of the cell.
struct GoalQuestion {
  msg::Goal goal;
  planner::JointVector q_now;  ///< [rad | m]
  planner::SharedObstacles obstacles;
  std::vector<world::ObstacleState> states;  ///< one per obstacle
  bool follows_trajectories = true;          ///< false: the motion method of the arm cannot
  bool begins = true;                        ///< false: another planner has begun a trajectory
};

/// A goal with a trajectory begins at most this far from the measured position [rad | m].
constexpr double kTrajectoryStart = 0.1;

/// A target configuration, or why the goal is rejected.
struct GoalAnswer {
  msg::Goal goal;
  planner::JointVector q_goal = {};            ///< [rad | m]; empty if rejected
  std::optional<planner::ToolGoal> tool = {};  ///< of an accepted pose goal
  /// Of an accepted goal with a trajectory, whose end is q_goal.
  std::shared_ptr<const planner::TimedTrajectory> trajectory = {};
  std::string note = {};                     ///< what was changed in the goal, for people; empty: nothing
  std::optional<msg::Cause> rejection = {};  ///< empty: accepted
  std::optional<planner::NearestOrientation> nearest = {};  ///< with CAUSE_GOAL_ORIENTATION
};

/// Joint goals and named goals are checked for joint limits, self-collision, and collision with obstacles at their
/// present poses. A joint that is outside a limit by rounding is moved onto the limit, with a note. Pose goals are
/// solved by inverse kinematics, first from `q_now` [rad | m] and then from random seeds, until a solution passes the
/// same check. A solution has the position and the orientation of the goal, within its tolerances and except for its
/// free rotation, whatever the number of joints. Of a trajectory each point is checked for joint limits, its start for
/// the distance from `q_now` if it `begins` now, and its end as a joint goal. The way of a pose goal, if joints turn
/// more than once, avoids postures in which links of the arm are nearer than `self_security_distance` [m]. Takes up to
/// 0.2 s.
[[nodiscard]] GoalAnswer resolve_goal(const planner::CellGeometry& geometry, const msg::Goal& goal,
                                      const planner::JointVector& q_now,
                                      std::span<const world::ObstacleState> obstacles, bool begins = true,
                                      double self_security_distance = 0.0);

/// resolve_goal() in a background thread. All functions are for the thread of the control loop and do not wait, except
/// the destructor.
class GoalResolver {
 public:
  /// `geometry`: of the cell, with the planned arm as its own arm. `self_security_distance` [m]: see resolve_goal().
  explicit GoalResolver(planner::CellGeometry geometry, double self_security_distance = 0.0);
  ~GoalResolver();  ///< waits for the present question
  GoalResolver(const GoalResolver&) = delete;
  GoalResolver& operator=(const GoalResolver&) = delete;

  void ask(GoalQuestion question);
  /// Answers since the last call, in the order of the questions. Call it every period.
  [[nodiscard]] std::vector<GoalAnswer> answers();
  /// As BackgroundThread::silence(). Call it every period.
  [[nodiscard]] ProgressWatchdog::Clock::duration silence(ProgressWatchdog::Clock::time_point now);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
