#pragma once
/// When an arm asks for a route, and what becomes of the answer. Used every control period, beside the tick.

#include <cstdint>
#include <optional>
#include <span>

#include "planner/arm_controller.hpp"
#include "planner/route/route_search.hpp"

namespace hecaton::planner {

class RoutePolicy {
 public:
  /// `seed` of the searches. Only an arm whose method coordinates ever asks.
  RoutePolicy(const LocalParameters& parameters, std::uint64_t seed);

  /// After a period of `controller`: a question when the arm has not come nearer for long, and now and then while it
  /// follows a route, whether that is still free. A route on which it gets nowhere is left.
  [[nodiscard]] std::optional<RouteQuestion> next(ArmController& controller, const TickResult& result,
                                                  std::span<const ArmObservation> arms,
                                                  std::span<const world::ObstacleState> obstacles);
  /// The answer has come: the arm follows it from the next period on. Not when the goal is another one by now, the arm
  /// is somewhere else, or drop() was called since: it would be the answer to another question.
  void answered(const RouteAnswer& answer, ArmController& controller);

  /// The arm is led by somebody else, in periods of which this hears nothing.
  void drop() { dropped_ = open_; }

  /// Routes that were begun so far.
  [[nodiscard]] int found() const { return found_; }

 private:
  double after_;     ///< not nearer for so long [s]; 0: never asks
  double patience_;  ///< until the next question off a route [s]
  Random random_;
  bool open_ = false;
  bool dropped_ = false;  ///< the answer to the open question is of no use any more
  JointVector q_;         ///< where the arm was when it asked that, and
  JointVector q_goal_;    ///< where it wanted to go
  double since_answer_;   ///< [s]
  double stuck_ = 0.0;    ///< on a route, and not nearer to its end [s]
  double nearest_ = 0.0;  ///< to the end of the route so far [rad | m]
  bool on_route_ = false;
  int found_ = 0;
};

}  // namespace hecaton::planner
