#pragma once
/// Contacts and smallest separations of a cell, from measured poses and Bullet's geometry. The contact monitor shares
/// no code with the planner's distances, so that a report does not depend on what the planner believes.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "world/model/present_states.hpp"
#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::world {

inline constexpr int kContactKinds = 3;

/// A contact begins at a distance ≤ 0 and ends when the distance exceeds this [m].
inline constexpr double kPartedDistance = 1e-3;

/// An arm as the world needs it: shapes fixed to links. The link poses are measured.
struct ArmBodies {
  struct Part {
    int link = 0;  ///< index into the measured link poses
    std::string link_name;
    PlacedShape shape;  ///< in the link's frame
    bool moves = true;  ///< false: fixed to the base
  };
  std::string name;
  std::vector<Part> parts;
  std::vector<std::pair<int, int>> self_pairs;  ///< indices of parts that are checked against each other
  std::vector<int> grasp_links;                 ///< links that an attached obstacle may touch
  int robot = -1;  ///< arms with the same number ≥ 0 share the parts that do not move; −1: a robot of its own
};

/// Where an arm is. The monitor skips an arm that is not `known`, and what it carries.
struct MeasuredArm {
  bool known = false;
  std::span<const Pose> X_WL;  ///< index = link
};

/// Contacts of one kind.
struct KindReport {
  std::uint64_t contacts = 0;
  bool has_smallest = false;  ///< false until the first pair of this kind is checked
  Separation smallest;        ///< valid if has_smallest
};

/// Totals since the start. A contact counts once, from touching until the pair has parted. A pair is a link or a
/// carried obstacle against another link or obstacle, however many shapes each has.
struct ContactReport {
  std::uint64_t contacts = 0;
  bool has_smallest = false;                    ///< false until the first pair is checked
  Separation smallest;                          ///< over all kinds; valid if has_smallest
  std::array<KindReport, kContactKinds> kinds;  ///< index = ContactKind
  std::vector<Separation> events;               ///< the first 100 contacts, as they began
};

/// State of a pair that is touching or was just handled.
struct PairState {
  bool touching = false;            ///< counted, and not parted since
  bool handled = false;             ///< just attached or detached, and not checked since
  bool tolerated = false;           ///< touched when it was handled, and not parted since
  double tolerated_distance = 0.0;  ///< distance when it was handled [m]

  /// True: the pair must be checked in every update, whatever its bounds say.
  [[nodiscard]] bool watched() const { return touching || handled || tolerated; }
};

struct PairCheckpoint {
  std::string a;  ///< as in Separation
  std::string b;
  int occurrence = 0;  ///< among the pairs with these two names
  PairState state;
};

/// What another contact monitor needs in order to continue the totals of this one.
struct ContactCheckpoint {
  ContactReport report;
  std::vector<PairCheckpoint> pairs;  ///< all watched pairs
};

/// Checks these pairs in every update:
/// - arm–arm: parts of different arms and what they carry, unless both are fixed to their bases;
///   of two arms of one robot only parts that move;
/// - arm–obstacle: parts of arms and what they carry against free obstacles, unless neither moves;
/// - arm–self: an arm's self pairs, and what it carries against its links other than the grasp links.
/// Obstacles are not checked against each other.
///
/// An update looks at moving things and what is near them: obstacles that stand far away cost nothing.
///
/// Each pair keeps a lower bound of its distance. The monitor computes the distance again only when the bound, less the
/// motion since, falls below the smallest separation of that kind or below contact. Motion between two updates is not
/// swept: a short contact between them is missed. Not thread-safe.
class ContactMonitor {
 public:
  /// The order of `arms` defines their indices. Shapes must have passed why_invalid(). Throws std::invalid_argument
  /// when a part has no link or a self pair names a part that does not exist.
  explicit ContactMonitor(std::vector<ArmBodies> arms);
  ~ContactMonitor();
  ContactMonitor(ContactMonitor&&) noexcept;
  ContactMonitor& operator=(ContactMonitor&&) noexcept;

  /// Replaces the obstacles. Totals and lasting contacts stay; pairs are matched by name. The monitor skips an obstacle
  /// that is attached to an unknown arm.
  ///
  /// `handled` names the obstacle that was just attached or detached; empty: none. What that obstacle touches now (the
  /// table it lies on, the open fingers) is tolerated until the two have parted, or until they overlap 1 mm deeper.
  void set_obstacles(std::span<const Obstacle> obstacles, const std::string& handled = {});

  /// Checks the poses at `time` [s]: one entry per arm and one per obstacle, attached ones included. Reads only states
  /// that have changed since the last update. Poses must be finite. Throws std::invalid_argument when an entry, or a
  /// link of a known arm, is missing.
  void update(std::span<const MeasuredArm> arms, const PresentStates& obstacles, double time);

  [[nodiscard]] ContactReport report() const;
  [[nodiscard]] ContactCheckpoint checkpoint() const;
  /// Replaces the totals by those of `checkpoint`. Pairs are matched by name; unknown pairs are dropped.
  void restore(const ContactCheckpoint& checkpoint);
  /// Clears the totals. A contact that lasts is counted again.
  void reset();

  /// The smallest separation of one arm at the last update. Empty when the arm is unknown or has no pair. `with_self`
  /// includes the arm's own pairs.
  [[nodiscard]] std::optional<Separation> nearest(int arm, bool with_self = false) const;

  /// Number of distances computed by Bullet so far.
  [[nodiscard]] std::uint64_t exact_checks() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::world
