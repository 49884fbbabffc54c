#pragma once
/// How fast the joints of an arm can change the distance of two of its parts, in any configuration.

#include <set>
#include <vector>

#include <Eigen/Core>

#include "planner/model/kinematics.hpp"
#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// A convex part of a link: a ball that sweeps the convex hull of points contains it.
struct LinkPart {
  int link = 0;
  std::vector<Eigen::Vector3d> core_L;  ///< the points, in the link's frame [m]
};

/// The part that a shape at X_LS makes of a link. The points are as few as the shape allows; the ball is that of the
/// shape's swept core.
[[nodiscard]] LinkPart link_part(int link, const world::Shape& shape, const Pose& X_LS);

/// For each joint a bound on the change of the distance of two parts per unit of motion. It is the sum over the joint's
/// axes between the parts: a joint that links follow has several. The distance changes by at most Σ rate · |Δq| along
/// any motion within the model's limits.
class RateBounds {
 public:
  RateBounds(const RobotModel& model, const LinkPart& a, const LinkPart& b);

  /// Joints that have axes between the parts.
  [[nodiscard]] const std::set<int>& joints() const { return joints_; }
  /// By joint [m/rad | 1]; 0 for joints without such axes. Infinite if the parts are on either side of a prismatic axis
  /// without limits.
  [[nodiscard]] const JointVector& rates() const { return rates_; }

  /// The configuration nearest to zero.
  [[nodiscard]] static JointVector reference(const RobotModel& model);

 private:
  [[nodiscard]] double off_axis(const Eigen::Vector3d& p_W, int axis) const;
  [[nodiscard]] double travel(int axis) const;
  [[nodiscard]] double between_origins(int axis) const;
  template <typename Measure>
  [[nodiscard]] double furthest(const LinkPart& part, Measure measure) const;
  [[nodiscard]] double reach_from_first(const LinkPart& part, int axis) const;
  [[nodiscard]] double reach_from_last(const LinkPart& part, int axis) const;

  const RobotModel& model_;
  Kinematics kinematics_;            ///< of the reference configuration
  std::vector<const Link*> moving_;  ///< by axis
  int first_ = 0;                    ///< axis, mounted on the part nearer to the base
  int last_ = 0;                     ///< axis, carries the other part
  std::set<int> joints_;
  JointVector rates_;
};

}  // namespace hecaton::planner
