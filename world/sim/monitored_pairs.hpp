#pragma once
/// The pairs that the contact monitor checks: parts on carriers, bounds of their distances, and a broad phase.

#include <array>
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

namespace hecaton::world {

/// One convex shape on its carrier: a link of an arm, or an obstacle.
struct MonitoredPart {
  int carrier = 0;
  int arm = -1;          ///< −1: of a free obstacle
  int link = -1;         ///< of that arm; −1: of an obstacle, free or carried
  bool moves = true;     ///< two parts that do not move are no pair: a base stands on its table
  bool handled = false;  ///< of the obstacle that was just attached or detached
  int name = 0;          ///< index into MonitoredPairs::names()
  std::shared_ptr<const btConvexShape> shape;
  Pose X_CS = Pose::Identity();
  Eigen::Vector3d centre_C = Eigen::Vector3d::Zero();  ///< of the bounding sphere [m]
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();
  double radius = 0.0;  ///< of the bounding sphere [m]
};

/// Two parts. Their distance lies between lower_ref − travel and upper_ref + travel; travel is the sum of both parts'.
struct MonitoredPair {
  /// Both names, and the number of the pair among those with these names. Stays the same through edits, because shapes
  /// keep their order.
  using Identity = std::pair<std::uint64_t, int>;

  int a = 0;      ///< index of a part
  int b = 0;      ///< index of a part
  int index = 0;  ///< in MonitoredPairs::pairs()
  int group = 0;  ///< pairs of parts with the same two names form one contact
  ContactKind kind = ContactKind::kArmArm;
  Identity identity;
  PairState state;
  double lower_ref = 0.0;  ///< [m]
  double upper_ref = 0.0;  ///< [m]
};

/// Pairs [first, end) of MonitoredPairs::pairs().
struct PairRun {
  int first = 0;
  int end = 0;
};

/// Broad phase. Pairs between the same two sides (an arm, or an obstacle) form a block. A block keeps the least lower
/// bound of its pairs, and is skipped while the motion of both sides cannot have used that bound up.
class PairBlocks {
 public:
  /// Builds the blocks of `pairs`, in their order. `side_of_part`: index = part. All bounds are unknown afterwards.
  void rebuild(std::span<const MonitoredPair> pairs, std::span<const int> side_of_part);
  /// Must follow a change of pair states outside update().
  void reset_bounds();

  /// The pairs that must be checked, ascending; valid until the next call. `travel` [m]: of each side, no point has
  /// moved farther since the start. `smallest` [m]: of each kind; larger distances above contact do not matter.
  [[nodiscard]] std::span<const PairRun> candidates(std::span<const double> travel,
                                                    const std::array<double, kContactKinds>& smallest);
  /// Updates the bounds of the blocks last returned by candidates(). `part_travel`: of each part [m].
  void update(std::span<const MonitoredPair> pairs, std::span<const double> part_travel,
              std::span<const double> travel);

 private:
  struct Block {
    int a = 0;  ///< sides
    int b = 0;
    ContactKind kind = ContactKind::kArmArm;
    double lower_ref = 0.0;  ///< no pair is nearer than this − travel of both sides [m]
  };

  std::vector<Block> blocks_;
  std::vector<std::vector<PairRun>> runs_;  ///< of each block
  std::vector<int> open_;                   ///< blocks whose pairs were returned by candidates()
  std::vector<PairRun> open_runs_;
};

/// All parts and pairs of a cell, and how far each part has moved.
class MonitoredPairs {
 public:
  explicit MonitoredPairs(std::vector<ArmBodies> arms);

  /// See ContactMonitor::set_obstacles(). Afterwards all bounds are unknown and no obstacle has a pose.
  void set_obstacles(std::span<const Obstacle> obstacles, const std::string& handled);
  /// See ContactMonitor::update().
  void place(std::span<const MeasuredArm> arms, std::span<const ObstacleState> obstacles);

  [[nodiscard]] std::vector<MonitoredPair>& pairs() { return pairs_; }
  /// Pairs whose distance may lie below `smallest` [m] of their kind or below contact, and all watched ones; ascending.
  /// update_blocks() must follow once all of them are checked.
  [[nodiscard]] std::span<const PairRun> candidates(const std::array<double, kContactKinds>& smallest) {
    return blocks_.candidates(side_travel_, smallest);
  }
  void update_blocks() { blocks_.update(pairs_, travel_, side_travel_); }
  /// Must follow a change of pair states outside an update.
  void reset_blocks() { blocks_.reset_bounds(); }
  [[nodiscard]] const MonitoredPart& part(int index) const { return parts_[index]; }
  [[nodiscard]] int group_count() const { return group_count_; }
  /// Only grows: an index stays valid through edits.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Index of `name` in names(); adds it if it is new.
  int name_index(const std::string& name);

  /// True once both parts have a pose.
  [[nodiscard]] bool placed(const MonitoredPair& pair) const {
    return carriers_[parts_[pair.a].carrier].placed && carriers_[parts_[pair.b].carrier].placed;
  }
  /// Sum of both parts' travel [m]; only grows.
  [[nodiscard]] double travel(const MonitoredPair& pair) const { return travel_[pair.a] + travel_[pair.b]; }
  /// Lower bound from the bounding spheres [m]; negative where they overlap.
  [[nodiscard]] double sphere_distance(const MonitoredPair& pair) const;
  /// Lower bound along the normal of the last exact_distance(), fixed to part a [m]. Tight as long as the two have
  /// turned little against each other.
  [[nodiscard]] double gap_along_last_normal(const MonitoredPair& pair) const;
  double exact_distance(const MonitoredPair& pair);

 private:
  struct Carrier {
    Pose X_WC = Pose::Identity();
    bool placed = false;
    std::vector<int> parts;
  };

  void add_part(MonitoredPart part, int side, const PlacedShape& placed);
  /// Returns an upper bound of how far its points have moved [m].
  double move(Carrier& carrier, const Pose& X_WC);
  [[nodiscard]] btTransform X_WS(const MonitoredPart& part) const;
  /// Empty: the two are no pair. Self pairs of links are listed by the arm instead.
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
  std::vector<double> travel_;       ///< of each part: no point has moved farther since the start [m]
  std::vector<int> sides_;           ///< of each part: its arm's index, or (arms + obstacle's index), carried or not
  std::vector<double> side_travel_;  ///< of each side: no point has moved farther since the start [m]
  std::vector<MonitoredPair> pairs_;
  PairBlocks blocks_;
  std::vector<Eigen::Vector3d> normals_;  ///< of each pair: from b towards a, in a's carrier frame, when last computed
  int group_count_ = 0;
  std::vector<std::string> names_;
  std::map<std::string, int> name_indices_;
};

}  // namespace hecaton::world
