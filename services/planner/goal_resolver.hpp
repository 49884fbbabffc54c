#pragma once
/// From what a client asks for to a joint configuration that may be tried, or the cause why not: on a thread of its
/// own, so that inverse kinematics never delays a control period.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <idl/cause.h>
#include <idl/goal.h>

#include "planner/arm_planner/search_executor.hpp"
#include "planner/collision/cell_geometry.hpp"
#include "services/runtime/turn_watch.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::services {

struct GoalQuestion {
  msg::Goal goal;
  planner::JointVector q_now;  ///< [rad | m]
  planner::SharedObstacles obstacles;
  std::vector<world::ObstacleState> states;  ///< one per obstacle
};

struct GoalAnswer {
  msg::Goal goal;
  planner::JointVector q_goal = {};        ///< [rad | m], unless it is refused
  std::optional<msg::Cause> refusal = {};  ///< why the goal cannot be tried
};

/// Joint goals and named ones are checked (limits, collision with itself and with obstacles where they are now); pose
/// goals are solved from `q_now` and then from random seeds until a solution passes the same check. Arms of fewer than
/// six joints meet what they can: position and tool axis with five, position alone with fewer. May take 0.1 s.
[[nodiscard]] GoalAnswer resolve_goal(const planner::CellGeometry& geometry, const msg::Goal& goal,
                                      const planner::JointVector& q_now,
                                      std::span<const world::ObstacleState> obstacles);

class GoalResolver {
 public:
  /// `geometry`: of the cell, with the planner's own arm.
  explicit GoalResolver(planner::CellGeometry geometry);
  ~GoalResolver();  ///< waits for the question under way
  GoalResolver(const GoalResolver&) = delete;
  GoalResolver& operator=(const GoalResolver&) = delete;

  void ask(GoalQuestion question);
  /// Since the last call, in the order of the questions. Never blocks for long.
  [[nodiscard]] std::vector<GoalAnswer> answers();
  /// As of BackgroundThread.
  [[nodiscard]] TurnWatch::Clock::duration silence(TurnWatch::Clock::time_point now);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
