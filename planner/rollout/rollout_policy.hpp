#pragma once
/// When an arm asks for rollouts, and what it asks. Used every control period, beside the tick.

#include <cstdint>
#include <optional>

#include "planner/arm_controller.hpp"
#include "planner/rollout/rollout_search.hpp"

namespace hecaton::planner {

class RolloutPolicy {
 public:
  /// `seed` of the candidates that will be drawn. Only an arm whose method coordinates ever asks.
  RolloutPolicy(const LocalParameters& parameters, std::uint64_t seed);

  /// Before a period: when a question could be asked, an arm that gets stuck waits so long for the answer [s]. An arm
  /// that turned aside at once, and then another way within a tenth of a second, would seem to tremble. Empty: no
  /// question could be asked.
  [[nodiscard]] std::optional<double> rollout_wait() const;

  /// After a period of `controller`: a question when the arm is held back, no question is open and the last answer has
  /// had its time. The longer the arm is held back, the farther it looks ahead. Else, now and then, whether going on
  /// ends well, when an obstacle moves that could come near (docs/design/0013-lookahead.md); also without a goal.
  [[nodiscard]] std::optional<RolloutQuestion> next(const ArmController& controller, const TickResult& result,
                                                    std::span<const ArmObservation> arms,
                                                    std::span<const world::ObstacleState> obstacles);
  /// The answer has come; its manoeuvre is to be begun.
  void answered();
  /// A question is open because the arm is held back.
  [[nodiscard]] bool awaiting_rollout() const { return open_ == Open::kHeldBack; }

 private:
  enum class Open : std::uint8_t { kNone, kHeldBack, kLookahead };
  /// What is known of how an obstacle's velocity changes.
  struct Course {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< when it was last looked at [m/s]
    double since = 0.0;                                      ///< that was true [s]
    Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< from then to the look before [m/s²]
  };

  void watch(std::span<const world::ObstacleState> obstacles, double dt);
  [[nodiscard]] std::vector<Eigen::Vector3d> accelerations() const;

  RolloutParameters parameters_;
  double strongest_;             ///< no obstacle accelerates more [m/s²]; what seems to has turned a corner
  std::vector<Course> courses_;  ///< of obstacles
  Random random_;
  Open open_ = Open::kNone;
  double since_answer_ = 0.0;     ///< to a question of an arm that was held back [s]
  double since_lookahead_ = 0.0;  ///< [s]
  double since_trouble_ = 0.0;    ///< [s]
  double horizon_ = 0.0;          ///< of the next question [s]
};

}  // namespace hecaton::planner
