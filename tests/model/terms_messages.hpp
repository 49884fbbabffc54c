#pragma once
/// The messages that the processes of the model send each other, by number.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "services/runtime/arm_lease.hpp"

namespace hecaton::services::model {

/// The planners' names; that of kNoPlanner is empty. Throws std::out_of_range for others.
inline constexpr std::size_t kNoPlanner = 2;
[[nodiscard]] const std::string& planner_name(std::size_t index);
[[nodiscard]] std::uint8_t planner_index(const std::string& name);

/// A message that was sent.
struct Message {
  enum class Kind : std::uint8_t {
    kMode,       ///< of a supervisor: its cell term, and the lease in it
    kCommand,    ///< of a planner under its lease
    kState,      ///< of the driver: the lease in force
    kHeartbeat,  ///< of a planner or the driver: the cell term in force
    kKnownLease  ///< heartbeat of a planner: the lease that it knows
  };
  Kind kind{};
  std::uint8_t sender = 0;   ///< of a mode: the supervisor
  std::uint8_t term = 0;     ///< of a mode or a heartbeat: cell term
  std::uint8_t granted = 0;  ///< term of the lease
  std::uint8_t planner = 0;  ///< of the lease

  [[nodiscard]] ArmLease lease() const { return {planner_name(planner), granted}; }
  [[nodiscard]] auto fields() const { return std::make_tuple(kind, sender, term, granted, planner); }
  bool operator<(const Message& other) const { return fields() < other.fields(); }
};

/// A message with this lease. The caller sets the cell term and the sender.
[[nodiscard]] Message message_about(Message::Kind kind, const ArmLease& lease);
[[nodiscard]] std::string text(const Message& message);

/// A set of messages within the bounds, by number.
class MessageSet {
 public:
  static constexpr std::size_t kMost = 128;

  void insert(std::size_t number) { words_[number / 64] |= std::uint64_t{1} << number % 64; }
  void insert(const MessageSet& others) {
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] |= others.words_[i];
  }
  void remove(const MessageSet& others) {
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] &= ~others.words_[i];
  }
  [[nodiscard]] bool contains(const MessageSet& others) const {
    for (std::size_t i = 0; i < words_.size(); ++i) {
      if ((others.words_[i] & ~words_[i]) != 0) return false;
    }
    return true;
  }
  [[nodiscard]] int count() const {
    int count = 0;
    for (const std::uint64_t word : words_) count += std::popcount(word);
    return count;
  }
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (std::size_t i = 0; i < words_.size(); ++i) {
      for (std::uint64_t rest = words_[i]; rest != 0; rest &= rest - 1) {
        visit(i * 64 + static_cast<std::size_t>(std::countr_zero(rest)));
      }
    }
  }
  bool operator==(const MessageSet&) const = default;

 private:
  std::array<std::uint64_t, kMost / 64> words_{};
};

/// Numbers messages in the order of their first use: those with terms within the bounds from 0, others from
/// MessageSet::kMost. Only the check of recovery has others. Throws std::length_error when there are too many of the
/// first.
class MessageTable {
 public:
  explicit MessageTable(std::uint64_t highest_term) : highest_term_(highest_term) {}

  [[nodiscard]] std::size_t number_of(const Message& message);
  [[nodiscard]] const Message& message(std::size_t number) const;

 private:
  std::uint64_t highest_term_;
  std::map<Message, std::size_t> numbers_;
  std::vector<Message> within_, beyond_;
};

}  // namespace hecaton::services::model
