#pragma once
/// Bounds what a reader keeps of a topic. Private to services/bus; standard library only.

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/mailbox.hpp"

namespace hecaton::bus {

/// The keys of a topic whose samples a reader keeps, by the participant that wrote each last. When the table is full, a
/// new key takes the place of one of a participant that has left, and otherwise of the participant with the most. So a
/// participant that invents keys displaces its own, and a process that restarts finds a place. For one thread.
class KeyTable {
 public:
  struct Limits {
    std::size_t keys = 0;
    std::size_t bytes = 0;  ///< of the newest samples of all keys, as received
  };
  struct Key {
    std::string text;
    EndpointId writer;
  };

  explicit KeyTable(const Limits& limits) : limits_(limits) {}

  /// A sample of this size has arrived. False: there is no place for it. Otherwise `displaced` gets the keys that have
  /// lost theirs.
  [[nodiscard]] bool admit(const std::string& key, const EndpointId& writer, std::size_t bytes,
                           std::vector<Key>& displaced) {
    if (bytes > limits_.bytes) return false;
    const auto known = keys_.find(key);
    const bool is_new = known == keys_.end();
    const Entry before = is_new ? Entry{} : known->second;
    const EndpointId participant = participant_of(writer);
    Share& own = shares_[participant];
    own.left = false;
    const bool is_own = !is_new && before.participant == participant;
    // Most samples: the participant writes its own key again, and all stays within the limits.
    if (is_own && bytes_ - before.bytes + bytes <= limits_.bytes) {
      known->second.bytes = bytes;
      own.bytes += bytes - before.bytes;
      bytes_ += bytes - before.bytes;
      return true;
    }
    const std::size_t keys_after = own.keys.size() + (is_own ? 0 : 1);
    const std::size_t bytes_after = own.bytes + bytes - (is_own ? before.bytes : 0);
    // What all others have stays within the limits when this one is added.
    while (keys_.size() + (is_new ? 1 : 0) > limits_.keys || bytes_ - before.bytes + bytes > limits_.bytes) {
      const bool too_many = keys_.size() + (is_new ? 1 : 0) > limits_.keys;
      const auto most = std::max_element(shares_.begin(), shares_.end(), [&](const auto& a, const auto& b) {
        return weight(a.second, too_many) < weight(b.second, too_many);
      });
      const std::string* victim = victim_of(most->second, key);
      const bool yields =
          most->first != participant &&
          (most->second.left || (too_many ? most->second.keys.size() > keys_after : most->second.bytes > bytes_after));
      if (!yields || victim == nullptr) {
        drop_if_empty(participant);
        return false;
      }
      displaced.push_back({*victim, most->first});
      erase(std::string(*victim));
    }
    erase(key);
    keys_.emplace(key, Entry{participant, bytes});
    Share& share = shares_[participant];
    share.keys.insert(key);
    share.bytes += bytes;
    bytes_ += bytes;
    return true;
  }

  /// The key was withdrawn.
  void erase(const std::string& key) {
    const auto known = keys_.find(key);
    if (known == keys_.end()) return;
    const auto share = shares_.find(known->second.participant);
    share->second.keys.erase(key);
    share->second.bytes -= known->second.bytes;
    bytes_ -= known->second.bytes;
    keys_.erase(known);
    drop_if_empty(share->first);
  }

  /// A writer of this participant has left. Its keys keep their places until others need them.
  void left(const EndpointId& writer) {
    const auto share = shares_.find(participant_of(writer));
    if (share != shares_.end()) share->second.left = true;
  }

  [[nodiscard]] std::size_t keys() const { return keys_.size(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  struct Entry {
    EndpointId participant{};
    std::size_t bytes = 0;
  };
  struct Share {
    std::set<std::string> keys{};
    std::size_t bytes = 0;
    bool left = false;
  };

  static EndpointId participant_of(EndpointId id) {
    constexpr std::size_t kPrefix = 12;
    std::fill(id.bytes.begin() + kPrefix, id.bytes.end(), std::uint8_t{0});
    return id;
  }
  /// Those that have left come first.
  static std::pair<bool, std::size_t> weight(const Share& share, bool by_keys) {
    const std::size_t size = by_keys ? share.keys.size() : share.bytes;
    return {share.left && !share.keys.empty(), size};
  }
  /// A key that may be displaced: not the one that is to be added.
  static const std::string* victim_of(const Share& share, const std::string& added) {
    for (const std::string& key : share.keys) {
      if (key != added) return &key;
    }
    return nullptr;
  }
  void drop_if_empty(const EndpointId& participant) {
    const auto share = shares_.find(participant);
    if (share != shares_.end() && share->second.keys.empty()) shares_.erase(share);
  }

  Limits limits_;
  std::map<std::string, Entry> keys_;
  std::map<EndpointId, Share> shares_;
  std::size_t bytes_ = 0;
};

}  // namespace hecaton::bus
