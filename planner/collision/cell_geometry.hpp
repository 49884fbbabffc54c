#pragma once
/// The collision geometry of a whole cell for the planner of one arm: the bodies, and the pairs to check. Building and
/// editing allocate and take place outside the tick; the tick only reads.

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
  int obstacle = -1;  ///< its obstacle, also while an arm carries that; −1: part of a link
  bool moves = true;  ///< a joint of its arm moves it (always true for obstacles)
  world::Shape shape;
  Pose X_CS = Pose::Identity();               ///< shape in the carrier's frame
  std::optional<PlacedCapsule> capsule = {};  ///< replaces the shape, in C, except between bodies of one arm
  world::BoundingSphere bound = {};           ///< of shape and capsule, in C
};

class CellGeometry {
 public:
  /// `self` is the index of the planner's own arm in `arms`.
  CellGeometry(std::vector<Arm> arms, int self);

  /// Replaces all obstacles. Those attached to an arm become bodies of that arm, fixed to its tool.
  /// Throws std::invalid_argument when an attachment names no arm of the cell.
  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// The same without the bodies of other arms that a joint moves.
  [[nodiscard]] CellGeometry without_moving_others() const;

  [[nodiscard]] int self() const { return self_; }
  [[nodiscard]] const std::vector<Arm>& arms() const { return arms_; }
  [[nodiscard]] const Arm& own_arm() const { return arms_[self_]; }

  /// Bodies of arm i: its links' geometry in the model's order, then carried obstacles. Without bodies that no joint
  /// moves if arm i is another arm of the own arm's robot.
  [[nodiscard]] const std::vector<Body>& arm_bodies(int arm) const { return arm_bodies_[arm]; }
  [[nodiscard]] const std::vector<Body>& own_bodies() const { return arm_bodies_[self_]; }
  /// Pairs of own bodies that are checked against each other.
  [[nodiscard]] const std::vector<std::pair<int, int>>& self_pairs() const { return self_pairs_; }
  /// The largest distance of a self pair in any posture [m]; infinity unless it is one of the model's close pairs.
  [[nodiscard]] double widest(int first, int second) const;

  /// A ball in W that contains all bodies of arm i, for all positions of its revolute joints, and for all positions of
  /// its prismatic joints within the limits.
  [[nodiscard]] const world::BoundingSphere& arm_reach(int arm) const { return arm_reach_[arm]; }
  /// Lower bound of the distance between the own arm and arm i in all configurations [m]; negative: they may touch.
  [[nodiscard]] double gap_to_arm(int arm) const;
  /// The own arm and all arms that may come nearer to it than `distance` [m], ascending.
  [[nodiscard]] std::vector<int> neighbourhood(double distance) const;

  [[nodiscard]] int obstacle_count() const { return static_cast<int>(obstacle_names_.size()); }
  /// Bodies of obstacle i in its own frame; empty while an arm carries it.
  [[nodiscard]] const std::vector<Body>& obstacle_bodies(int obstacle) const { return obstacle_bodies_[obstacle]; }

  [[nodiscard]] const std::string& obstacle_name(int obstacle) const { return obstacle_names_[obstacle]; }
  /// "arm2/link4", or "arm2/pallet" for a carried obstacle.
  [[nodiscard]] std::string body_name(int arm, const Body& body) const;

  /// Names of the two bodies of a clearance for messages: "arm2/link4", "pallet" or "arm1/forearm".
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
/// last joint before them. Planners and contact monitor use the same rule.
[[nodiscard]] std::vector<int> grasp_links(const RobotModel& model);

}  // namespace hecaton::planner
