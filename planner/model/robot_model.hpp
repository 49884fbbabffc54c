#pragma once
/// An arm as its URDF describes it. Constant after loading, therefore safe to share between threads.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "planner/model/capsules.hpp"
#include "planner/model/kinematics_kernels.hpp"
#include "planner/model/limits.hpp"
#include "world/model/shape.hpp"

namespace hecaton::planner {

using world::Pose;

enum class JointType { kFixed, kRevolute, kContinuous, kPrismatic };

/// A link and the joint that carries it. In the joint's zero position the link's frame L coincides with the joint's
/// frame: X_PL(q) = X_PJ · motion(q about or along `axis`).
struct Link {
  std::string name;
  int parent = -1;  ///< index into RobotModel::links, always smaller than its own; −1: the base
  JointType joint_type = JointType::kFixed;
  std::string joint_name;                           ///< empty for the root
  Pose X_PJ = Pose::Identity();                     ///< joint frame in the parent link's frame
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, in the joint's frame
  int joint = -1;                                   ///< index into joint vectors; −1 when the joint does not move
  JointMotion motion = JointMotion::kMoves;         ///< special case for the kinematics kernel: joint_motion()
};

/// The special case of the kinematics kernel that fits the link's joint. Builders of models set Link::motion to it.
[[nodiscard]] inline JointMotion joint_motion(const Link& link) {
  if (link.joint < 0) return JointMotion::kFixed;
  if (link.joint_type == JointType::kPrismatic) return JointMotion::kMoves;
  if (link.axis == Eigen::Vector3d::UnitX()) return JointMotion::kTurnsAboutX;
  if (link.axis == Eigen::Vector3d::UnitY()) return JointMotion::kTurnsAboutY;
  if (link.axis == Eigen::Vector3d::UnitZ()) return JointMotion::kTurnsAboutZ;
  return JointMotion::kMoves;
}

/// One collision shape of one link.
struct LinkGeometry {
  int link = 0;
  world::Shape shape;
  Pose X_LS = Pose::Identity();  ///< shape in the link's frame
  double excess_volume = 0.0;    ///< volume(shape) / volume(mesh) − 1 when the shape was fitted to a mesh, else 0;
                                 ///< for a mesh that is not closed relative to its hull
  std::optional<LinkCapsule> capsule = {};  ///< replaces the shape in cells of fast geometry; empty: the shape itself
};

/// A pair of RobotModel::self_pairs that no posture brings far apart.
struct ClosePair {
  int first = 0;
  int second = 0;
  double widest = 0.0;  ///< the largest distance in any posture, as far as the filter found it [m], > 0
};

/// A serial chain of actuated joints with everything fixed to it. Joints of the URDF outside the chain (fingers, a
/// torso above the base link) are fixed where the options say, else at zero or at the nearest limit. Shapes of links
/// beside the chain that follow one of its joints enclose all their places. Links of the robot's other arms are left
/// out.
struct RobotModel {
  std::string name;
  std::vector<Link> links;               ///< parents before children; links[0] is the root; at most kMaxLinks
  std::vector<LinkGeometry> geometry;    ///< ordered by link
  std::vector<std::string> joint_names;  ///< of the actuated joints, base to tip
  JointLimits limits;                    ///< from the URDF; acceleration from UrdfOptions
  int tool_link = 0;                     ///< its frame, times X_LT, is the tool frame T
  Pose X_LT = Pose::Identity();
  /// Pairs of indices into `geometry` (first < second) that self-collision checks. The SRDF and automatic_filter()
  /// remove pairs from it.
  std::vector<std::pair<int, int>> self_pairs;
  std::vector<ClosePair> close_pairs;        ///< those of self_pairs that automatic_filter() found close
  std::map<std::string, JointVector> named;  ///< the SRDF's group_states that set every joint within its limits
  std::vector<std::string> notes;            ///< decisions of the loader, a sentence each, for `hecaton check`

  [[nodiscard]] int joints() const { return static_cast<int>(joint_names.size()); }
};

}  // namespace hecaton::planner
