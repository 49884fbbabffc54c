#pragma once
/// One arm's goals from arrival to their end: what waits, what is active, and every status that its clients are owed.
/// No network, no threads; time comes from outside.

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/goal.h>

#include "services/planner/goal_account.hpp"
#include "services/planner/resolve_goal.hpp"

namespace hecaton::services {

/// What a period has brought the active goal.
struct Progress {
  msg::GoalState state = msg::GoalState::GOAL_ACTIVE;  ///< active, blocked or reached
  std::string reason;                                  ///< a sentence when it does not come nearer
  bool has_binding = false;
  std::string binding_own;
  std::string binding_other;
  double binding_distance = 0.0;  ///< [m]
  std::string trying;
  bool held_back = false;   ///< does not go freely to the goal
  std::uint32_t claim = 0;  ///< to the right of way
  double distance = 0.0;    ///< ‖q_goal − q‖ [rad | m]
};

class GoalDesk {
 public:
  using Clock = std::chrono::steady_clock;

  GoalDesk(std::string arm, std::string node);

  /// A goal or a cancellation for this arm; what was handled before is ignored.
  void receive(const msg::Goal& goal, Clock::time_point now);

  /// The next goal to be resolved; nothing while another one is under way. To be answered.
  [[nodiscard]] std::optional<msg::Goal> next_question();
  /// Who stands by refuses nothing: what waits now has waited since `now`.
  void wait_from(Clock::time_point now);
  /// Rejects what has waited for its turn longer than `limit`.
  void refuse_waiting(Clock::time_point now, Clock::duration limit, const std::string& reason);
  /// Nobody resolves goals now: rejects those that wait, and the one that is under way, whose answer is then for
  /// nobody.
  void refuse_all(const std::string& reason);
  /// Accepted: the goal replaces the active one, which ends as replaced. Rejected: the active one goes on.
  /// True when the goal is now active.
  bool answer(const GoalAnswer& answer, Clock::time_point now);

  /// Another planner of the arm is in charge and told this: its active goal becomes ours where we never heard of it,
  /// and what it says has ended ends here, too, without a word. True when the goal is now active.
  bool follow(const msg::GoalStatus& status, Clock::time_point now);

  /// For a successor. Goals that have not been answered yet are not in it: their clients still wait, and send them to
  /// whoever comes.
  [[nodiscard]] GoalAccount account(Clock::time_point now) const;
  /// Goes on where a predecessor ended, `ago` after its account, before anything else happened here: what it has
  /// answered is not asked again, what was over is told once more, and so is the active goal. True when there is one.
  bool resume(const GoalAccount& account, Clock::duration ago, Clock::time_point now);

  /// Of the ends so far, only these are ours to be told again: another planner has told the rest.
  void owe_ends(const std::vector<GoalAccount::End>& ends);

  [[nodiscard]] bool has_active() const { return active_.has_value(); }
  [[nodiscard]] const planner::JointVector& q_goal() const { return active_->q_goal; }  ///< of the active goal

  /// Tells at once when the state changes, otherwise every 100 ms; ends the goal when it is reached or out of time.
  void progress(const Progress& progress, Clock::time_point now);

  /// True once after the active goal ended unreached: the arm is to brake and stay.
  [[nodiscard]] bool take_forget() { return std::exchange(forget_, false); }
  /// What is to be published, oldest first; term and stamp are left to the caller.
  [[nodiscard]] std::vector<msg::GoalStatus> take_statuses() { return std::exchange(statuses_, {}); }

 private:
  struct Waiting {
    msg::Goal goal;
    Clock::time_point since;
  };
  struct Active {
    msg::Goal goal;
    planner::JointVector q_goal;
    Clock::time_point since;
    Clock::time_point told;
    msg::GoalState state = msg::GoalState::GOAL_ACCEPTED;
    Progress last;
    bool followed = false;  // known from the planner in charge, not from its client
    std::optional<Clock::time_point> held_since = {};
    std::optional<Clock::time_point> free_since = {};
  };

  [[nodiscard]] bool handled_before(const msg::Goal& goal);
  [[nodiscard]] bool knows(const std::string& goal) const;
  void begin(Active active);
  void cancel(const std::string& goal, Clock::time_point now);
  /// Since when the arm is held back; a moment of freedom does not end it.
  void note_hold(bool held_back, Clock::time_point now);
  void tell(const msg::Goal& goal, msg::GoalState state, const std::string& reason);
  void tell_active(msg::GoalState state, const std::string& reason, Clock::time_point now);
  void end_active(msg::GoalState state, const std::string& reason, Clock::time_point now);

  std::string arm_;
  std::string node_;
  std::deque<std::uint64_t> handled_;  ///< digests, the oldest first
  std::deque<std::string> begun_;      ///< goals that were active, the oldest first
  std::deque<GoalAccount::End> ends_;  ///< the last that were told, the oldest first
  std::deque<Waiting> waiting_;
  std::optional<msg::Goal> asked_;
  bool asked_cancelled_ = false;
  bool asked_refused_ = false;
  std::optional<Active> active_;
  bool forget_ = false;
  std::uint64_t sequence_ = 0;
  std::vector<msg::GoalStatus> statuses_;
};

}  // namespace hecaton::services
