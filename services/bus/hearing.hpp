#pragma once
/// Whom of the others a participant hears, and whom it has nothing to do with for a while. Private to services/bus;
/// standard library only.
///
/// When a link is down for about as long as the lease, one side may drop the other and not the other way round, or so
/// shortly one after the other that what each sends to meet again reaches a side that has not dropped it yet. Fast DDS
/// 2.9.1 does not heal that: the two never exchange their endpoints again (docs/design/0005-return.md). So who is not
/// heard for most of the lease, or is dropped, is neither heard nor spoken to until the lease is over on both sides;
/// then both meet anew. Absence does the same for a process that was itself stopped.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <iterator>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/reunion.hpp"

namespace hecaton::bus {

class Hearing {
 public:
  using Prefix = std::array<std::uint8_t, 12>;  ///< of a participant's GUID
  /// IPv4 address and port, see address_of().
  using Address = std::uint64_t;
  static Address address_of(std::uint32_t ipv4, std::uint16_t port) { return Address{ipv4} << 16U | port; }

  explicit Hearing(Clock::duration lease) : lease_(lease) {}

  /// A participant was found that listens at these addresses; who had one of them before is dead.
  void found(const Prefix& peer, std::vector<Address> addresses, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    for (auto entry = peers_.begin(); entry != peers_.end();) {
      const bool replaced = entry->first != peer && entry->second.has_any(addresses);
      // Heard again before look() has seen that its quarantine is over: that must not make us forget it later.
      const bool returned = entry->first == peer && entry->second.shunned && now >= entry->second.back;
      entry = replaced || returned ? forget(entry) : std::next(entry);
    }
    Peer& known = peers_[peer];
    known.heard = std::max(known.heard, now);
    known.addresses = std::move(addresses);
  }
  /// It said goodbye. A quarantine goes on to its end.
  void left(const Prefix& peer, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    const auto known = peers_.find(peer);
    if (known != peers_.end() && now >= known->second.back) forget(known);
  }
  /// Fast DDS dropped it when its lease was over. Who was not left alone before (we did not listen all the time) is
  /// left alone from now on: it may have heard us an instant ago and not drop us otherwise.
  void dropped(const Prefix& peer, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    const auto known = peers_.find(peer);
    if (known != peers_.end() && !known->second.shunned) shun(known->second, now);
  }

  /// Asked once for each datagram that has come; false: it is not to be taken.
  [[nodiscard]] bool hears(const Prefix& peer, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    const auto known = peers_.find(peer);
    if (known == peers_.end()) return true;
    if (now < known->second.back) return false;
    known->second.heard = now;
    return true;
  }
  /// False: everybody may be spoken to. Cheap, for every datagram that is sent.
  [[nodiscard]] bool shuns_anybody() const { return shunned_.load() > 0; }
  [[nodiscard]] bool shuns(Address address) const {
    const std::scoped_lock lock(mutex_);
    return std::any_of(peers_.begin(), peers_.end(),
                       [&](const auto& entry) { return entry.second.shunned && entry.second.has_any({address}); });
  }

  /// Begins and ends quarantines. `since`: silence before this is not held against anybody, because this process did
  /// not listen itself. Of one thread.
  void look(Clock::time_point now, Clock::time_point since) {
    const std::scoped_lock lock(mutex_);
    for (auto entry = peers_.begin(); entry != peers_.end();) {
      Peer& peer = entry->second;
      if (peer.shunned && now >= peer.back) {
        entry = forget(entry);  // it is found anew
        continue;
      }
      if (!peer.shunned && now - std::max(peer.heard, since) > patience(lease_)) shun(peer, now);
      ++entry;
    }
  }

 private:
  struct Peer {
    Clock::time_point heard{};
    Clock::time_point back{};  ///< end of its quarantine
    bool shunned = false;
    std::vector<Address> addresses;

    [[nodiscard]] bool has_any(const std::vector<Address>& others) const {
      return std::find_first_of(addresses.begin(), addresses.end(), others.begin(), others.end()) != addresses.end();
    }
  };
  using Peers = std::map<Prefix, Peer>;

  void shun(Peer& peer, Clock::time_point now) {
    peer.shunned = true;
    peer.back = now + quarantine(lease_);
    ++shunned_;
  }
  Peers::iterator forget(Peers::iterator entry) {
    if (entry->second.shunned) --shunned_;
    return peers_.erase(entry);
  }

  Clock::duration lease_;
  mutable std::mutex mutex_;
  Peers peers_;
  std::atomic<int> shunned_ = 0;
};

}  // namespace hecaton::bus
