#pragma once
/// Notices peers whose authentication does not end. Private to services/bus; standard library only.
///
/// Fast DDS 2.9.1 sometimes never ends the handshake of two participants that start at the same time: each waits for
/// the other. A quarantine (PeerQuarantine) makes both drop each other, and the next handshake begins from nothing.

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <vector>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// Thread-safe.
class AuthenticationWatch {
 public:
  using Prefix = std::array<std::uint8_t, 12>;  ///< of a participant's GUID
  /// A handshake takes some 30 ms of processor time on each side. Many begin at once when a cell starts.
  static constexpr std::chrono::seconds kLimit{3};

  void found(const Prefix& peer, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    pending_.emplace(peer, now);
  }
  /// The handshake has ended, or the peer is gone.
  void ended(const Prefix& peer) {
    const std::scoped_lock lock(mutex_);
    pending_.erase(peer);
  }
  /// The peers whose handshake takes longer than kLimit. Each is returned once.
  [[nodiscard]] std::vector<Prefix> take_overdue(Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    std::vector<Prefix> overdue;
    for (const auto& [peer, since] : pending_) {
      if (now - since > kLimit) overdue.push_back(peer);
    }
    for (const Prefix& peer : overdue) pending_.erase(peer);
    return overdue;
  }

 private:
  std::mutex mutex_;
  std::map<Prefix, Clock::time_point> pending_;
};

}  // namespace hecaton::bus
