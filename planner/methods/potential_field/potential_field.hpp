#pragma once
/// The potential of a whole arm in a cell, and its gradient in Q: [Cardenas10] eq. 1 and 5.

#include <vector>

#include "planner/collision/exact_distance.hpp"
#include "planner/methods/motion_method.hpp"
#include "planner/methods/potential_field/control_points.hpp"

namespace hecaton::planner::potential {

/// What the goal attracts.
enum class Attraction {
  kControlPoints,  ///< each control point in W, to where it is at the goal: [Cardenas10] eq. 5
  kJoints,         ///< the arm as a point in Q: [Cardenas10] eq. 2 as it stands
};

/// Artificial potentials [Cardenas10, eq. 2 and 3] with ζ = 1: only η/ζ shapes the field. The cell file's map
/// `potential`.
struct PotentialParameters {
  Attraction attraction = Attraction::kControlPoints;
  double goal_distance = 0.3;       ///< d*_goal: farther away the attraction grows no more [m | rad], > 0
  double repulsion = 1e-4;          ///< η [m⁴], > 0
  double influence_distance = 0.2;  ///< Q*: obstacles farther away do not repel [m], > 0
  double spacing = 0.15;            ///< control points on a link are no farther apart than this [m], > 0
};

/// n × n.
using JointMetric = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints, kMaxJoints>;

struct FieldValue {
  double attraction = 0.0;          ///< Σ U_att [m² | rad²]
  double repulsion = 0.0;           ///< Σ U_rep [m²]
  JointVector attraction_gradient;  ///< Σ Jᵀ ∇U_att
  JointVector gradient;             ///< of U = U_att + U_rep
  JointMetric metric;               ///< Σ JᵀJ of the attracted points, or of the joints themselves: the unit matrix
  double clearance = 0.0;           ///< the least distance of a body from what repels it [m]; Q* when nothing does

  [[nodiscard]] double potential() const { return attraction + repulsion; }
};

/// The way down where a motion counts by how far it moves the control points: −M⁻¹ ∇U [rad | m]. Also downhill, and
/// near a free goal it leads straight there, which −∇U does not: that turns the joints with the longest levers to and
/// fro.
[[nodiscard]] JointVector steepest_descent(const FieldValue& field);

/// Storage is reused: nothing but rebuild() allocates. One per thread.
///
/// Repelled are the control points, and of each body the point nearest to the obstacle.
/// differs from paper: the paper's control points are fixed, and it warns that obstacles between them go unnoticed; the
/// nearest points notice those. Links of the arm repel each other, too.
class PotentialField {
 public:
  PotentialField(const CellGeometry& geometry, const PotentialParameters& parameters);
  /// After CellGeometry::set_obstacles.
  void rebuild(const CellGeometry& geometry);

  /// The field pulls here from now on.
  void set_goal(const JointVector& q_goal);
  /// For the arm at `q`; `poses.own` are its kinematics there.
  void evaluate(const CellPoses& poses, const JointVector& q, FieldValue& out);

  [[nodiscard]] const PotentialParameters& parameters() const { return parameters_; }
  [[nodiscard]] const std::vector<ControlPoint>& points() const { return points_; }

 private:
  void attract(const Kinematics& own, const JointVector& q, FieldValue& out) const;
  void repel(const Kinematics& own, const Clearance& clearance, double influence, FieldValue& out) const;

  PotentialParameters parameters_;
  Arm arm_;
  std::vector<ControlPoint> points_;     ///< repelled and attracted
  std::vector<ControlPoint> attracted_;  ///< these, and the tool's
  ExactDistance of_points_;
  ExactDistance of_bodies_;
  std::vector<Clearance> clearances_;
  JointVector q_goal_;
  std::vector<Eigen::Vector3d> goal_W_;  ///< of attracted_ [m]
};

}  // namespace hecaton::planner::potential
