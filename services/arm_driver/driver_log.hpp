#pragma once
/// Which planner has moved the arm since when, and which was refused, as the driver's log tells it: so that a person
/// can say afterwards which planner moved the arm at any time. It decides nothing.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "services/arm_driver/command_gate.hpp"
#include "services/bus/endpoint.hpp"
#include "services/runtime/arm_lease.hpp"

namespace hecaton::services {

/// A process of a planner, and the term under which it commands.
struct Commander {
  ArmLease lease;
  bus::EndpointId writer;  ///< of its commands: two lives of one node differ
  bool operator==(const Commander&) const = default;
};

class CommandRecord {
 public:
  static constexpr std::size_t kRemembered = 64;  ///< refused commanders; of an older one a refusal is a first again

  /// A command of `commander` was accepted. Whose was before when that was another's, or of another term: term 0 for
  /// the first.
  [[nodiscard]] std::optional<Commander> accepted(const Commander& commander) {
    if (commander == followed_) return std::nullopt;
    return std::exchange(followed_, commander);
  }

  /// A command of `commander` was refused, for the same kind of reason as others with this `why`. How often that
  /// happened so far when it is to be told, which is the 1st, 2nd, 4th, 8th … time: a stale sender repeats itself a
  /// hundred times a second. Otherwise 0.
  [[nodiscard]] std::uint64_t refused(const Commander& commander, int why) {
    auto found = std::find_if(refused_.begin(), refused_.end(),
                              [&](const Refused& one) { return one.commander == commander && one.why == why; });
    if (found == refused_.end()) {
      if (refused_.size() == kRemembered) refused_.pop_front();
      found = refused_.insert(refused_.end(), Refused{commander, why, 0});
    }
    return std::has_single_bit(++found->times) ? found->times : 0;
  }

 private:
  struct Refused {
    Commander commander;
    int why = 0;
    std::uint64_t times = 0;
  };
  Commander followed_;
  std::deque<Refused> refused_;  ///< who was refused first comes first
};

/// Writes the driver's log: each change once.
class DriverLog {
 public:
  void accepted(const bus::Sample<msg::ArmCommand>& sample);
  void refused(const bus::Sample<msg::ArmCommand>& sample, const Judgement& judgement);
  /// Another lease than lease().
  void lease(const ArmLease& newest);
  /// As written last.
  [[nodiscard]] const ArmLease& lease() const { return lease_; }
  void state(const msg::ArmState& state);

 private:
  CommandRecord record_;
  bus::Clock::time_point accepted_at_{};  ///< when the command that was accepted last arrived
  ArmLease lease_;
  msg::ArmMode mode_ = msg::ArmMode::ARM_STARTING;
};

}  // namespace hecaton::services
