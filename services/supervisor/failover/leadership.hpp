#pragma once
/// Which supervisor leads, and under which term. Pure: time is an argument. Model-checked (tests/model,
/// docs/design/0008-terms.md).
///
/// A supervisor begins by listening. When it hears no leader it takes a term above every term that it has heard or
/// remembers. When it hears one it stands by, and takes over when the leader has died or been silent for `silence`. A
/// leader that hears a leader of a higher term stands back at once. A supervisor that was absent, or hears that the
/// cell has followed a higher term, begins anew, with a new term of its own.

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace hecaton::services {

class Leadership {
 public:
  using Time = std::chrono::nanoseconds;
  enum class Role : std::uint8_t { kListening, kLeading, kStandingBy };

  struct Limits {
    Time listen{std::chrono::milliseconds(200)};  ///< before the first decision
    Time search{
        std::chrono::milliseconds(200)};  ///< for a leader, by who led or stood by before: somebody else may lead
    Time silence{std::chrono::milliseconds(300)};  ///< of a leader while others are heard, before another takes over
    Time pause{std::chrono::milliseconds(100)};    ///< between two signs of others: whoever hears less was cut off
  };

  /// The supervisors of a cell share the terms out: each takes only those that leave `index` when divided by `of`, so
  /// that two never take the same one.
  struct Seat {
    std::uint64_t index = 0;
    std::uint64_t of = 1;
  };

  Leadership(const Limits& limits, std::uint64_t remembered, Time now, Seat seat = {0, 1})
      : limits_(limits), seat_(seat), highest_(remembered), began_(now), searches_(remembered > 0) {}

  /// A cell mode of this term was heard by somebody. Above ours: another supervisor led without our hearing it.
  void heard_term(std::uint64_t term, Time at) {
    highest_ = std::max(highest_, term);
    if (role_ == Role::kLeading && term > term_) absent(at);
  }
  /// A planner's lease of this term exists.
  void heard_lease(std::uint64_t term) { highest_ = std::max(highest_, term); }
  /// A cell mode of another supervisor.
  void heard_leader(std::uint64_t term, Time at) {
    if (role_ == Role::kLeading && term < term_) return;  // it will hear of us
    highest_ = std::max(highest_, term);
    heard_at_ = at;
    leader_silence_ = Time(0);
    leader_heard_ = true;
    role_ = role_ == Role::kListening ? role_ : Role::kStandingBy;
  }
  /// The process of the supervisor that we hear has ended.
  void leader_died() { leader_heard_ = false; }
  /// We were asleep or cut off until now: somebody else may lead.
  void absent(Time now) {
    role_ = Role::kListening;
    began_ = now;
    leader_heard_ = false;
    searches_ = true;
  }
  /// Once in each turn, after what was heard. `heard`: when the newest sign of others arrived. The leader is silent
  /// only while others are heard, without longer pauses: what it said may still lie in our socket, and who was cut off
  /// does not hear everybody again in the same instant. True when we have just begun to lead.
  bool decide(Time now, Time heard) {
    if (role_ == Role::kLeading) return false;
    if (heard > heard_at_) {
      leader_silence_ += std::min(heard - heard_at_, limits_.pause);
      heard_at_ = heard;
    }
    const bool leader = leader_heard_ && leader_silence_ <= limits_.silence;
    if (now - began_ < limits_.listen) return false;
    const bool searches = role_ == Role::kListening && searches_ && now - began_ < limits_.search;
    if (searches && !leader) return false;
    role_ = leader ? Role::kStandingBy : Role::kLeading;
    if (leader) return false;
    term_ = take_term();
    leader_heard_ = false;
    return true;
  }
  /// A term of ours above every one that was ever heard of.
  [[nodiscard]] std::uint64_t take_term() {
    do {
      ++highest_;
    } while (highest_ % seat_.of != seat_.index);
    return highest_;
  }

  [[nodiscard]] Role role() const { return role_; }
  [[nodiscard]] std::uint64_t term() const { return term_; }         ///< 0 before we ever led
  [[nodiscard]] std::uint64_t highest() const { return highest_; }   ///< heard of or taken
  [[nodiscard]] bool hears_leader() const { return leader_heard_; }  ///< has heard one since it last began

 private:
  Limits limits_;
  Seat seat_;
  std::uint64_t highest_;
  Time began_;
  Time heard_at_{0};        // anybody, as far as it counts in the next
  Time leader_silence_{0};  // while others were heard
  bool leader_heard_ = false;
  bool searches_;
  Role role_ = Role::kListening;
  std::uint64_t term_ = 0;
};

}  // namespace hecaton::services
