#pragma once
/// A motion strategy [Mediavilla02, section 2]: a choice of plane in joint space, made off line, in which an arm avoids
/// obstacles.

#include <array>
#include <functional>
#include <string>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// The largest |α|, |β|, … of a strategy: u₂ is within 1 mrad of that one's axis then, and greater ones choose hardly
/// another plane.
inline constexpr double kMostCoefficient = 1000.0;

/// L = (α, β, …, λ) of one arm (eq. 7): of an arm with n joints that avoid, n − 2 coefficients choose the plane, and
/// the local direction says to which side of the straight way the arm turns first.
struct Strategy {
  std::array<double, kMaxJoints> coefficients{};  ///< α, β, …; those beyond joints − 2 are not used
  double direction = 1.0;                         ///< λ, 1 or −1

  friend bool operator==(const Strategy&, const Strategy&) = default;
};

/// How an arm uses it.
struct StrategyParameters {
  Strategy strategy;
  int coefficients = 0;       ///< that were given
  int joints = 0;             ///< leading joints that avoid, ≥ 2; 0: all but the last (which rolls the tool)
  double distance = 0.05;     ///< h: the least distance to anything that a step may lead to [m]
  double step = 0.05 / 0.85;  ///< Δ of the published rule [rad]: ε over the arm's reach
};

/// The number of joints that avoid, of an arm that has `joints`.
[[nodiscard]] inline int avoiding_joints(const StrategyParameters& parameters, int joints) {
  if (parameters.joints > 0) return parameters.joints;
  return joints > 2 ? joints - 1 : joints;
}

/// An orthonormal basis of the null space of u₁ (eq. 5), row by row: Gram–Schmidt on the axes of joints 2, 3, …, n and
/// then 1, each made orthogonal to u₁ and to those before it, until there are n − 1; an axis of which less than 10⁻⁶ is
/// left is passed over. The paper leaves the basis open, and α and β mean nothing without it.
/// u1: unit, size n ≥ 2; basis: (n − 1) × n.
using NullSpaceBasis = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxJoints, kMaxJoints>;
[[nodiscard]] NullSpaceBasis null_space_basis(const JointVector& u1);

/// The R-subspace q = q_I + x u₁ + y u₂ (eq. 1) from a start to a goal; of the joints that avoid.
struct ReducedSubspace {
  JointVector q_start;    ///< [rad]
  JointVector u1;         ///< unit, towards the goal (eq. 2)
  JointVector u2;         ///< unit, orthogonal to u₁ (eq. 7), λ included: where the arm turns first
  double distance = 0.0;  ///< ‖q_F − q_I‖ [rad]

  [[nodiscard]] JointVector at(double x, double y) const { return q_start + x * u1 + y * u2; }
};

/// What an arm remembers of the way that it goes in its plane; a plain value.
struct StrategyMemory {
  bool under_way = false;  ///< a plane belongs to the present goal
  ReducedSubspace plane;   ///< from where the arm was when it got the goal
  double x = 0.0;          ///< where the last step led: plane.at(x, y) [rad]
  double y = 0.0;
  double side = 1.0;  ///< −1: the local direction has been changed
};

/// For a start and a goal that differ (‖q_F − q_I‖ > 0).
[[nodiscard]] ReducedSubspace reduced_subspace(const JointVector& q_start, const JointVector& q_goal,
                                               const Strategy& strategy);

/// A new goal, `way` from q (all joints) [rad | m]: its plane goes through q. Nothing begins without a way in the
/// joints that avoid.
void begin_strategy(const StrategyParameters& parameters, const JointVector& q, const JointVector& way,
                    StrategyMemory& memory);

/// Where the joints that avoid may be next.
using IsFree = std::function<bool(const JointVector& q)>;

/// One decision of the published on-line stage [Mediavilla02, section 4], from (memory.x, memory.y): go to the goal,
/// avoid, or change the local direction, which moves nothing. Changes memory.x, y and side.
void take_step(double step, const IsFree& is_free, StrategyMemory& memory);

}  // namespace hecaton::planner
