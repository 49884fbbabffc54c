#pragma once
/// The geometry of an arm in the model of [Li96]: its last two joints move two links in a plane (section 2), and a
/// first joint may turn this plane about the base (section 5).

#include <array>
#include <optional>
#include <string>

#include "planner/methods/sensed_cspace/planar_geometry.hpp"
#include "planner/model/robot_model.hpp"

namespace hecaton::planner::cspace {

/// θ₀, θ₁, θ₂ [rad]; θ₀ is 0 for an arm without a first joint.
using Angles = std::array<double, 3>;

/// A point relative to the arm's plane.
struct PlacedPoint {
  Point in_plane;          ///< x and y of the plane [m]
  double off_plane = 0.0;  ///< along its normal [m]
};

struct Turn {
  double cosine = 1.0;
  double sine = 0.0;
};

/// The extent of a link along the plane's normal [m].
struct Slab {
  double low = 0.0;
  double high = 0.0;
};

/// Maps joints to the angles of [Li96] and points to the arm's plane. Immutable.
class ArmPlanes {
 public:
  /// Nothing if the model is such an arm; otherwise the reason as a clause.
  [[nodiscard]] static std::optional<std::string> why_not(const RobotModel& model);
  /// Precondition: why_not(model) returns nothing.
  explicit ArmPlanes(const RobotModel& model);

  [[nodiscard]] bool spatial() const { return spatial_; }  ///< the arm has a joint θ₀
  /// The planar arm. The widths cover all collision shapes of the links.
  [[nodiscard]] const PlanarArm& arm() const { return arm_; }
  [[nodiscard]] const Slab& slab(int link) const { return slabs_[link]; }  ///< link 0 or 1
  /// Largest distance of a point of the arm from the axis of θ₀ [m]; 0 without θ₀.
  [[nodiscard]] double radius() const { return radius_; }

  [[nodiscard]] Angles angles(const JointVector& q) const;
  [[nodiscard]] JointVector joints(const Angles& angles) const;

  /// A point in the arm's base frame B, relative to the plane at θ₀.
  [[nodiscard]] PlacedPoint place(const Eigen::Vector3d& p_B, const Turn& theta0) const;

 private:
  bool spatial_;
  PlanarArm arm_;
  std::array<Slab, 2> slabs_;
  double radius_ = 0.0;
  Eigen::Vector3d axis0_B_, centre0_B_;         ///< of θ₀
  Eigen::Vector3d origin_B_, x_B_, y_B_, n_B_;  ///< the plane at θ₀ = 0
  double sense2_ = 1.0;                         ///< +1 or −1: sense of the last joint about n
  double offset2_ = 0.0;                        ///< θ₂ at q₂ = 0 [rad]
};

}  // namespace hecaton::planner::cspace
