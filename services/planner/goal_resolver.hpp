#pragma once
/// Resolves goals on a thread of its own, so that inverse kinematics never delays a control period.

#include <memory>
#include <vector>

#include "planner/model/arm.hpp"
#include "services/planner/resolve_goal.hpp"
#include "services/runtime/turn_watch.hpp"
#include "world/model/scene.hpp"

namespace hecaton::services {

struct GoalQuestion {
  msg::Goal goal;
  planner::JointVector q_now;  ///< [rad | m]
  std::shared_ptr<const std::vector<world::Obstacle>> obstacles;
  std::vector<world::ObstacleState> states;  ///< one per obstacle
};

class GoalResolver {
 public:
  /// `self` is the index of the planner's own arm in `arms`.
  GoalResolver(std::vector<planner::Arm> arms, int self);
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
