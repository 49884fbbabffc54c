#pragma once
/// The potential field of a whole arm in a cell, and its gradient in joint space [Cardenas10].

#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/exact_distance.hpp"
#include "planner/methods/motion_method.hpp"

namespace hecaton::planner::potential {

/// A potential and its derivative with respect to the distance d [Cardenas10, eq. 2, 3, 6, 7, with ζ = 1].
struct Potential {
  double value = 0.0;
  double slope = 0.0;
};

/// Eq. 2 and 6: a paraboloid around the goal, and a cone beyond `goal_distance` (d*_goal > 0). d ≥ 0 [m | rad].
[[nodiscard]] Potential attraction(double d, double goal_distance);

/// Eq. 3 and 7: zero beyond `influence_distance` (Q* > 0), unbounded towards the obstacle. d [m]; η = `repulsion` [m⁴].
/// The slope is never positive: the potential repels.
[[nodiscard]] Potential repulsion(double d, double influence_distance, double repulsion);

/// A point of an arm that potentials act on [Cardenas10, "Combined field effect" and "Examples"].
struct ControlPoint {
  int link = 0;                                   ///< of the own model
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();  ///< in the link's frame [m]
  double radius = 0.0;                            ///< of a ball inside the body; 0: a point of its surface [m]
};

/// The control points of all moving bodies, including carried objects: points on the edges of boxes and on the axes of
/// round bodies, at most `spacing` [m] apart.
[[nodiscard]] std::vector<ControlPoint> control_points(const CellGeometry& geometry, double spacing);

/// Three attracted points of the tool, which determine its pose.
[[nodiscard]] std::vector<ControlPoint> tool_points(const RobotModel& model, double spacing);

/// The same cell with an own arm that consists of the points' balls: own body i is points[i].
[[nodiscard]] CellGeometry control_geometry(const CellGeometry& geometry, const std::vector<ControlPoint>& points);

/// The quantity that the goal attracts.
enum class Attraction {
  kControlPoints,  ///< each control point in W, to its position at the goal [Cardenas10, eq. 5]
  kJoints,         ///< the arm as a point in joint space [Cardenas10, eq. 2]
};

/// The cell file's map `potential`. ζ = 1, because only η/ζ shapes the field.
struct PotentialParameters {
  Attraction attraction = Attraction::kControlPoints;
  double goal_distance = 0.3;       ///< d*_goal: the attraction is constant beyond this [m | rad], > 0
  double repulsion = 1e-4;          ///< η [m⁴], > 0
  double influence_distance = 0.2;  ///< Q*: obstacles beyond this do not repel [m], > 0
  double spacing = 0.15;            ///< largest distance between control points on a link [m], > 0
};

/// n × n.
using JointMetric = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints, kMaxJoints>;

struct FieldValue {
  double attraction = 0.0;          ///< Σ U_att [m² | rad²]
  double repulsion = 0.0;           ///< Σ U_rep [m²]
  JointVector attraction_gradient;  ///< Σ Jᵀ ∇U_att
  JointVector gradient;             ///< of U = U_att + U_rep
  JointMetric metric;               ///< Σ JᵀJ of the attracted points, or of the joints themselves: the unit matrix
  double clearance = 0.0;           ///< least distance of a body from a repelling one [m]; Q* without any

  [[nodiscard]] double potential() const { return attraction + repulsion; }
};

/// The steepest descent in the metric M of control point motion: −M⁻¹ ∇U [rad | m]. Near a free goal it leads straight
/// there. −∇U does not: it oscillates in the joints with the longest levers.
[[nodiscard]] JointVector steepest_descent(const FieldValue& field);

/// The potential of the arm [Cardenas10, eq. 1 and 5]. Obstacles repel the control points and the nearest point of each
/// body. Only the constructor and rebuild() allocate. Not thread-safe: one per thread.
///
/// differs from paper: the paper uses fixed control points only and warns of obstacles between them. The nearest points
/// cover those obstacles. Links of the arm repel each other, too.
class PotentialField {
 public:
  PotentialField(const CellGeometry& geometry, const PotentialParameters& parameters);
  /// Call after CellGeometry::set_obstacles, then set_goal().
  void rebuild(const CellGeometry& geometry);

  /// Sets the goal of the attraction [rad | m].
  void set_goal(const JointVector& q_goal);
  /// Computes the field for the arm at `q`. `poses.own`: its kinematics at q. Precondition: set_goal() was called.
  void evaluate(const CellPoses& poses, const JointVector& q, FieldValue& out);

  [[nodiscard]] const PotentialParameters& parameters() const { return parameters_; }
  [[nodiscard]] const std::vector<ControlPoint>& points() const { return points_; }

 private:
  void attract(const Kinematics& own, const JointVector& q, FieldValue& out) const;
  void repel(const Kinematics& own, const Clearance& clearance, double influence, FieldValue& out) const;

  PotentialParameters parameters_;
  Arm arm_;
  std::vector<ControlPoint> points_;     ///< repelled and attracted
  std::vector<ControlPoint> attracted_;  ///< points_ and the tool's points
  ExactDistance of_points_;
  ExactDistance of_bodies_;
  std::vector<Clearance> clearances_;
  JointVector q_goal_;
  std::vector<Eigen::Vector3d> goal_W_;  ///< of attracted_ [m]
};

}  // namespace hecaton::planner::potential
