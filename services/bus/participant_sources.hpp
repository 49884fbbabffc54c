#pragma once
/// Binds participants to the sockets from which they send. Private to services/bus; standard library only.
///
/// The sender of an RTPS datagram writes any GUID into it. An intruder could end the discovery of another participant,
/// or move the addresses at which it receives. It could count heartbeats up so that the middleware ignores all later
/// ones. A participant opens its sockets when it starts and keeps them. So a datagram counts only if it comes from a
/// socket that its participant has used from the beginning.
///
/// A participant that discovery has not found keeps a place until kUnknown others have been heard. It needs the place
/// for its first announcement only. So participants that an intruder invents leave no other one without a place.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// Thread-safe. Its memory is bounded by kUnknown and by the participants that discovery knows.
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
  /// Participants of one socket that discovery knows. Fast DDS has one, Cyclone DDS all participants of a process.
  static constexpr std::size_t kSpokenFor = 64;
  static constexpr std::size_t kUnknown = 256;  ///< participants that discovery does not know

  /// Why the socket at `source` may not speak for the participant, as a sentence; nothing: it may. `forgotten`: a
  /// participant that has lost its place to this one.
  [[nodiscard]] std::optional<std::string_view> refuse(const Prefix& participant, Address source, Clock::time_point now,
                                                       std::optional<Prefix>* forgotten = nullptr) {
    const std::scoped_lock lock(mutex_);
    const auto known = participants_.find(participant);
    if (known == participants_.end()) {
      if (const auto place = places_.find(source); place != places_.end() && place->second >= kSpokenFor) {
        return kTooMany;
      }
      admit_unknown(participant, forgotten).bind(source, now);
      return std::nullopt;
    }
    Participant& entry = known->second;
    for (Socket& socket : entry.sockets) {
      if (socket.address != source) continue;
      socket.heard = now;
      return std::nullopt;
    }
    const bool silent = entry.is_silent(now);
    if (!silent && (now - entry.since > kSettling || entry.sockets.size() == kSockets)) {
      return "it comes from another socket than its participant";
    }
    if (entry.known && !take_place(source)) return kTooMany;
    if (silent) {
      give_back(entry);
      entry.sockets.clear();
    }
    entry.bind(source, now);
    return std::nullopt;
  }

  /// Discovery has found the participant.
  void found(const Prefix& participant) {
    const std::scoped_lock lock(mutex_);
    Participant& entry = participants_[participant];
    if (std::exchange(entry.known, true)) return;
    for (const Socket& socket : entry.sockets) ++places_[socket.address];
  }

  /// Discovery has lost the participant: it may return with other sockets.
  void forget(const Prefix& participant) {
    const std::scoped_lock lock(mutex_);
    const auto known = participants_.find(participant);
    if (known == participants_.end()) return;
    give_back(known->second);
    participants_.erase(known);
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
    Clock::time_point since{};  ///< when its first socket was heard
    std::vector<Socket> sockets;
    bool known = false;  ///< to discovery

    [[nodiscard]] bool is_silent(Clock::time_point now) const {
      return std::all_of(sockets.begin(), sockets.end(),
                         [&](const Socket& socket) { return now - socket.heard > kSilence; });
    }
    void bind(Address source, Clock::time_point now) {
      if (sockets.empty()) since = now;
      sockets.push_back({source, now});
    }
  };

  /// The place of the unknown participant that came first is the next one's.
  Participant& admit_unknown(const Prefix& participant, std::optional<Prefix>* forgotten) {
    const auto last = participants_.find(unknown_[next_unknown_]);
    if (last != participants_.end() && !last->second.known) {
      if (forgotten != nullptr) *forgotten = last->first;
      participants_.erase(last);
    }
    unknown_[next_unknown_] = participant;
    next_unknown_ = (next_unknown_ + 1) % kUnknown;
    return participants_[participant];
  }
  /// Counts one more participant of the socket; false when it has too many.
  bool take_place(Address source) {
    std::size_t& taken = places_[source];
    if (taken >= kSpokenFor) return false;
    ++taken;
    return true;
  }
  void give_back(const Participant& entry) {
    if (!entry.known) return;
    for (const Socket& socket : entry.sockets) {
      const auto place = places_.find(socket.address);
      if (place != places_.end() && --place->second == 0) places_.erase(place);
    }
  }

  std::mutex mutex_;
  std::unordered_map<Prefix, Participant, Hash> participants_;
  std::array<Prefix, kUnknown> unknown_{};  ///< in the order of their first datagrams; some may be known now
  std::size_t next_unknown_ = 0;
  std::unordered_map<Address, std::size_t> places_;  ///< known participants of each socket
};

}  // namespace hecaton::bus
