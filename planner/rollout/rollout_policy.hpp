#pragma once
/// The questions of one arm to its rollout search (docs/explanation/0004-rollouts.md).

#include <cstdint>
#include <optional>

#include "planner/arm_controller.hpp"
#include "planner/rollout/rollout_search.hpp"

namespace hecaton::planner {

/// Decides in every control period whether to ask, and what. An arm whose method does not coordinate never asks. Not
/// thread-safe.
class RolloutPolicy {
 public:
  /// `seed`: of the random candidates.
  RolloutPolicy(const LocalParameters& parameters, std::uint64_t seed);

  /// Call before a period. Time that a blocked arm waits for an answer before it deviates [s]; nothing if it cannot
  /// ask. The wait avoids two changes of direction within a tenth of a second.
  [[nodiscard]] std::optional<double> rollout_wait() const;

  /// Call after a period of `controller`. Returns a question if none is open and one of these holds:
  /// - the arm is blocked, and `interval` has passed since the last answer. The horizon grows while the arm is blocked.
  /// - an obstacle may come near, and 0.1 s have passed since the last lookahead. This applies without a goal, too.
  [[nodiscard]] std::optional<RolloutQuestion> next(const ArmController& controller, const TickResult& result,
                                                    std::span<const ArmObservation> arms,
                                                    std::span<const world::ObstacleState> obstacles);
  /// Call when the answer has arrived.
  void answered();
  /// A question of a blocked arm is open.
  [[nodiscard]] bool awaiting_rollout() const { return open_ == Open::kBlockedArm; }

  void describe(MemoryArchive& archive);

 private:
  enum class Open : std::uint8_t { kNone, kBlockedArm, kLookahead };
  /// Estimate of an obstacle's acceleration.
  struct Course {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< at the last sample [m/s]
    double since = 0.0;                                      ///< age of that sample [s]
    Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< between the last two samples [m/s²]
  };

  void watch(std::span<const world::ObstacleState> obstacles, double dt);
  [[nodiscard]] std::vector<Eigen::Vector3d> accelerations() const;

  RolloutParameters parameters_;
  double strongest_;             ///< larger accelerations count as corners and are ignored [m/s²]
  std::vector<Course> courses_;  ///< of obstacles
  Random random_;
  Open open_ = Open::kNone;
  double since_answer_ = 0.0;     ///< time since the last answer to a blocked arm [s]
  double since_lookahead_ = 0.0;  ///< time since the last answer to a lookahead [s]
  double since_trouble_ = 0.0;    ///< time since the arm was last blocked [s]
  double horizon_ = 0.0;          ///< of the next question [s]
};

}  // namespace hecaton::planner
