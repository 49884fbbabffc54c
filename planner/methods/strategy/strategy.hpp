#pragma once
/// A motion strategy [Mediavilla02, section 2]: a choice of plane in joint space, made off line, in which an arm avoids
/// obstacles.

#include <array>
#include <functional>
#include <string>

#include "planner/model/limits.hpp"
#include "planner/model/memory_archive.hpp"

namespace hecaton::planner {

/// Limit of |α|, |β|, … of a strategy. At this value u₂ is within 1 mrad of the coefficient's axis; larger values
/// hardly change the plane.
inline constexpr double kMostCoefficient = 1000.0;

/// L = (α, β, …, λ) of one arm (eq. 7). For n avoiding joints, n − 2 coefficients select the plane. The local direction
/// λ selects the side of the straight line to which the arm turns first.
struct Strategy {
  std::array<double, kMaxJoints> coefficients{};  ///< α, β, …; entries beyond n − 2 are unused
  double direction = 1.0;                         ///< λ, 1 or −1

  friend bool operator==(const Strategy&, const Strategy&) = default;
};

/// The cell file's map `strategy`.
struct StrategyParameters {
  Strategy strategy;
  int coefficients = 0;    ///< number of given coefficients
  int joints = 0;          ///< number of leading joints that avoid, ≥ 2; 0: all but the last (which rolls the tool)
  double distance = 0.05;  ///< h: least distance to other bodies after a step [m]
  double step = 0.05 / 0.85;  ///< Δ of the published rule [rad]: ε over the arm's reach
};

/// The number of avoiding joints of an arm with `joints` joints.
[[nodiscard]] inline int avoiding_joints(const StrategyParameters& parameters, int joints) {
  if (parameters.joints > 0) return parameters.joints;
  return joints > 2 ? joints - 1 : joints;
}

/// An orthonormal basis of the null space of u₁ (eq. 5), (n − 1) × n, row by row. `u1`: unit vector of size n ≥ 2.
/// The basis comes from Gram–Schmidt on the axes of joints 2, 3, …, n and then 1. Axes with a remainder below 10⁻⁶ are
/// skipped. The paper leaves the basis open, but α and β depend on it.
using NullSpaceBasis = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxJoints, kMaxJoints>;
[[nodiscard]] NullSpaceBasis null_space_basis(const JointVector& u1);

/// The R-subspace q = q_I + x u₁ + y u₂ (eq. 1) of the avoiding joints, from a start to a goal.
struct ReducedSubspace {
  JointVector q_start;    ///< [rad]
  JointVector u1;         ///< unit, towards the goal (eq. 2)
  JointVector u2;         ///< unit, orthogonal to u₁ (eq. 7), including λ: the arm turns there first
  double distance = 0.0;  ///< ‖q_F − q_I‖ [rad]

  void describe(MemoryArchive& archive) { archive(q_start, u1, u2, distance); }
  [[nodiscard]] JointVector at(double x, double y) const { return q_start + x * u1 + y * u2; }
};

/// State of an arm in its plane. A value.
struct StrategyMemory {
  bool under_way = false;  ///< the plane belongs to the present goal
  ReducedSubspace plane;   ///< starts where the arm was when it got the goal
  double x = 0.0;          ///< end of the last step: plane.at(x, y) [rad]
  double y = 0.0;
  double side = 1.0;  ///< −1: the local direction is reversed

  void describe(MemoryArchive& archive) { archive(under_way, plane, x, y, side); }
};

/// The plane from `q_start` to `q_goal`. Precondition: they differ.
[[nodiscard]] ReducedSubspace reduced_subspace(const JointVector& q_start, const JointVector& q_goal,
                                               const Strategy& strategy);

/// Begins a new goal at q + `way` (all joints) [rad | m]; the plane contains q. No effect if the avoiding joints do not
/// move.
void begin_strategy(const StrategyParameters& parameters, const JointVector& q, const JointVector& way,
                    StrategyMemory& memory);

/// True if the avoiding joints may be at q.
using IsFree = std::function<bool(const JointVector& q)>;

/// One decision of the published on-line stage [Mediavilla02, section 4], from (memory.x, memory.y): a step to the
/// goal, an avoiding step, or a change of the local direction without motion. `step` [rad]. Changes memory.x, y and
/// side.
void take_step(double step, const IsFree& is_free, StrategyMemory& memory);

}  // namespace hecaton::planner
