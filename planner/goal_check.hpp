#pragma once
/// Checks of a configuration before it becomes a goal.

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "planner/collision/cell_geometry.hpp"

namespace hecaton::planner {

enum class RejectionKind : std::uint8_t {
  kMalformed,      ///< wrong number of joints, or not finite
  kOutsideLimits,  ///< subject: the joint
  kInCollision,    ///< subject: what the arm would touch
};

/// Reason why a configuration cannot be a goal. Programs decide on the kind.
struct Rejection {
  RejectionKind kind = RejectionKind::kMalformed;
  std::string subject;
  std::string text;  ///< one sentence
};

/// Checks `q_goal` for the own arm of `geometry`: number of joints, finite values, limits, and collision. Collision is
/// checked with the arm itself, with obstacles at their present poses, and with the fixed links of other arms. The
/// moving links of other arms do not count. Returns nothing for a valid goal. Allocates.
[[nodiscard]] std::optional<Rejection> reject_goal(const CellGeometry& geometry, const JointVector& q_goal,
                                                   std::span<const world::ObstacleState> obstacles);

}  // namespace hecaton::planner
