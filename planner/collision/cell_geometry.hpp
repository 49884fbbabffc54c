#pragma once
/// The collision geometry of a whole cell as one arm's planner uses it: which bodies exist, which pairs matter.
/// Built and edited outside the tick (it allocates); the tick only reads it.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planner/collision/clearance.hpp"
#include "planner/model/arm.hpp"
#include "planner/model/kinematics.hpp"
#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::planner {

/// One convex body, fixed to a link or to an obstacle's frame ("carrier" frame C).
struct Body {
  int link = -1;      ///< link of its arm; −1: the body of an obstacle
  int obstacle = -1;  ///< the obstacle it belongs to, also while that is carried by an arm; −1: part of a link
  bool moves = true;  ///< some joint of its arm moves it (always true for obstacles)
  world::Shape shape;
  Pose X_CS = Pose::Identity();               ///< shape in the carrier's frame
  std::optional<PlacedCapsule> capsule = {};  ///< stands for the shape, in C, but between bodies of one arm
  world::BoundingSphere bound = {};           ///< of shape and capsule, in C
};

class CellGeometry {
 public:
  /// `self` is the index of the planner's own arm in `arms`.
  CellGeometry(std::vector<Arm> arms, int self);

  /// Replaces all obstacles. Those attached to an arm become bodies of that arm, fixed to its tool.
  /// Throws std::invalid_argument when an attachment names no arm of the cell.
  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// The same without what moves of the other arms: of them only parts that no joint moves are left.
  [[nodiscard]] CellGeometry without_moving_others() const;

  [[nodiscard]] int self() const { return self_; }
  [[nodiscard]] const std::vector<Arm>& arms() const { return arms_; }
  [[nodiscard]] const Arm& own_arm() const { return arms_[self_]; }

  /// Bodies of arm i: its links' geometry in the model's order, then what it carries.
  [[nodiscard]] const std::vector<Body>& arm_bodies(int arm) const { return arm_bodies_[arm]; }
  [[nodiscard]] const std::vector<Body>& own_bodies() const { return arm_bodies_[self_]; }
  /// Pairs of own bodies that are checked against each other.
  [[nodiscard]] const std::vector<std::pair<int, int>>& self_pairs() const { return self_pairs_; }

  /// No body of arm i ever reaches out of this ball, in W, whatever its joints do (within limits, if they shift it).
  [[nodiscard]] const world::BoundingSphere& arm_reach(int arm) const { return arm_reach_[arm]; }
  /// The own arm and arm i never come nearer to each other than this [m]; negative: they may touch.
  [[nodiscard]] double gap_to_arm(int arm) const;
  /// The own arm and all arms that may come nearer to it than `distance` [m] in some configurations, ascending.
  [[nodiscard]] std::vector<int> neighbourhood(double distance) const;

  [[nodiscard]] int obstacle_count() const { return static_cast<int>(obstacle_names_.size()); }
  /// Bodies of obstacle i in its own frame; empty while an arm carries it.
  [[nodiscard]] const std::vector<Body>& obstacle_bodies(int obstacle) const { return obstacle_bodies_[obstacle]; }

  [[nodiscard]] const std::string& obstacle_name(int obstacle) const { return obstacle_names_[obstacle]; }
  /// "arm2/link4", or "arm2/pallet" for what it carries.
  [[nodiscard]] std::string body_name(int arm, const Body& body) const;

  /// "arm2/link4", "pallet" or "arm1/forearm": what a message calls the two sides of a clearance.
  [[nodiscard]] std::string own_name(const Clearance& clearance) const;
  [[nodiscard]] std::string other_name(const Clearance& clearance) const;

 private:
  std::vector<Arm> arms_;
  int self_;
  std::vector<std::vector<Body>> arm_bodies_;
  std::vector<world::BoundingSphere> arm_reach_;
  std::vector<std::pair<int, int>> self_pairs_;
  std::vector<std::string> obstacle_names_;
  std::vector<std::vector<Body>> obstacle_bodies_;
};

/// Links that something held by the tool may touch: those rigidly joined with the tool, and the link that carries the
/// last joint before them. Planners and referee use the same rule.
[[nodiscard]] std::vector<int> grasp_links(const RobotModel& model);

}  // namespace hecaton::planner
