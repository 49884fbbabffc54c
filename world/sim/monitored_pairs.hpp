#pragma once
/// The contact monitor's bodies and pairs: which shape rides on what, which two are judged against each other, and how far
/// everything has moved since a pair's distance was last computed.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "world/sim/bullet_shape.hpp"
#include "world/sim/contact_monitor.hpp"
#include "world/sim/monitored_pair.hpp"
#include "world/sim/pair_blocks.hpp"

namespace hecaton::world {

/// One convex shape on its carrier: a link of an arm, or an obstacle.
struct MonitoredPart {
  int carrier = 0;
  int arm = -1;          ///< −1: of a free obstacle
  int link = -1;         ///< of that arm; −1: of an obstacle, free or carried
  bool moves = true;     ///< two that cannot move are not judged: a base stands on its table
  bool handled = false;  ///< of the obstacle that was just attached or detached
  int name = 0;          ///< index into MonitoredPairs::names()
  std::shared_ptr<const btConvexShape> shape;
  Pose X_CS = Pose::Identity();
  Eigen::Vector3d centre_C = Eigen::Vector3d::Zero();  ///< of the bounding sphere [m]
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();
  double radius = 0.0;  ///< of the bounding sphere [m]
};

class MonitoredPairs {
 public:
  explicit MonitoredPairs(std::vector<ArmBodies> arms);

  /// See ContactMonitor::set_obstacles(). Afterwards no bound is known and no obstacle placed.
  void set_obstacles(std::span<const Obstacle> obstacles, const std::string& handled);
  void place(std::span<const MeasuredArm> arms, std::span<const ObstacleState> obstacles);

  [[nodiscard]] std::vector<MonitoredPair>& pairs() { return pairs_; }
  /// The pairs whose distance may have come below that of `smallest` [m] of their kind, or below contact, or that are
  /// watched; ascending. Afterwards, when all of them were looked at: close().
  [[nodiscard]] std::span<const PairRun> open(const std::array<double, kContactKinds>& smallest) {
    return blocks_.open(side_travel_, smallest);
  }
  void close() { blocks_.close(pairs_, travel_, side_travel_); }
  /// After states of pairs were changed otherwise than by judging.
  void forget_blocks() { blocks_.forget_bounds(); }
  [[nodiscard]] const MonitoredPart& part(int index) const { return parts_[index]; }
  [[nodiscard]] int group_count() const { return group_count_; }
  /// Grows only: an index stays valid through edits.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Where a name is among them, from now on.
  int name_index(const std::string& name);

  [[nodiscard]] bool placed(const MonitoredPair& pair) const {
    return carriers_[parts_[pair.a].carrier].placed && carriers_[parts_[pair.b].carrier].placed;
  }
  /// Sum of both [m]. Grows only.
  [[nodiscard]] double travel(const MonitoredPair& pair) const { return travel_[pair.a] + travel_[pair.b]; }
  /// Lower bound from the bounding spheres [m]; negative where they overlap.
  [[nodiscard]] double ball_distance(const MonitoredPair& pair) const;
  /// Lower bound from the direction that parted the two when their distance was last computed, fixed to a [m]. Good as
  /// long as they have turned little against each other, even if they have travelled far together.
  [[nodiscard]] double gap_as_before(const MonitoredPair& pair) const;
  double exact_distance(const MonitoredPair& pair);

 private:
  struct Carrier {
    Pose X_WC = Pose::Identity();
    bool placed = false;
    std::vector<int> parts;
  };

  void add_part(MonitoredPart part, int side, const PlacedShape& placed);
  /// Returns how far a point of it may have moved [m].
  double move(Carrier& carrier, const Pose& X_WC);
  [[nodiscard]] btTransform X_WS(const MonitoredPart& part) const;
  /// What kind of pair two parts are, if they are one by who they belong to (self pairs of links are listed apart).
  [[nodiscard]] std::optional<ContactKind> kind_of(const MonitoredPart& a, const MonitoredPart& b) const;
  [[nodiscard]] std::vector<MonitoredPair> all_pairs() const;
  void adopt(std::vector<MonitoredPair> pairs);

  std::vector<ArmBodies> arms_;
  std::vector<int> first_link_;  ///< carrier of link 0 of each arm
  std::vector<int> first_part_;  ///< of each arm
  int links_ = 0;                ///< carriers that are links; the obstacles follow
  int link_parts_ = 0;           ///< parts that are links'; the obstacles' follow
  std::vector<Carrier> carriers_;
  std::vector<MonitoredPart> parts_;
  std::vector<double> travel_;       ///< of each part: no point of it has moved further since the beginning [m]
  std::vector<int> sides_;           ///< of each part: its arm, or its obstacle after all arms, carried or not
  std::vector<double> side_travel_;  ///< of each side: no point of it has moved further since the beginning [m]
  std::vector<MonitoredPair> pairs_;
  PairBlocks blocks_;                     ///< of the pairs
  std::vector<Eigen::Vector3d> normals_;  ///< of the pairs: from b towards a, in a's carrier, when last computed
  int group_count_ = 0;
  std::vector<std::string> names_;
  std::map<std::string, int> name_indices_;
};

}  // namespace hecaton::world
