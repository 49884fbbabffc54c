#pragma once
/// An arm as its URDF describes it, constant after loading and shared between threads.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "planner/model/joint_motion.hpp"
#include "planner/model/limits.hpp"
#include "planner/model/link_capsule.hpp"
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
  JointMotion motion = JointMotion::kMoves;         ///< the short cut that kinematics may take: see short_cut()
};

/// The short cut for the link's joint: for who builds a model, once it is complete. Without it kinematics are slower.
[[nodiscard]] inline JointMotion short_cut(const Link& link) {
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
                                 ///< of a mesh that is not closed the hull's volume counts
  std::optional<LinkCapsule> capsule = {};  ///< what stands for the shape in cells of fast geometry; none: it itself
};

/// A serial chain of actuated joints with whatever is fixed to it. Joints of the URDF outside the chain from the root
/// to the tool (fingers, mimic joints) are held at their zero position (or the nearest limit).
struct RobotModel {
  std::string name;
  std::vector<Link> links;               ///< parents before children; links[0] is the root
  std::vector<LinkGeometry> geometry;    ///< ordered by link
  std::vector<std::string> joint_names;  ///< of the actuated joints, base to tip
  JointLimits limits;                    ///< from the URDF; acceleration as the caller's default
  int tool_link = 0;                     ///< its frame, times X_LT, is the tool frame T
  Pose X_LT = Pose::Identity();
  /// Pairs of indices into `geometry` (first < second) that self-collision checks: what the SRDF and the automatic
  /// filter of adjacent and always-touching links leave.
  std::vector<std::pair<int, int>> self_pairs;
  std::map<std::string, JointVector> named;  ///< the SRDF's group_states that set every joint within its limits
  std::vector<std::string> notes;  ///< what the loader decided on its own, a sentence each, for `hecaton check`

  [[nodiscard]] int joints() const { return static_cast<int>(joint_names.size()); }
};

}  // namespace hecaton::planner
