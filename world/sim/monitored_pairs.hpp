#pragma once
/// The pairs that the contact monitor checks: parts on carriers, bounds of their distances, and a broad phase.
///
/// Pairs of a moving part of an arm and an obstacle that stands exist only while the two are near (NearPairs). All
/// other pairs always exist, in blocks (PairBlocks).

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "world/sim/bullet_shape.hpp"
#include "world/sim/cloud_balls.hpp"
#include "world/sim/contact_monitor.hpp"
#include "world/sim/shape_tree.hpp"

namespace hecaton::world {

/// Error of a computed distance, for the bounds derived from it [m].
inline constexpr double kDistanceError = 2e-4;

/// One convex shape, or the balls of a cloud, on its carrier: a link of an arm, or an obstacle.
struct MonitoredPart {
  int carrier = 0;
  int arm = -1;                                ///< −1: of a free obstacle
  int link = -1;                               ///< of that arm; −1: of an obstacle, free or carried
  bool moves = true;                           ///< two parts that do not move are no pair: a base stands on its table
  bool handled = false;                        ///< of the obstacle that was just attached or detached
  int name = 0;                                ///< index into MonitoredPairs::names()
  int rank = 0;                                ///< among the parts with this name
  std::shared_ptr<const btConvexShape> shape;  ///< around the balls, if there are any: it bounds their distances
  std::shared_ptr<const CloudBalls> balls;     ///< null: of a convex shape
  Pose X_CS = Pose::Identity();
  Eigen::Vector3d centre_C = Eigen::Vector3d::Zero();  ///< of the bounding sphere [m]
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();
  double radius = 0.0;  ///< of the bounding sphere [m]

  /// True: of an obstacle that no arm carries and that stands.
  [[nodiscard]] bool stands() const { return arm < 0 && !moves; }
  /// True: of an arm, or of what it carries, and not fixed to its base.
  [[nodiscard]] bool moves_with_arm() const { return arm >= 0 && moves; }
};

/// Two parts. Their distance lies between lower_ref − travel and upper_ref + travel; travel is the sum of both parts'.
struct MonitoredPair {
  /// Both names, and the number of the pair among those with these names. Stays the same through edits, because shapes
  /// keep their order.
  using Identity = std::pair<std::uint64_t, int>;

  int a = 0;                ///< index of a part
  int b = 0;                ///< index of a part
  std::uint64_t order = 0;  ///< of all pairs
  ContactKind kind = ContactKind::kArmArm;
  Identity identity;  ///< pairs with the same names form one contact
  PairState state;
  double lower_ref = -std::numeric_limits<double>::infinity();  ///< [m]
  double upper_ref = std::numeric_limits<double>::infinity();   ///< [m]
  Eigen::Vector3d n_C = Eigen::Vector3d::UnitZ();  ///< from b towards a, in a's carrier frame, when last computed
};

struct PairIdentityHash {
  std::size_t operator()(const MonitoredPair::Identity& identity) const {
    return std::hash<std::uint64_t>()(identity.first * 0x9E3779B97F4A7C15U +
                                      static_cast<std::uint64_t>(identity.second));
  }
};
using PairStates = std::unordered_map<MonitoredPair::Identity, PairState, PairIdentityHash>;

/// Pairs [first, end) of those in blocks.
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

class MonitoredPairs;

/// Pairs of a part that moves with an arm and an obstacle that stands. Each such part keeps the pairs that may be
/// nearer than the smallest separation so far or than contact, and a skin: until the part has moved through the skin,
/// there are no others. Watched pairs are always kept.
class NearPairs {
 public:
  /// Forgets all pairs and boxes. `parts`: their number.
  void clear(int parts);
  /// Adds a pair that must be checked, or sets the state of one.
  void keep(const MonitoredPairs& all, int mover, int standing, const PairState& state);
  /// Must follow each change of the place of a part that stands.
  void put(const MonitoredPairs& all, int standing);
  /// The pairs must be found again: reach may have grown, or an obstacle has moved.
  void expire() { found_.assign(found_.size(), {}); }

  /// Appends all pairs whose distance may lie below `smallest` [m] or below contact, and all watched ones.
  void candidates(const MonitoredPairs& all, double smallest, std::vector<MonitoredPair*>& out);
  /// Calls visit(standing) for each obstacle's part whose box is at most `reach` [m] from the box of `mover`.
  template <typename Visit>
  void within(const MonitoredPairs& all, int mover, double reach, const Visit& visit) const;

  /// The pairs that exist now, of each part.
  [[nodiscard]] std::vector<std::vector<MonitoredPair>>& lists() { return lists_; }
  [[nodiscard]] bool any_standing() const { return any_standing_; }

 private:
  struct Found {
    double reach = -1.0;  ///< the list was complete for pairs at most this far apart [m]
    double travel = 0.0;  ///< of the part at that time [m]
  };

  void find(const MonitoredPairs& all, int mover, double reach);
  /// An upper bound of the smallest distance that counts now [m]; infinite without such pairs.
  [[nodiscard]] double least_distance(const MonitoredPairs& all) const;

  ShapeTree tree_;                                 ///< of the parts that stand
  std::vector<BoundingBox> boxes_;                 ///< of these
  bool any_standing_ = false;                      ///< put() was called
  std::vector<std::vector<MonitoredPair>> lists_;  ///< of each part: ascending by the obstacle's part
  std::vector<Found> found_;                       ///< of each part
  std::vector<int> near_;
};

/// All parts and pairs of a cell, and how far each part has moved.
class MonitoredPairs {
 public:
  explicit MonitoredPairs(std::vector<ArmBodies> arms);

  /// See ContactMonitor::set_obstacles(). Afterwards all bounds are unknown and no obstacle has a pose.
  void set_obstacles(std::span<const Obstacle> obstacles, const std::string& handled);
  /// See ContactMonitor::update(). Reads the states of obstacles with a greater number than at the last call.
  void place(std::span<const MeasuredArm> arms, const PresentStates& obstacles);

  /// Calls visit(pair) for each pair that exists: all but those of obstacles that stand and are not near.
  template <typename Visit>
  void for_each(const Visit& visit) {
    for (MonitoredPair& pair : pairs_) visit(pair);
    for (auto& list : near_.lists()) {
      for (MonitoredPair& pair : list) visit(pair);
    }
  }
  /// The pairs that no longer exist had the default state.
  void set_states(const PairStates& states);

  /// Pairs whose distance may lie below `smallest` [m] of their kind or below contact, and all watched ones, in their
  /// order. Valid until the next call. update_bounds() must follow once all of them are checked.
  [[nodiscard]] std::span<MonitoredPair* const> candidates(const std::array<double, kContactKinds>& smallest);
  void update_bounds() { blocks_.update(pairs_, travel_, side_travel_); }
  /// Must follow a change of pair states or of smallest separations outside an update.
  void reset_bounds() {
    blocks_.reset_bounds();
    near_.expire();
  }
  /// True: a pair of a moving part and an obstacle that stands has a pose.
  [[nodiscard]] bool any_standing_pair() const;

  [[nodiscard]] int part_count() const { return static_cast<int>(parts_.size()); }
  [[nodiscard]] const MonitoredPart& part(int index) const { return parts_[index]; }
  /// Only grows: an index stays valid through edits.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Index of `name` in names(); adds it if it is new.
  int name_index(const std::string& name);
  /// Identity of the pair of these parts, whether or not it exists.
  [[nodiscard]] MonitoredPair::Identity identity(int a, int b) const;
  /// Indices of the parts that move with an arm.
  [[nodiscard]] const std::vector<int>& movers() const { return movers_; }
  [[nodiscard]] const NearPairs& near() const { return near_; }
  /// The pair of a part that moves with an arm and a part that stands, without bounds and state.
  [[nodiscard]] MonitoredPair near_pair(int mover, int standing) const;

  [[nodiscard]] bool placed(int part) const { return carriers_[parts_[part].carrier].placed; }
  /// True once both parts have a pose.
  [[nodiscard]] bool placed(const MonitoredPair& pair) const { return placed(pair.a) && placed(pair.b); }
  [[nodiscard]] double travel(int part) const { return travel_[part]; }
  /// Sum of both parts' travel [m]; only grows.
  [[nodiscard]] double travel(const MonitoredPair& pair) const { return travel_[pair.a] + travel_[pair.b]; }
  [[nodiscard]] btTransform X_WS(const MonitoredPart& part) const;
  [[nodiscard]] BoundingBox box(int part) const { return bounding_box(*parts_[part].shape, X_WS(parts_[part])); }
  /// Lower bound from the bounding spheres [m]; negative where they overlap.
  [[nodiscard]] double sphere_distance(const MonitoredPair& pair) const;
  /// Lower bound along the normal of the last exact_distance(), fixed to part a [m]. Tight as long as the two have
  /// turned little against each other.
  [[nodiscard]] double gap_along_last_normal(const MonitoredPair& pair) const;
  /// Sets the pair's normal.
  double exact_distance(MonitoredPair& pair) const;

 private:
  struct Carrier {
    Pose X_WC = Pose::Identity();
    bool placed = false;
    std::vector<int> parts;
  };

  void add_part(MonitoredPart part, int side, const PlacedShape& placed);
  void place_obstacle(int obstacle, const ObstacleState& state, std::span<const MeasuredArm> arms);
  /// Returns an upper bound of how far its points have moved [m].
  double move(Carrier& carrier, const Pose& X_WC);
  /// Empty: the two are no pair. Self pairs of links are listed by the arm instead.
  [[nodiscard]] std::optional<ContactKind> kind_of(const MonitoredPart& a, const MonitoredPart& b) const;
  /// Pairs in blocks.
  [[nodiscard]] std::vector<MonitoredPair> pairs_in_blocks() const;
  /// Makes all pairs of the parts. Pairs that are known keep their states.
  void adopt();
  /// Keeps each near pair whose state `states` has.
  void keep_near(const PairStates& states);

  std::vector<ArmBodies> arms_;
  std::vector<int> first_link_;  ///< carrier of link 0 of each arm
  std::vector<int> first_part_;  ///< of each arm
  int links_ = 0;                ///< carriers that are links; the obstacles follow
  int link_parts_ = 0;           ///< parts that are links'; the obstacles' follow
  std::vector<Carrier> carriers_;
  std::vector<MonitoredPart> parts_;
  std::vector<int> movers_;
  std::vector<double> travel_;       ///< of each part: no point has moved farther since the start [m]
  std::vector<int> sides_;           ///< of each part: its arm's index, or (arms + obstacle's index), carried or not
  std::vector<double> side_travel_;  ///< of each side: no point has moved farther since the start [m]
  std::uint64_t seen_ = 0;           ///< greatest number of a change of an obstacle's state
  std::vector<int> waiting_;         ///< obstacles without a pose, because an unknown arm carries them
  std::vector<MonitoredPair> pairs_;
  PairBlocks blocks_;
  NearPairs near_;
  std::vector<MonitoredPair*> open_;
  std::vector<MonitoredPair*> open_near_;
  std::vector<std::string> names_;
  std::vector<int> name_parts_;  ///< parts with each name
  std::unordered_map<std::string, int> name_indices_;
};

template <typename Visit>
void NearPairs::within(const MonitoredPairs& all, int mover, double reach, const Visit& visit) const {
  const BoundingBox box = all.box(mover);
  tree_.overlapping(box.grown(reach), [&](int standing) {
    if (boxes_[static_cast<std::size_t>(standing)].distance(box) <= reach) visit(standing);
  });
}

}  // namespace hecaton::world
