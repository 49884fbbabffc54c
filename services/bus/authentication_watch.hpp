#pragma once
/// Knows the peers that discovery has found and that are not connected yet. Private to services/bus; standard
/// library only.
///
/// Fast DDS 2.9.1 sometimes never ends the handshake of two participants that start at the same time: each waits for
/// the other. A quarantine (PeerQuarantine) makes both drop each other, and the next handshake begins from nothing.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// Thread-safe.
class AuthenticationWatch {
 public:
  using Prefix = std::array<std::uint8_t, 12>;  ///< of a participant's GUID
  /// A handshake is overdue when for so long neither it nor any other has ended well. Many begin at once when a cell
  /// starts, and on a busy machine they take seconds: to begin them again would take even longer. Those that fail do
  /// not count: an intruder without keys may fail as often as it likes.
  static constexpr std::chrono::seconds kLimit{3};
  /// The same, whatever others do.
  static constexpr std::chrono::seconds kLongest{15};
  /// The endpoints of an authorized peer are matched within this time, or it has none that match.
  static constexpr std::chrono::seconds kMatching{1};

  void found(const Prefix& peer, std::string name, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    const auto [known, first] = peers_.try_emplace(peer, Peer{std::move(name), now});
    if (!first && known->second.stage == Stage::kOverdue) known->second = {known->second.name, now};
  }
  /// The handshake has ended: the endpoints of an authorized peer come next.
  void ended(const Prefix& peer, bool authorized, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    if (authorized) progress_ = now;
    const auto known = peers_.find(peer);
    if (known == peers_.end()) return;
    if (!authorized) {
      peers_.erase(known);
    } else {
      known->second.stage = Stage::kAuthorized;
      known->second.since = now;
    }
  }
  /// An endpoint of the peer was matched, or the peer is gone.
  void forget(const Prefix& peer) {
    const std::scoped_lock lock(mutex_);
    peers_.erase(peer);
  }
  /// The peers whose handshake is overdue. Each is returned once.
  [[nodiscard]] std::vector<Prefix> take_overdue(Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    std::vector<Prefix> overdue;
    for (auto& [prefix, peer] : peers_) {
      if (peer.stage != Stage::kHandshake) continue;
      if (now - std::max(peer.since, progress_) <= kLimit && now - peer.since <= kLongest) continue;
      peer.stage = Stage::kOverdue;
      overdue.push_back(prefix);
    }
    return overdue;
  }
  /// The names of the peers that are found and not connected. Without keys there is no handshake: then also those that
  /// have no endpoint that matches.
  [[nodiscard]] std::vector<std::string> joining(Clock::time_point now) const {
    const std::scoped_lock lock(mutex_);
    std::vector<std::string> names;
    for (const auto& [prefix, peer] : peers_) {
      if (peer.stage != Stage::kAuthorized || now - peer.since <= kMatching) names.push_back(peer.name);
    }
    return names;
  }

 private:
  enum class Stage : std::uint8_t { kHandshake, kOverdue, kAuthorized };
  struct Peer {
    std::string name;
    Clock::time_point since;
    Stage stage = Stage::kHandshake;
  };

  mutable std::mutex mutex_;
  std::map<Prefix, Peer> peers_;
  Clock::time_point progress_{};  ///< when a handshake ended
};

}  // namespace hecaton::bus
