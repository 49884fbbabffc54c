#pragma once
/// Binds the messages of planners and supervisors to their participants. Private to services/bus; standard library
/// only.
///
/// Some messages come seldom, so silence on a stream tells nothing about its writer. Discovery knows the names of
/// participants, and each participant announces itself all the time. So such a message counts only from a participant
/// with the name of a node that may write it, while there is one. Of two participants of one name the first counts, as
/// long as it is heard. One that was found out as a second participant never comes before another.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// Thread-safe. Its memory is bounded by kMost and kMostChallengers.
class NodeOwners {
 public:
  /// When a datagram of the participant was received last; nothing: never, or discovery has lost it.
  using Heard = std::function<std::optional<Clock::time_point>(const EndpointId&)>;

  /// A participant announces itself five times a second. After this silence its successor counts.
  static constexpr std::chrono::milliseconds kSilence{500};
  /// A participant that is heard for so long after a message of another one was no predecessor of that.
  static constexpr std::chrono::milliseconds kProof{300};
  static constexpr std::size_t kMost = 64;  ///< participants of one name
  static constexpr std::size_t kMostChallengers = 64;

  /// A participant whose message was refused, while its owner has gone on.
  struct Challenger {
    EndpointId writer;
    std::string topic;  ///< TopicInfo::type
    std::string key;
  };

  /// `nodes`: the names that count; empty: all.
  NodeOwners(std::vector<std::string> nodes, Heard heard) : nodes_(std::move(nodes)), heard_(std::move(heard)) {}

  /// This process. It comes first.
  void own(const EndpointId& participant, std::string_view name) {
    const std::scoped_lock lock(mutex_);
    if (counts(name)) found_.insert(found_.begin(), Found{participant, std::string(name), true, true});
  }
  /// Discovery has found a participant. It counts as soon as one of its endpoints is matched: before, it may be one of
  /// another cell, or without keys.
  void found(const EndpointId& participant, std::string_view name) {
    const std::scoped_lock lock(mutex_);
    if (!counts(name) || find(participant) != found_.end()) return;
    const auto same = [&](const Found& one) { return one.name == name; };
    if (static_cast<std::size_t>(std::count_if(found_.begin(), found_.end(), same)) >= kMost) return;
    found_.push_back({participant, std::string(name)});
  }
  /// An endpoint of this process was matched with that of another one.
  void matched(const EndpointId& endpoint) {
    const std::scoped_lock lock(mutex_);
    if (const auto known = find(endpoint); known != found_.end()) known->matched = true;
  }
  void lost(const EndpointId& participant) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(found_, [&](const Found& one) { return !one.own && one.participant.same_participant(participant); });
  }

  /// The participant that writes for the node, or for its standby ("planner/north@beta"), instead of this writer;
  /// nothing: the writer may.
  [[nodiscard]] std::optional<EndpointId> owner_beside(const EndpointId& writer, std::string_view node,
                                                       Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    const auto own = find(writer);
    if (own != found_.end()) own->matched = true;  // its endpoint is, or nothing would have arrived
    const bool named = own != found_.end() && speaks_for(own->name, node);
    const auto may_own = [&](const Found& one) {
      return one.matched && speaks_for(one.name, node) && !one.participant.same_participant(writer) &&
             (!named || (one.name == own->name && comes_before(one, *own)));
    };
    auto owner = std::find_if(found_.begin(), found_.end(),
                              [&](const Found& one) { return may_own(one) && heard_since(one, now - kSilence); });
    // Until its lease ends, also a silent one comes before a participant of another name.
    if (owner == found_.end() && !named) owner = std::find_if(found_.begin(), found_.end(), may_own);
    return owner == found_.end() ? std::nullopt : std::optional(owner->participant);
  }
  /// A message was refused because of its owner.
  void note_challenge(Challenger challenger, const EndpointId& owner, Clock::time_point now) {
    const std::scoped_lock lock(mutex_);
    const auto same = [&](const Challenge& one) {
      return one.by.writer == challenger.writer && one.by.topic == challenger.topic;
    };
    const auto known = std::find_if(challenges_.begin(), challenges_.end(), same);
    if (known == challenges_.end()) {
      if (challenges_.size() < kMostChallengers) challenges_.push_back({std::move(challenger), owner, now});
    } else if (!known->owner.same_participant(owner)) {
      *known = {std::move(challenger), owner, now};  // the former owner may have died since
    }
  }
  /// Those whose owner was heard afterwards. Each is returned once.
  [[nodiscard]] std::vector<Challenger> take_challengers() {
    const std::scoped_lock lock(mutex_);
    std::vector<Challenger> proved;
    std::erase_if(challenges_, [&](Challenge& challenge) {
      const auto owner = find(challenge.owner);
      if (owner == found_.end()) return true;  // its lease has ended: the writer was a successor
      if (!heard_since(*owner, challenge.at + kProof)) return false;
      if (const auto writer = find(challenge.by.writer); writer != found_.end()) writer->second = true;
      proved.push_back(std::move(challenge.by));
      return true;
    });
    return proved;
  }

 private:
  struct Found {
    EndpointId participant;
    std::string name;
    bool matched = false;
    bool own = false;
    bool second = false;  ///< it wrote while the owner went on
  };
  struct Challenge {
    Challenger by;
    EndpointId owner;
    Clock::time_point at;
  };

  [[nodiscard]] bool counts(std::string_view name) const {
    return nodes_.empty() || std::find(nodes_.begin(), nodes_.end(), name) != nodes_.end();
  }
  [[nodiscard]] std::vector<Found>::iterator find(const EndpointId& endpoint) {
    return std::find_if(found_.begin(), found_.end(),
                        [&](const Found& one) { return one.participant.same_participant(endpoint); });
  }
  static bool speaks_for(std::string_view name, std::string_view node) {
    return name.starts_with(node) && (name.size() == node.size() || name[node.size()] == '@');
  }
  /// Both are elements of found_.
  static bool comes_before(const Found& one, const Found& other) {
    return one.second != other.second ? other.second : &one < &other;
  }
  [[nodiscard]] bool heard_since(const Found& one, Clock::time_point since) const {
    if (one.own) return true;
    const auto heard = heard_(one.participant);
    return heard && *heard >= since;
  }

  const std::vector<std::string> nodes_;
  const Heard heard_;
  std::mutex mutex_;
  std::vector<Found> found_;  ///< in the order of discovery
  std::vector<Challenge> challenges_;
};

}  // namespace hecaton::bus
