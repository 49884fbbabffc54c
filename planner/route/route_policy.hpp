#pragma once
/// When an arm asks for a route, and how it uses the answer. Used once in each control period, outside the tick.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "planner/arm_controller.hpp"
#include "planner/route/route_search.hpp"

namespace hecaton::planner {

/// Not thread-safe. Deterministic for a seed.
class RoutePolicy {
 public:
  /// `seed`: of the searches. An arm whose method does not coordinate never asks.
  RoutePolicy(const LocalParameters& parameters, std::uint64_t seed);

  struct Next {
    std::optional<RouteQuestion> question;
    bool leaves_route = false;  ///< the arm makes no progress on its route
  };
  /// Call after each period of `controller`. Returns a question when the progress has stalled and, on a route, every
  /// 0.1 s to check that the route is still free.
  [[nodiscard]] Next next(const ArmController& controller, const TickResult& result,
                          std::span<const ArmObservation> arms, std::span<const world::ObstacleState> obstacles);
  /// Takes the answer to the open question. Returns the points to follow from the next period on; no points: the arm
  /// leaves its route; empty: nothing changes, because the goal has changed, the arm has moved away, or discard() was
  /// called.
  [[nodiscard]] std::optional<std::vector<JointVector>> receive(const RouteAnswer& answer,
                                                                const ArmController& controller);

  /// Call when the arm follows a coupled plan or another planner: the answer to the open question will be ignored.
  void discard() { dropped_ = open_; }

  /// Number of routes begun so far.
  [[nodiscard]] int begun() const { return begun_; }

  void describe(MemoryArchive& archive) {
    archive(interval_, random_, open_, dropped_, q_, q_goal_, since_answer_, stuck_, nearest_, on_route_);
    archive.count(begun_);
  }

 private:
  double stall_timeout_;  ///< without progress, before the arm asks [s]; 0: never
  double interval_;       ///< between two questions off a route [s]
  Random random_;
  bool open_ = false;
  bool dropped_ = false;  ///< the answer to the open question will be ignored
  JointVector q_;         ///< of the open question [rad | m]
  JointVector q_goal_;    ///< of the open question [rad | m]
  double since_answer_;   ///< [s]
  double stuck_ = 0.0;    ///< on a route without progress [s]
  double nearest_ = 0.0;  ///< smallest remaining length of the route [rad | m]
  bool on_route_ = false;
  int begun_ = 0;
};

}  // namespace hecaton::planner
