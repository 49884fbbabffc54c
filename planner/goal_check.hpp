#pragma once
/// Whether a configuration may be a goal.

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

/// Why a configuration cannot be a goal. Programs decide on the kind.
struct Rejection {
  RejectionKind kind = RejectionKind::kMalformed;
  std::string subject;
  std::string text;  ///< one sentence
};

/// Checks `q_goal` for the geometry's own arm: number of joints, finite, limits, collision with itself, with obstacles
/// where they are now, and with what no joint moves of another arm. The moving links of other arms do not count.
/// Empty: it may be a goal. Allocates.
[[nodiscard]] std::optional<Rejection> reject_goal(const CellGeometry& geometry, const JointVector& q_goal,
                                                   std::span<const world::ObstacleState> obstacles);

}  // namespace hecaton::planner
