#pragma once
/// What the processes of the model tell each other, numbered.

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

/// The planners' names; the last is nobody's. Throws std::out_of_range for others.
inline constexpr std::size_t kNobody = 2;
[[nodiscard]] const std::string& planner_name(std::size_t index);
[[nodiscard]] std::uint8_t planner_index(const std::string& name);

/// Something that was told.
struct Letter {
  enum class Kind : std::uint8_t {
    kMode,     ///< a supervisor's: its cell term and the mandate that it tells
    kCommand,  ///< a planner's, under its mandate
    kState,    ///< the driver's: the mandate that it goes by
    kBeat,     ///< heartbeat of a planner or the driver: the cell term that it follows
    kHeld,     ///< heartbeat of a planner: the mandate that it knows
  };
  Kind kind{};
  std::uint8_t sender = 0;   ///< of a mode: the supervisor
  std::uint8_t term = 0;     ///< of a mode or a beat: the cell's
  std::uint8_t granted = 0;  ///< the mandate's
  std::uint8_t planner = 0;  ///< whose mandate it is

  [[nodiscard]] ArmLease mandate() const { return {planner_name(planner), granted}; }
  [[nodiscard]] auto fields() const { return std::make_tuple(kind, sender, term, granted, planner); }
  bool operator<(const Letter& other) const { return fields() < other.fields(); }
};

/// About a mandate; the cell term and the sender are left to the caller.
[[nodiscard]] Letter letter_about(Letter::Kind kind, const ArmLease& mandate);
[[nodiscard]] std::string text(const Letter& letter);

/// A set of letters within the bounds, by their numbers.
class Letters {
 public:
  static constexpr std::size_t kMost = 128;

  void insert(std::size_t number) { words_[number / 64] |= std::uint64_t{1} << number % 64; }
  void insert(const Letters& others) {
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] |= others.words_[i];
  }
  void remove(const Letters& others) {
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] &= ~others.words_[i];
  }
  [[nodiscard]] bool contains(const Letters& others) const {
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
  bool operator==(const Letters&) const = default;

 private:
  std::array<std::uint64_t, kMost / 64> words_{};
};

/// Numbers letters as they come: those of terms within the bounds from 0, others, which are only told once nothing
/// fails any more, from Letters::kMost. Throws std::length_error when there are too many of the first.
class Post {
 public:
  explicit Post(std::uint64_t highest_term) : highest_term_(highest_term) {}

  [[nodiscard]] std::size_t number_of(const Letter& letter);
  [[nodiscard]] const Letter& letter(std::size_t number) const;

 private:
  std::uint64_t highest_term_;
  std::map<Letter, std::size_t> numbers_;
  std::vector<Letter> within_, beyond_;
};

}  // namespace hecaton::services::model
