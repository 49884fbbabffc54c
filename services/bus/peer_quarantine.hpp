#pragma once
/// Ignores peers for a while after a loss. Private to services/bus; standard library only.
///
/// When a link is down for about as long as the lease, only one side may drop the other. Or each side's new
/// announcements reach the other side before that has dropped it. Fast DDS 2.9.1 does not heal this: the two never
/// exchange their endpoints again (docs/explanation/0005-process-recovery.md). So a participant quarantines a peer that
/// is silent for most of the lease, and a peer that Fast DDS drops. Until the lease is over on both sides it neither
/// receives from the peer nor sends to it. Then both discover each other again. LocalStallGuard does the same for a
/// process that was itself stopped.
///
/// A process without enough processor time reads old datagrams for a while, and drops no peer in the meantime. Then
/// only one side drops the other in spite of the quarantine. That side finds the peer again, but none of its endpoints:
/// it quarantines the peer once more, each time after twice the time. A peer without endpoints comes to no harm.
///
/// A peer with a longer lease may be silent for longer. Silence does not quarantine it, only its loss does.
/// Participants of a cell have one lease. Programs of other DDS vendors have 10 s or more, and only listen in the
/// meantime.
///
/// A peer whose certificate is revoked is quarantined, too, and never received again. Fast DDS drops it at the end of
/// its lease.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/participant_sources.hpp"
#include "services/bus/rediscovery.hpp"

namespace hecaton::bus {

/// Thread-safe.
class PeerQuarantine {
 public:
  using Prefix = ParticipantSources::Prefix;      ///< of a participant's GUID
  using Beginning = std::array<std::uint8_t, 6>;  ///< of the prefixes of an identity, see GuidBeginning
  /// IPv4 address and port, see address_of().
  using Address = ParticipantSources::Address;
  static Address address_of(std::uint32_t ipv4, std::uint16_t port) { return Address{ipv4} << 16U | port; }

  explicit PeerQuarantine(Clock::duration lease) : lease_(lease) {}

  /// Discovery has found a participant that receives at these addresses and announces this lease.
  void found(const Prefix& peer, std::vector<Address> addresses, Clock::duration lease, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    // Found before update() has ended its quarantine: a later update() must not forget the peer.
    const auto former = peers_.find(peer);
    if (former != peers_.end() && former->second.quarantined && now >= former->second.back) forget(former);
    Peer& known = peers_[peer];
    known.heard = std::max(known.heard, now);
    known.found = now;
    known.has_endpoints = false;
    known.addresses = std::move(addresses);
    known.may_be_silent = lease > lease_;
  }
  /// Discovery has found an endpoint of the peer.
  void endpoint_found(const Prefix& peer) {
    const std::scoped_lock lock(mutex_);
    mute_.erase(peer);
    const auto known = peers_.find(peer);
    if (known != peers_.end()) known->second.has_endpoints = true;
  }
  /// The peer has announced its departure. A quarantine goes on to its end.
  void left(const Prefix& peer, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    const auto known = peers_.find(peer);
    if (known != peers_.end() && now >= known->second.back) forget(known);
  }
  /// Fast DDS has dropped the peer at the end of its lease. The quarantine begins now unless it has begun before: the
  /// peer may have received this participant an instant ago, and would otherwise not drop it.
  void dropped(const Prefix& peer, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    const auto known = peers_.find(peer);
    if (known != peers_.end() && !known->second.quarantined) begin_quarantine(known->second, now);
  }

  /// True when a datagram of the peer may be received; it then counts as a sign of life. Call it once for each
  /// datagram.
  [[nodiscard]] bool accepts(const Prefix& peer, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    const auto known = peers_.find(peer);
    if (known == peers_.end()) return true;
    if (now < known->second.back) return false;
    known->second.heard = std::max(known->second.heard, now);
    return true;
  }
  /// When a datagram of the peer was accepted last, or discovery found it; nothing: it is unknown.
  [[nodiscard]] std::optional<Clock::time_point> last_heard(const Prefix& peer) const {
    const std::scoped_lock lock(mutex_);
    const auto known = peers_.find(peer);
    return known == peers_.end() ? std::nullopt : std::optional(known->second.heard);
  }
  /// Peers of these identities are revoked from now on, beside those of earlier calls.
  void revoke(const std::vector<Beginning>& identities, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    for (const Beginning& identity : identities) {
      if (!revoked_.insert(identity).second) continue;
      for (auto& [prefix, peer] : peers_) {
        if (!peer.quarantined && beginning_of(prefix) == identity) begin_quarantine(peer, now);
      }
    }
    any_revoked_ = !revoked_.empty();
  }
  /// True when no datagram of the peer may be received ever. Cheap enough for every datagram.
  [[nodiscard]] bool is_revoked(const Prefix& peer) const {
    if (!any_revoked_) return false;
    const std::scoped_lock lock(mutex_);
    return revoked_.contains(beginning_of(peer));
  }
  /// Cheap enough for every datagram that is sent.
  [[nodiscard]] bool any_quarantined() const { return quarantined_.load() > 0; }
  /// False also when another peer receives there: the quarantined one is gone, or it has forged the address.
  [[nodiscard]] bool is_quarantined(Address address) const {
    const std::scoped_lock lock(mutex_);
    bool quarantined = false;
    for (const auto& [prefix, peer] : peers_) {
      if (!peer.has(address)) continue;
      if (!peer.quarantined) return false;
      quarantined = true;
    }
    return quarantined;
  }

  /// Begins and ends quarantines; for one thread. Silence before `since` does not count, because this process did not
  /// receive then.
  void update(Clock::time_point now, Clock::time_point since) {
    const std::scoped_lock lock(mutex_);
    for (auto entry = peers_.begin(); entry != peers_.end();) {
      Peer& peer = entry->second;
      if (peer.quarantined && now >= peer.back) {
        entry = forget(entry);  // discovery finds it again
        continue;
      }
      const bool silent = now - std::max(peer.heard, since) > silence_limit(lease_);
      const bool mute = is_mute(entry->first, peer, now, since);
      if (!peer.quarantined && !peer.may_be_silent && (silent || mute)) {
        if (mute) count_mute(entry->first);
        begin_quarantine(peer, now);
      }
      ++entry;
    }
  }

 private:
  struct Peer {
    Clock::time_point found{};
    Clock::time_point heard{};
    Clock::time_point back{};  ///< end of its quarantine
    bool has_endpoints = false;
    bool quarantined = false;
    bool may_be_silent = false;  ///< its lease is longer
    std::vector<Address> addresses;

    [[nodiscard]] bool has(Address address) const {
      return std::find(addresses.begin(), addresses.end(), address) != addresses.end();
    }
  };
  using Peers = std::map<Prefix, Peer>;

  [[nodiscard]] static Beginning beginning_of(const Prefix& prefix) {
    Beginning beginning{};
    std::copy_n(prefix.begin(), beginning.size(), beginning.begin());
    return beginning;
  }
  /// The peer is there, and none of its endpoints has been found in time.
  [[nodiscard]] bool is_mute(const Prefix& prefix, const Peer& peer, Clock::time_point now,
                             Clock::time_point since) const {
    constexpr int kMostDoublings = 6;
    const auto known = mute_.find(prefix);
    const int doublings = known == mute_.end() ? 0 : std::min(known->second, kMostDoublings);
    return !peer.has_endpoints && now - std::max(peer.found, since) > endpoint_limit(lease_) * (1 << doublings);
  }
  void count_mute(const Prefix& prefix) {
    constexpr std::size_t kMostMute = 1024;
    if (mute_.size() < kMostMute || mute_.contains(prefix)) ++mute_[prefix];
  }
  void begin_quarantine(Peer& peer, Clock::time_point now) {
    peer.quarantined = true;
    peer.back = now + quarantine(lease_);
    ++quarantined_;
  }
  Peers::iterator forget(Peers::iterator entry) {
    if (entry->second.quarantined) --quarantined_;
    return peers_.erase(entry);
  }

  Clock::duration lease_;
  mutable std::mutex mutex_;
  Peers peers_;
  std::map<Prefix, int> mute_;  ///< how often peers were quarantined because they had no endpoints
  std::set<Beginning> revoked_;
  std::atomic<bool> any_revoked_ = false;
  std::atomic<int> quarantined_ = 0;
};

}  // namespace hecaton::bus
