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
  kMalformed,     ///< a sample or datagram outside its limits
  kNotGranted,    ///< a command under a term that was not granted
  kSecondWriter,  ///< a sample of a stream that another participant writes
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

/// Thread-safe. Its size is bounded: of more senders of one kind of refusal than kSenders the one that has been quiet
/// for longest is forgotten. Senders of datagrams that discovery does not know are one for each address, because they
/// write any GUID.
class RefusalLog {
 public:
  static constexpr std::size_t kSenders = 64;
  static constexpr std::size_t kPeers = 1024;
  static constexpr std::size_t kLongestText = 400;  ///< [byte]

  /// `refused.count` and what names the sender are set here. `address` is kept if discovery knows none.
  void note(Refused refused) {
    const std::scoped_lock lock(mutex_);
    const bool unknown = refused.topic.empty() && !refused.address.empty() && peer_of(refused.sender) == nullptr;
    const auto is_it = [&](const Entry& one) {
      if (one.kind != refused.kind || one.topic != refused.topic || one.unknown != unknown) return false;
      return unknown ? one.address == refused.address : one.sender == refused.sender;
    };
    auto found = std::find_if(entries_.begin(), entries_.end(), is_it);
    if (found == entries_.end()) {
      make_room(refused.kind);
      found = entries_.insert(entries_.end(), Entry{});
      found->unknown = unknown;
    }
    refused.count = found->count + 1;
    refused.text = printable(refused.text, kLongestText);
    refused.key = printable(refused.key, kLongestName);
    static_cast<Refused&>(*found) = std::move(refused);
  }

  /// Discovery has found the participant of these first twelve bytes.
  void found(const EndpointId& participant, std::string_view node, std::string address) {
    const std::scoped_lock lock(mutex_);
    if (peers_.size() == kPeers) peers_.erase(peers_.begin());
    std::erase_if(peers_, [&](const Peer& peer) { return peer.id.same_participant(participant); });
    peers_.push_back({participant, printable(node, kLongestName), std::move(address)});
  }

  /// Senders of which something was refused after `since`, at most `most`: first up to two second writers and one
  /// sender under a term that was not granted, which a flood of other refusals cannot hide, then the most recent. Names
  /// and addresses are those of discovery.
  [[nodiscard]] std::vector<Refused> recent(Clock::time_point since, std::size_t most) const {
    const std::scoped_lock lock(mutex_);
    std::vector<Refused> all;
    for (const Entry& entry : entries_) {
      if (entry.last > since) all.push_back(entry);
    }
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.last > b.last; });
    std::vector<Refused> recent;
    move_first(all, recent, std::min<std::size_t>(most, kReservedSecond),
               [](const Refused& one) { return one.kind == RefusalKind::kSecondWriter; });
    move_first(all, recent, std::min<std::size_t>(most - recent.size(), kReservedTerm),
               [](const Refused& one) { return one.kind == RefusalKind::kNotGranted; });
    move_first(all, recent, most - recent.size(), [](const Refused&) { return true; });
    for (Refused& entry : recent) {
      const Peer* peer = peer_of(entry.sender);
      if (peer == nullptr) continue;
      entry.node = peer->node;
      if (entry.address.empty()) entry.address = peer->address;
    }
    return recent;
  }

 private:
  static constexpr std::size_t kReservedSecond = 2;
  static constexpr std::size_t kReservedTerm = 1;
  struct Peer {
    EndpointId id;
    std::string node;
    std::string address;
  };
  struct Entry : Refused {
    bool unknown = false;  ///< its sender is not known to discovery
  };

  [[nodiscard]] const Peer* peer_of(const EndpointId& sender) const {
    const auto found = std::find_if(peers_.rbegin(), peers_.rend(),
                                    [&](const Peer& peer) { return peer.id.same_participant(sender); });
    return found == peers_.rend() ? nullptr : &*found;
  }
  void make_room(RefusalKind kind) {
    const auto of_kind = [&](const Entry& one) { return one.kind == kind; };
    if (static_cast<std::size_t>(std::count_if(entries_.begin(), entries_.end(), of_kind)) < kSenders) return;
    auto quietest = entries_.end();
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
      if (of_kind(*entry) && (quietest == entries_.end() || entry->last < quietest->last)) quietest = entry;
    }
    entries_.erase(quietest);
  }
  /// Moves up to `most` of `from` that `wanted` names behind `to`, in their order.
  template <class Wanted>
  static void move_first(std::vector<Refused>& from, std::vector<Refused>& to, std::size_t most, Wanted wanted) {
    for (auto one = from.begin(); one != from.end() && most > 0;) {
      if (!wanted(*one)) {
        ++one;
        continue;
      }
      to.push_back(std::move(*one));
      one = from.erase(one);
      --most;
    }
  }

  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
  std::vector<Peer> peers_;  ///< the oldest first; also those that have left
};

}  // namespace hecaton::bus
