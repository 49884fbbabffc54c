#pragma once
/// Counts what a participant refuses, by sender. Standard library only.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/wire_rules.hpp"

namespace hecaton::bus {

enum class RefusalKind : std::uint8_t {
  kMalformed,    ///< a sample or datagram outside its limits
  kSecondWriter  ///< a sample of a stream that another participant writes
};

/// What a participant has refused of one sender on one topic.
struct Refused {
  RefusalKind kind{};
  std::string topic{};  ///< TopicInfo::type; empty: a datagram
  EndpointId sender{};  ///< the writer; of a datagram: the participant, with zeros behind
  std::string key{};    ///< of a stream
  std::string text{};   ///< a sentence about the last refusal
  std::uint64_t count = 0;
  Clock::time_point last{};
  std::string node{};     ///< name of the sender's participant; empty: unknown
  std::string address{};  ///< from which the sender's datagrams come; empty: unknown
};

/// Thread-safe. Its size is bounded: of more senders than kSenders the one that has been quiet for longest is
/// forgotten.
class RefusalLog {
 public:
  static constexpr std::size_t kSenders = 64;
  static constexpr std::size_t kPeers = 1024;
  static constexpr std::size_t kLongestText = 400;  ///< [byte]

  /// `refused.count` and what names the sender are set here. `address` is kept if discovery knows none.
  void note(Refused refused) {
    const std::scoped_lock lock(mutex_);
    auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Refused& one) {
      return one.kind == refused.kind && one.sender == refused.sender && one.topic == refused.topic;
    });
    if (found == entries_.end()) {
      if (entries_.size() == kSenders) {
        entries_.erase(std::min_element(entries_.begin(), entries_.end(),
                                        [](const auto& a, const auto& b) { return a.last < b.last; }));
      }
      found = entries_.insert(entries_.end(), Refused{});
      found->count = 0;
    }
    refused.count = found->count + 1;
    refused.text = printable(refused.text, kLongestText);
    refused.key = printable(refused.key, kLongestName);
    *found = std::move(refused);
  }

  /// Discovery has found the participant of these first twelve bytes.
  void found(const EndpointId& participant, std::string_view node, std::string address) {
    const std::scoped_lock lock(mutex_);
    if (peers_.size() == kPeers) peers_.erase(peers_.begin());
    std::erase_if(peers_, [&](const Peer& peer) { return peer.id.same_participant(participant); });
    peers_.push_back({participant, printable(node, kLongestName), std::move(address)});
  }

  /// Senders of which something was refused after `since`, the most recent first, at most `most`. Names and addresses
  /// are those of discovery.
  [[nodiscard]] std::vector<Refused> recent(Clock::time_point since, std::size_t most) const {
    const std::scoped_lock lock(mutex_);
    std::vector<Refused> recent;
    for (const Refused& entry : entries_) {
      if (entry.last > since) recent.push_back(entry);
    }
    std::sort(recent.begin(), recent.end(), [](const auto& a, const auto& b) { return a.last > b.last; });
    if (recent.size() > most) recent.resize(most);
    for (Refused& entry : recent) {
      for (const Peer& peer : peers_) {
        if (!peer.id.same_participant(entry.sender)) continue;
        entry.node = peer.node;
        if (entry.address.empty()) entry.address = peer.address;
      }
    }
    return recent;
  }

 private:
  struct Peer {
    EndpointId id;
    std::string node;
    std::string address;
  };
  mutable std::mutex mutex_;
  std::vector<Refused> entries_;
  std::vector<Peer> peers_;  ///< the oldest first; also those that have left
};

}  // namespace hecaton::bus
