#pragma once
/// The independent judge of a run: contacts and smallest separations between arms, obstacles and each arm's own links,
/// from measured poses and Bullet's own geometry; it shares no code with the planner's distances.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "world/model/scene.hpp"
#include "world/model/separation.hpp"
#include "world/model/snapshot.hpp"
#include "world/sim/arm_bodies.hpp"

namespace hecaton::world {

inline constexpr int kContactKinds = 3;

/// A contact begins at a distance ≤ 0 and lasts until the two are further apart than this [m].
inline constexpr double kPartedDistance = 1e-3;

/// The account of one kind of pairs.
struct KindReport {
  std::uint64_t contacts = 0;
  bool has_smallest = false;  ///< false until two bodies of this kind were ever compared; then `smallest` means nothing
  Separation smallest;
};

/// What a report quotes. A contact is counted once from touching until the pair has parted again; a pair is a link (or
/// carried obstacle) against another link or obstacle, however many shapes each consists of.
struct ContactReport {
  std::uint64_t contacts = 0;
  bool has_smallest = false;  ///< false until two bodies were ever compared; then `smallest` means nothing
  Separation smallest;  ///< over all kinds
  std::array<KindReport, kContactKinds> kinds;  ///< index = ContactKind
  std::vector<Separation> events;               ///< the first 100 contacts, as they began
};

/// Two bodies that are not simply apart.
struct LastingPair {
  std::string a;  ///< as in Separation
  std::string b;
  int which = 0;            ///< of the pairs with these two names
  bool touching = false;    ///< counted, and not parted since
  bool fresh = false;       ///< arose by attaching or detaching and was not yet compared
  bool excused = false;     ///< touched at that moment and has not parted since
  double excused_at = 0.0;  ///< distance then [m]
};

/// All that a contact monitor must know to go on with the account of another.
struct ContactCheckpoint {
  ContactReport report;
  std::vector<LastingPair> lasting;
};

/// Where an arm is. Until it is `known`, nothing of it and nothing it carries is judged.
struct MeasuredArm {
  bool known = false;
  std::span<const Pose> X_WL;  ///< index = link
};

/// Which pairs it judges:
/// - arm–arm: parts of different arms, with what they carry, unless neither of the two can move;
/// - arm–obstacle: parts that move, with what they carry, against every free obstacle, also one that can be pushed;
/// - arm–self: the arm's self pairs, and what it carries against its own links other than the grasp links.
/// Obstacles are never judged against each other.
///
/// Costs next to nothing where nothing is near: each pair remembers a lower bound of its distance and how far its two
/// bodies have moved since; only when that bound falls below the smallest separation of its kind so far, or below
/// contact, is the distance computed again. All pairs between two arms, or an arm and an obstacle, are skipped at once
/// while none of them can be concerned (pair_blocks.hpp). Motion between two calls is not swept: judge often.
class ContactMonitor {
 public:
  /// Indices of arms as given here. Shapes must have passed why_invalid(); throws std::invalid_argument when a self
  /// pair names a part that does not exist.
  explicit ContactMonitor(std::vector<ArmBodies> arms);
  ~ContactMonitor();
  ContactMonitor(ContactMonitor&&) noexcept;
  ContactMonitor& operator=(ContactMonitor&&) noexcept;

  /// Replaces the obstacles; the account and contacts that last are kept, matched by name. An obstacle attached to an
  /// unknown arm is never judged.
  ///
  /// `handled` names the obstacle that was just attached or detached, if any. What it touches at that moment (the table
  /// it lay on, the fingers that let it go) is excused: judged only once the two have parted, or have come 1 mm deeper.
  void set_obstacles(std::span<const Obstacle> obstacles, const std::string& handled = {});

  /// Takes the poses at `time` [s] into account: one entry per arm, one per obstacle, also for those attached. All
  /// poses must be finite. Throws std::invalid_argument when an entry, or a link of a known arm, is missing.
  void update(std::span<const MeasuredArm> arms, std::span<const ObstacleState> obstacles, double time);

  [[nodiscard]] ContactReport report() const;
  [[nodiscard]] ContactCheckpoint checkpoint() const;
  /// Goes on with that account instead of its own. Pairs are matched by name; those that do not exist are forgotten.
  void restore(const ContactCheckpoint& checkpoint);
  /// Begins a new account. A contact that lasts counts again.
  void reset();

  /// The smallest separation of that arm at the last update(), whatever was smaller before. Empty while the arm is
  /// unknown or has nothing to be compared with. `with_self` includes the arm's own pairs, which seldom change.
  [[nodiscard]] std::optional<Separation> nearest(int arm, bool with_self = false) const;

  /// Distances computed exactly so far: what the bounds did not spare.
  [[nodiscard]] std::uint64_t exact_checks() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::world
