#pragma once
/// Sends fewer announcements of a participant. Private to services/bus; standard library only.
///
/// Fast DDS sends each periodic announcement by multicast, and again by unicast to each peer that it knows. In a cell
/// of 30 arms, with 63 processes, these copies were two in five of all datagrams. The first one to a peer answers its
/// own first announcement and must not be missing. Later ones only repeat what multicast brings ten times in a lease,
/// so two in a lease are enough.

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <span>
#include <unordered_map>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/participant_sources.hpp"
#include "services/bus/rtps_wire.hpp"

namespace hecaton::bus {

/// Thread-safe.
class AnnouncementPacer {
 public:
  using Address = ParticipantSources::Address;
  /// As many bytes of a datagram as is_announcement() needs.
  static constexpr std::size_t kHead = 64;

  /// `lease`: of the participant. `multicast`: it announces itself by multicast; otherwise all announcements are due.
  AnnouncementPacer(Clock::duration lease, bool multicast) : period_(lease / 2), active_(multicast) {}

  [[nodiscard]] bool active() const { return active_; }

  /// A peer that receives at these addresses was found or lost: the next announcement to it is due.
  void restart(const std::vector<Address>& addresses) {
    const std::scoped_lock lock(mutex_);
    for (const Address address : addresses) sent_.erase(address);
  }
  /// True when an announcement is to be sent to this address now; it then counts as sent. It always is to a multicast
  /// group.
  [[nodiscard]] bool is_due(Address to, Clock::time_point now) {
    if (!active_ || is_multicast(to)) return true;
    const std::scoped_lock lock(mutex_);
    if (sent_.size() >= kMostAddresses)
      std::erase_if(sent_, [&](const auto& entry) { return now - entry.second >= period_; });
    if (sent_.size() >= kMostAddresses) return true;
    const auto [entry, is_new] = sent_.try_emplace(to, now);
    if (!is_new && now - entry->second < period_) return false;
    entry->second = now;
    return true;
  }

  /// True for a datagram with these first bytes whose first sample announces a participant (RTPS 2.2, section 8.5.3).
  [[nodiscard]] static bool is_announcement(std::span<const std::uint8_t> head) {
    constexpr std::size_t kWriterAt = 12;  // in a DATA submessage, with its header
    for (std::size_t at = wire::kHeader; at + kWriterAt + wire::kAnnouncer.size() <= head.size();) {
      if (head[at] == wire::submessage::kData) {
        return std::equal(wire::kAnnouncer.begin(), wire::kAnnouncer.end(), head.begin() + at + kWriterAt);
      }
      const bool little = (head[at + 1] & wire::flag::kLittleEndian) != 0;
      const std::size_t length = little ? head[at + 2] | head[at + 3] << 8U : head[at + 2] << 8U | head[at + 3];
      at += 4 + ((length + 3U) & ~std::size_t{3});
    }
    return false;
  }

 private:
  static constexpr std::size_t kMostAddresses = 4096;
  static bool is_multicast(Address address) { return (address >> 44U & 0xFU) == 0xEU; }

  const Clock::duration period_;
  const bool active_;
  std::mutex mutex_;
  std::unordered_map<Address, Clock::time_point> sent_;
};

}  // namespace hecaton::bus
