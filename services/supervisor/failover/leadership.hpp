#pragma once
/// Which supervisor leads, and under which term. Pure: time is an argument. Model-checked (tests/model,
/// docs/explanation/0008-arm-leases.md).
///
///                       no leader for `listen` (`search`): takes a term
///                ┌───────────────────────────────────────────────────────┐
///   restart      │                                                       ▼
///   ───────▶ listening ──▶ standing by ───────────────────────────▶ leading
///                ▲   hears   │         leader died or silent            │
///                │  a leader │  restart_listening()                     │ hears a higher term in force
///                └───────────┴──────────────────────────────────────────┘
///
/// A leader that hears a leader of a higher term stands by at once.

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
    Time search{std::chrono::milliseconds(200)};  ///< for a leader, if there may be one that is not heard yet
    Time join{std::chrono::seconds(5)};  ///< most that `listen` waits for the handshake with another supervisor
    Time silence{std::chrono::milliseconds(300)};  ///< of the leader while others are heard, until failover
    /// Upper bound of what one gap between packets of others adds to the leader's silence: in a longer gap this
    /// supervisor was cut off.
    Time pause{std::chrono::milliseconds(100)};
  };

  /// Supervisors of a cell never take the same term: each takes terms t with t mod `count` = `index`.
  struct TermShare {
    std::uint64_t index = 0;
    std::uint64_t count = 1;
  };

  /// `remembered`: highest term in the checkpoint; 0: there is no checkpoint.
  Leadership(const Limits& limits, std::uint64_t remembered, Time now, TermShare share = {0, 1})
      : limits_(limits), share_(share), highest_(remembered), began_(now), searches_(remembered > 0) {}

  /// A node follows cell modes of this term. A higher term than the own one: another supervisor led unheard. A cell
  /// with one supervisor has no other: the next decide() leads on under a higher term. So an intruder that claims terms
  /// in the name of an absent node cannot end the supervision.
  void observe_term(std::uint64_t term, Time at) {
    highest_ = std::max(highest_, term);
    if (role_ != Role::kLeading || term <= term_) return;
    if (share_.count == 1) return lead_on(at);
    restart_listening(at);
  }
  /// An arm lease of this term exists.
  void observe_lease(std::uint64_t term) { highest_ = std::max(highest_, term); }
  /// A cell mode of another participant arrived at `at`. A term of the own share is of an earlier process of this
  /// supervisor, or forged. No other supervisor leads then: this one leads on above the term.
  void observe_leader(std::uint64_t term, Time at) {
    if (role_ == Role::kLeading && term < term_) return;  // the other will stand by
    highest_ = std::max(highest_, term);
    if (owns(term)) {
      if (role_ == Role::kLeading) lead_on(at);
      return;
    }
    heard_at_ = at;
    leader_silence_ = Time(0);
    leader_heard_ = true;
    role_ = role_ == Role::kListening ? role_ : Role::kStandingBy;
  }
  /// Another supervisor is known and cannot be heard yet: `listen` begins when it can.
  void observe_joining(Time now) { joining_ = now; }
  /// The process of the leader has ended.
  void leader_died() { leader_heard_ = false; }
  /// This supervisor was stopped or cut off until now: another one may lead.
  void restart_listening(Time now) {
    role_ = Role::kListening;
    began_ = now;
    leader_heard_ = false;
    searches_ = true;
  }
  /// Call it once in each turn, after the observations. `heard`: arrival of the newest packet of others. The leader
  /// counts as silent only while others are heard without long gaps: its packets may still wait in the socket, and
  /// after a partition hosts are not heard again all at once. Returns true when this supervisor has just become leader.
  bool decide(Time now, Time heard) {
    if (role_ == Role::kLeading) return false;
    if (heard > heard_at_) {
      leader_silence_ += std::min(heard - heard_at_, limits_.pause);
      heard_at_ = heard;
    }
    const bool leader = leader_heard_ && leader_silence_ <= limits_.silence;
    if (now - std::max(began_, std::min(joining_, began_ + limits_.join)) < limits_.listen) return false;
    const bool searches = role_ == Role::kListening && searches_ && now - began_ < limits_.search;
    if (searches && !leader) return false;
    role_ = leader ? Role::kStandingBy : Role::kLeading;
    if (leader) return false;
    term_ = take_term();
    leader_heard_ = false;
    return true;
  }
  /// Takes a term of this supervisor's share above every observed one, for its leadership or an arm lease.
  [[nodiscard]] std::uint64_t take_term() {
    do {
      ++highest_;
    } while (highest_ % share_.count != share_.index);
    return highest_;
  }

  /// A term of the own share, which no other supervisor takes.
  [[nodiscard]] bool owns(std::uint64_t term) const { return term % share_.count == share_.index; }
  [[nodiscard]] Role role() const { return role_; }
  [[nodiscard]] std::uint64_t term() const { return term_; }         ///< of its last leadership; 0: none yet
  [[nodiscard]] std::uint64_t highest() const { return highest_; }   ///< observed or taken
  [[nodiscard]] bool hears_leader() const { return leader_heard_; }  ///< since it last began to listen

 private:
  /// The next decide() takes a higher term at once.
  void lead_on(Time at) {
    restart_listening(at);
    began_ = at - 2 * std::max(limits_.listen, limits_.search);  // a turn begins before `at`
  }

  Limits limits_;
  TermShare share_;
  std::uint64_t highest_;
  Time began_;              // to listen
  Time joining_{0};         // when another supervisor was last known and not heard
  Time heard_at_{0};        // newest packet of others that leader_silence_ counts
  Time leader_silence_{0};  // while others were heard
  bool leader_heard_ = false;
  bool searches_;
  Role role_ = Role::kListening;
  std::uint64_t term_ = 0;
};

}  // namespace hecaton::services
