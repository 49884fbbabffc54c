#pragma once
/// Binds participants to the sockets from which they send. Private to services/bus; standard library only.
///
/// The sender of an RTPS datagram writes any GUID into it. An intruder could end the discovery of another participant,
/// or move the addresses at which it receives. It could count heartbeats up so that the middleware ignores all later
/// ones. A participant opens its sockets when it starts and keeps them. So a datagram counts only if it comes from a
/// socket that its participant has used from the beginning.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// Thread-safe. Its memory is bounded by kParticipants.
class ParticipantSources {
 public:
  using Prefix = std::array<std::uint8_t, 12>;  ///< of a participant's GUID
  /// IPv4 address and port, see address_of().
  using Address = std::uint64_t;

  /// A participant uses all its sockets within this time, because it announces itself from each of them: every 0.2 s in
  /// a cell, every 3 s with Fast DDS, every 8 s with Cyclone DDS.
  static constexpr std::chrono::seconds kSettling{10};
  /// After this silence of a participant, other sockets may speak for it. Discovery ends the binding earlier
  /// (forget()).
  static constexpr std::chrono::seconds kSilence{30};
  static constexpr std::size_t kSockets = 16;  ///< of a participant: one or two for each network interface
  /// Participants of one socket. Fast DDS has one, Cyclone DDS all participants of a process.
  static constexpr std::size_t kSpokenFor = 64;
  static constexpr std::size_t kParticipants = 1024;

  /// Why the socket at `source` may not speak for the participant, as a sentence; nothing: it may.
  [[nodiscard]] std::optional<std::string_view> refuse(const Prefix& participant, Address source,
                                                       Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    auto known = participants_.find(participant);
    if (known != participants_.end()) {
      Participant& entry = known->second;
      for (Socket& socket : entry.sockets) {
        if (socket.address != source) continue;
        socket.heard = now;
        return std::nullopt;
      }
      if (is_silent(entry, now)) {
        erase(known);
      } else {
        if (now - entry.since > kSettling || entry.sockets.size() == kSockets) {
          return "it comes from another socket than its participant";
        }
        if (!take_place(source, now)) return kTooMany;
        entry.sockets.push_back({source, now});
        return std::nullopt;
      }
    }
    if (participants_.size() >= kParticipants) sweep(now);
    if (participants_.size() >= kParticipants) return "the domain has more than 1024 participants";
    if (!take_place(source, now)) return kTooMany;
    participants_.emplace(participant, Participant{now, {{source, now}}});
    return std::nullopt;
  }

  /// Discovery has lost the participant: it may return with other sockets.
  void forget(const Prefix& participant) {
    const std::scoped_lock lock(mutex_);
    const auto known = participants_.find(participant);
    if (known != participants_.end()) erase(known);
  }

 private:
  static constexpr std::string_view kTooMany = "its socket speaks for more than 64 participants";
  struct Hash {
    std::size_t operator()(const Prefix& prefix) const {
      std::uint64_t one = 0;
      std::uint32_t other = 0;
      std::memcpy(&one, prefix.data(), 8);
      std::memcpy(&other, prefix.data() + 8, 4);
      return static_cast<std::size_t>((one * 0x9E3779B97F4A7C15U) ^ (other * 0xC2B2AE3D27D4EB4FU));
    }
  };
  struct Socket {
    Address address;
    Clock::time_point heard;
  };
  struct Participant {
    Clock::time_point since;
    std::vector<Socket> sockets;
  };
  using Participants = std::unordered_map<Prefix, Participant, Hash>;

  [[nodiscard]] static bool is_silent(const Participant& participant, Clock::time_point now) {
    return std::all_of(participant.sockets.begin(), participant.sockets.end(),
                       [&](const Socket& socket) { return now - socket.heard > kSilence; });
  }
  /// Counts one more participant of the socket; false when it has too many.
  bool take_place(Address source, Clock::time_point now) {
    if (places_[source] >= kSpokenFor) sweep(now);
    std::size_t& taken = places_[source];
    if (taken >= kSpokenFor) return false;
    ++taken;
    return true;
  }
  /// Forgets participants that are silent.
  void sweep(Clock::time_point now) {
    if (now < next_sweep_) return;
    next_sweep_ = now + std::chrono::seconds(1);  // an intruder must not make each datagram this expensive
    for (auto entry = participants_.begin(); entry != participants_.end();) {
      entry = is_silent(entry->second, now) ? erase(entry) : std::next(entry);
    }
  }
  Participants::iterator erase(Participants::iterator entry) {
    for (const Socket& socket : entry->second.sockets) {
      const auto place = places_.find(socket.address);
      if (--place->second == 0) places_.erase(place);
    }
    return participants_.erase(entry);
  }

  std::mutex mutex_;
  Participants participants_;
  std::unordered_map<Address, std::size_t> places_;  ///< participants of each socket
  Clock::time_point next_sweep_{};
};

}  // namespace hecaton::bus
