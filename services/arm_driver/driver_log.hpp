#pragma once
/// The driver's log of planners: which planner moved the arm at which time, and which was refused. It decides nothing.

#include <algorithm>
#include <bit>
#include <chrono>
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

/// A planner's process and the lease under which it commands.
struct Commander {
  ArmLease lease;
  bus::EndpointId writer;  ///< of its commands; a restarted node has another
  bool operator==(const Commander&) const = default;
};

/// Decides which accepted and refused commands are worth a line. Pure.
class CommandRecord {
 public:
  static constexpr std::size_t kRemembered = 64;  ///< most refused commanders; the oldest in excess are forgotten

  /// Call it for each accepted command. Returns the former commander when `commander` differs from it; the first time,
  /// that is one of term 0.
  [[nodiscard]] std::optional<Commander> accepted(const Commander& commander) {
    if (commander == followed_) return std::nullopt;
    return std::exchange(followed_, commander);
  }

  /// Call it for each refused command; `why` is the kind of reason. Returns how often that has happened at the 1st,
  /// 2nd, 4th, 8th … time, otherwise 0: a stale planner repeats itself a hundred times a second.
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
  std::deque<Refused> refused_;  ///< in the order of their first refusals
};

/// Tells commands of a term that no supervisor has granted from those that arrive before their grant: while leaders
/// change, the grant may come some hundred milliseconds later.
class UngrantedCommands {
 public:
  static constexpr std::chrono::seconds kLasting{1};
  static constexpr std::chrono::seconds kPause{1};  ///< after a longer one it begins anew

  /// Call it for each such command. True when they have arrived for kLasting.
  [[nodiscard]] bool note(bus::Clock::time_point at) {
    if (at - last_ > kPause) begin_ = at;
    last_ = at;
    return at - begin_ >= kLasting;
  }

 private:
  bus::Clock::time_point begin_{};
  bus::Clock::time_point last_{};
};

/// Logs each change once.
class DriverLog {
 public:
  /// See UngrantedCommands.
  [[nodiscard]] bool not_granted(bus::Clock::time_point at) { return ungranted_.note(at); }
  void accepted(const bus::Sample<msg::ArmCommand>& sample);
  void refused(const bus::Sample<msg::ArmCommand>& sample, const Judgement& judgement);
  /// Call it for a lease that differs from lease().
  void lease(const ArmLease& newest);
  /// The lease that was logged last.
  [[nodiscard]] const ArmLease& lease() const { return lease_; }
  void state(const msg::ArmState& state);

 private:
  CommandRecord record_;
  UngrantedCommands ungranted_;
  bus::Clock::time_point accepted_at_{};  ///< arrival of the last accepted command
  ArmLease lease_;
  msg::ArmMode mode_ = msg::ArmMode::ARM_STARTING;
};

}  // namespace hecaton::services
