#pragma once
/// Two parts that the contact monitor judges against each other, and what it remembers of them.

#include <cstdint>
#include <utility>

#include "world/sim/contact_monitor.hpp"

namespace hecaton::world {

/// What the contact monitor remembers of a pair, also through edits.
struct PairState {
  bool touching = false;
  bool fresh = false;       ///< arose by attaching or detaching and was not yet compared
  bool excused = false;     ///< touched at that moment and has not parted since
  double excused_at = 0.0;  ///< distance then [m]

  /// To be looked at whatever its bounds are.
  [[nodiscard]] bool watched() const { return touching || fresh || excused; }
};

/// Its current distance lies between lower_ref − travel and upper_ref + travel, travel being that of both parts.
struct MonitoredPair {
  /// Both names, and the how-manieth pair of these names: the same before and after an edit, as shapes keep their
  /// order.
  using Identity = std::pair<std::uint64_t, int>;

  int a = 0;  ///< parts
  int b = 0;
  int index = 0;  ///< in MonitoredPairs::pairs()
  int group = 0;  ///< pairs of parts with the same two names are one contact
  ContactKind kind = ContactKind::kArmArm;
  Identity identity;
  PairState state;
  double lower_ref = 0.0;  ///< [m]
  double upper_ref = 0.0;  ///< [m]
};

}  // namespace hecaton::world
