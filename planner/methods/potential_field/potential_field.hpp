#pragma once
/// The potential field of a whole arm in a cell, and its gradient in joint space [Cardenas10].

#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/exact_distance.hpp"
#include "planner/methods/motion_method.hpp"

namespace hecaton::planner::potential {

/// A potential and its derivative by the distance d.
struct Potential {
  double value = 0.0;
  double slope = 0.0;
};

/// Eq. 2 and 6: a paraboloid around the goal, a cone beyond `goal_distance` (d*_goal > 0); d ≥ 0 [m | rad].
[[nodiscard]] Potential attraction(double d, double goal_distance);

/// Eq. 3 and 7: zero beyond `influence_distance` (Q* > 0), growing without bound towards the obstacle; d [m].
/// Never positive slope: it pushes away. η = `repulsion` [m⁴], so that both potentials are in m².
[[nodiscard]] Potential repulsion(double d, double influence_distance, double repulsion);

struct ControlPoint {
  int link = 0;                                   ///< of the own model
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();  ///< in the link's frame [m]
  double radius = 0.0;                            ///< a ball of the body around it; 0: a point of its surface [m]
};

/// Of all bodies that joints move, what the arm carries included: the vertices of boxes, points on the axes of round
/// bodies, both no farther apart than `spacing` [m].
[[nodiscard]] std::vector<ControlPoint> control_points(const CellGeometry& geometry, double spacing);

/// Three points of the tool, which pin down where it is and how it is turned: they are attracted, too.
[[nodiscard]] std::vector<ControlPoint> tool_points(const RobotModel& model, double spacing);

/// The same cell with an own arm that consists of nothing but these balls: own body i is points[i].
[[nodiscard]] CellGeometry control_geometry(const CellGeometry& geometry, const std::vector<ControlPoint>& points);

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
