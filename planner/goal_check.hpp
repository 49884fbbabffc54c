#pragma once
/// Goals: checks of a configuration before it becomes a goal, the configuration for a goal of the tool frame, and the
/// check that an arm is at its goal.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "planner/collision/cell_geometry.hpp"
#include "planner/model/inverse_kinematics.hpp"
#include "planner/model/tool_goal.hpp"

namespace hecaton::planner {

enum class RejectionKind : std::uint8_t {
  kMalformed,      ///< wrong number of joints, or not finite
  kOutsideLimits,  ///< subject: the joint
  kInCollision,    ///< subject: what the arm would touch
  kUnreachable,    ///< the tool cannot be at the position
  kOrientation,    ///< the tool can be at the position, but not in the orientation
};

/// Reason why a configuration cannot be a goal. Programs decide on the kind.
struct Rejection {
  RejectionKind kind = RejectionKind::kMalformed;
  std::string subject;
  std::string text;  ///< one sentence
};

/// Checks `q_goal` for the own arm of `geometry`: number of joints, finite values, limits, and collision. Collision is
/// checked with the arm itself, with obstacles at their present poses, and with the fixed links of other arms. The
/// moving links of other arms do not count. Where no joint changes the distance of a pair, as between a turning base
/// and a table, the bodies' own shapes count instead of capsules. With `self_distance` [m], links of the arm must be so
/// far apart, close pairs kSecurityShare of their widest distance. Returns nothing for a valid goal. Allocates.
[[nodiscard]] std::optional<Rejection> reject_goal(const CellGeometry& geometry, const JointVector& q_goal,
                                                   std::span<const world::ObstacleState> obstacles,
                                                   double self_distance = 0.0);

/// Moves joints that are outside their limits by at most kLimitRounding onto the limit. Returns one sentence that names
/// these joints; empty: q is unchanged. Ignores a q of another size.
[[nodiscard]] std::string clamp_rounding(const Arm& arm, JointVector& q);

/// The configuration for a tool goal, or why there is none.
struct ToolGoalAnswer {
  JointVector q;                                   ///< [rad | m]; empty if rejected
  std::optional<Rejection> rejection = {};         ///< empty: accepted
  std::optional<NearestOrientation> nearest = {};  ///< with kOrientation: what the arm can do at that position
};

/// A condition on configurations beyond the limits.
using ConfigurationCheck = std::function<std::optional<Rejection>(const JointVector&)>;

/// Searches a configuration that meets `goal` and passes `check`, first from `q_now` [rad | m] and then from random
/// seeds. Prefers a solution without error to one within the tolerances. Joints that turn more than once take the turns
/// whose straight way from `q_now` passes `on_way`; without it, `check`. Deterministic. Takes up to 0.1 s without the
/// checks, of which there are at most a hundred.
[[nodiscard]] ToolGoalAnswer resolve_tool_goal(const Arm& arm, const ToolGoal& goal, const JointVector& q_now,
                                               const ConfigurationCheck& check, const ConfigurationCheck& on_way = {});

/// The error of an arm at `q` from its goal: what it is and what is allowed, as the end of a sentence. Empty when every
/// joint is within `tolerance` [rad | m] of `q_goal`, and, if there is a tool goal, the tool is within its tolerances.
/// `tool` may be null.
[[nodiscard]] std::optional<std::string> error_at_goal(const Arm& arm, const JointVector& q, const JointVector& q_goal,
                                                       double tolerance, const ToolGoal* tool);

}  // namespace hecaton::planner
