#pragma once
/// When an arm asks for a route, and what becomes of the answer. Used every control period, beside the tick.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "planner/arm_controller.hpp"
#include "planner/route/route_search.hpp"

namespace hecaton::planner {

class RoutePolicy {
 public:
  /// `seed` of the searches. Only an arm whose method coordinates ever asks.
  RoutePolicy(const LocalParameters& parameters, std::uint64_t seed);

  struct Next {
    std::optional<RouteQuestion> question;
    bool leaves_route = false;  ///< the arm gets nowhere on its route
  };
  /// After a period of `controller`: a question when the arm has not come nearer for long, and now and then while it
  /// follows a route, whether that is still free.
  [[nodiscard]] Next next(const ArmController& controller, const TickResult& result,
                          std::span<const ArmObservation> arms, std::span<const world::ObstacleState> obstacles);
  /// The points that the arm follows from the next period on; none: it leaves its route. Empty: nothing changes. So it
  /// is when the goal is another one by now, the arm is somewhere else, or drop() was called since: the answer would be
  /// one to another question.
  [[nodiscard]] std::optional<std::vector<JointVector>> answered(const RouteAnswer& answer,
                                                                 const ArmController& controller);

  /// In this period the arm follows a coupled plan, or another planner.
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
