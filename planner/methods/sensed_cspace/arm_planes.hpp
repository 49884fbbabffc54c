#pragma once
/// How an arm with a URDF is the arm of [Li96]: its last two joints move two links in a plane (section 2), which a
/// first joint may turn about the base (section 5).

#include <array>
#include <optional>
#include <string>

#include "planner/methods/sensed_cspace/planar_geometry.hpp"
#include "planner/model/robot_model.hpp"

namespace hecaton::planner::cspace {

/// θ₀, θ₁, θ₂ [rad]; θ₀ is 0 for an arm without a first joint.
using Angles = std::array<double, 3>;

/// A point as the arm's plane sees it.
struct PlacedPoint {
  Point in_plane;          ///< x and y of the plane [m]
  double off_plane = 0.0;  ///< along its normal [m]
};

struct Turn {
  double cosine = 1.0;
  double sine = 0.0;
};

/// How far a link extends along the plane's normal [m].
struct Slab {
  double low = 0.0;
  double high = 0.0;
};

class ArmPlanes {
 public:
  /// Nothing when the model is such an arm, else one sentence that says why not.
  [[nodiscard]] static std::optional<std::string> why_not(const RobotModel& model);
  /// For a model without objection.
  explicit ArmPlanes(const RobotModel& model);

  [[nodiscard]] bool spatial() const { return spatial_; }  ///< has a joint θ₀
  /// Both links, with widths that cover every collision shape that they carry.
  [[nodiscard]] const PlanarArm& arm() const { return arm_; }
  [[nodiscard]] const Slab& slab(int link) const { return slabs_[link]; }  ///< link 0 or 1
  /// No point of the arm is farther from the axis of θ₀ [m]; 0 without one.
  [[nodiscard]] double radius() const { return radius_; }

  [[nodiscard]] Angles angles(const JointVector& q) const;
  [[nodiscard]] JointVector joints(const Angles& angles) const;

  /// A point in the arm's base frame B, seen from the plane at θ₀.
  [[nodiscard]] PlacedPoint place(const Eigen::Vector3d& p_B, const Turn& theta0) const;

 private:
  bool spatial_;
  PlanarArm arm_;
  std::array<Slab, 2> slabs_;
  double radius_ = 0.0;
  Eigen::Vector3d axis0_B_, centre0_B_;         ///< of θ₀
  Eigen::Vector3d origin_B_, x_B_, y_B_, n_B_;  ///< the plane at θ₀ = 0
  double sense2_ = 1.0;                         ///< +1 or −1: how the last joint turns about n
  double offset2_ = 0.0;                        ///< θ₂ at q₂ = 0 [rad]
};

}  // namespace hecaton::planner::cspace
