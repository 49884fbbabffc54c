#pragma once
/// One arm's goals from arrival to their end: those that wait, the active one, and every status that their clients must
/// get. No network, no threads; time comes from outside.

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/goal.h>

#include "planner/arm_planner/arm_planner.hpp"
#include "services/planner/goal_resolver.hpp"

namespace hecaton::services {

/// A goal waits this long for the first obstacle states and the first state of its own arm: as long as the supervisor
/// gives a node to appear.
constexpr std::chrono::seconds kLongestWait{10};

/// What a period has brought the active goal.
struct Progress {
  msg::GoalState state = msg::GoalState::GOAL_ACTIVE;  ///< active, blocked or reached
  msg::Cause cause;                                    ///< why the arm comes no nearer
  bool has_binding = false;
  std::string binding_own;
  std::string binding_other;
  double binding_distance = 0.0;  ///< [m]
  std::string recovery_action;    ///< what the planner does about it
  bool held_back = false;         ///< does not move freely to the goal
  std::uint32_t priority = 0;     ///< in the right of way
  double distance = 0.0;          ///< ‖q_goal − q‖ [rad | m]
};

/// What a planner's successor must know of its arm's goals: a value, without clocks.
struct GoalSnapshot {
  static constexpr std::size_t kLongestName = 255;  ///< of a goal and of its client; longer ones are refused
  static constexpr std::size_t kHandled = 1024;     ///< digests that are kept: more than the bus delivers of any client
  static constexpr std::size_t kEnds = 4;           ///< are told again

  struct Active {
    std::string goal;
    std::string client;
    std::uint64_t sequence_number = 0;  ///< the client's
    double time_limit = 0.0;            ///< [s]; 0: none
    double elapsed = 0.0;               ///< since it was accepted [s]
    planner::JointVector q_goal;        ///< [rad | m]
    bool operator==(const Active&) const = default;
  };
  struct End {
    std::string goal;
    msg::GoalState state = msg::GoalState::GOAL_REACHED;
    bool operator==(const End&) const = default;
  };

  std::optional<Active> active;
  std::vector<End> ends;               ///< of the last goals that are over, the oldest first
  std::vector<std::uint64_t> handled;  ///< digests of goals and cancellations that were answered, the oldest first
  bool operator==(const GoalSnapshot&) const = default;
};

class GoalManager {
 public:
  using Clock = std::chrono::steady_clock;

  GoalManager(std::string arm, std::string node);

  /// A goal or a cancellation for this arm; what was handled before is ignored.
  void receive(const msg::Goal& goal, Clock::time_point now);

  /// The next goal to be resolved; nothing while another one is under way. To be answered.
  [[nodiscard]] std::optional<msg::Goal> next_question();
  /// A planner that stands by refuses nothing: goals that wait count as waiting since `now`.
  void wait_from(Clock::time_point now);
  /// Rejects what has waited for its turn longer than `limit`.
  void refuse_waiting(Clock::time_point now, Clock::duration limit, const msg::Cause& cause);
  /// Goals cannot be resolved now: rejects those that wait, and the one that is being resolved, whose answer is then
  /// ignored.
  void refuse_all(const msg::Cause& cause);
  /// Accepted: the goal replaces the active one, which ends as replaced. Rejected: the active one goes on.
  /// True when the goal is now active.
  bool answer(const GoalAnswer& answer, Clock::time_point now);

  /// Another planner of the arm is in charge and told this: its active goal becomes ours when it is unknown here, and a
  /// goal that it says has ended ends here, too, without a status. True when the goal is now active.
  bool follow(const msg::GoalStatus& status, Clock::time_point now);

  /// For a successor. Goals that have not been answered yet are not in it: their clients still wait, and send them to
  /// any planner of the arm that appears.
  [[nodiscard]] GoalSnapshot snapshot(Clock::time_point now) const;
  /// Continues where a predecessor ended, `ago` after its snapshot, before anything else happened here: goals that it
  /// has answered are not asked again, ends are told once more, and so is the active goal. True when there is one.
  bool resume(const GoalSnapshot& snapshot, Clock::duration ago, Clock::time_point now);

  /// Of the ends so far, only these are ours to be told again: another planner has told the rest.
  void owe_ends(const std::vector<GoalSnapshot::End>& ends);

  [[nodiscard]] bool has_active() const { return active_.has_value(); }
  [[nodiscard]] const planner::JointVector& q_goal() const { return active_->q_goal; }  ///< of the active goal

  /// Tells at once when the state changes, otherwise every 100 ms; ends the goal when it is reached or out of time.
  void progress(const Progress& progress, Clock::time_point now);

  /// For the arm's planner, once: the goal that has become active, or none after the active goal ended unreached. A
  /// goal that was reached stays: the arm keeps its place.
  [[nodiscard]] std::optional<planner::GoalChange> take_change() { return std::exchange(change_, std::nullopt); }
  /// To be published, oldest first; term and stamp are left to the caller.
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
    bool followed = false;  ///< known from the planner in charge, not from its client
    std::optional<Clock::time_point> held_since = {};
    std::optional<Clock::time_point> free_since = {};
  };

  [[nodiscard]] bool handled_before(const msg::Goal& goal);
  [[nodiscard]] bool knows(const std::string& goal) const;
  void begin(Active active);
  void cancel(const std::string& goal, Clock::time_point now);
  /// Since when the arm is held back; a moment of freedom does not end it.
  void note_hold(bool held_back, Clock::time_point now);
  void tell(const msg::Goal& goal, msg::GoalState state, const msg::Cause& cause);
  void tell_active(msg::GoalState state, const msg::Cause& cause, Clock::time_point now);
  void end_active(msg::GoalState state, const msg::Cause& cause, Clock::time_point now);

  std::string arm_;
  std::string node_;
  std::deque<std::uint64_t> handled_;   ///< digests, the oldest first
  std::deque<std::string> begun_;       ///< goals that were active, the oldest first
  std::deque<GoalSnapshot::End> ends_;  ///< the last that were told, the oldest first
  std::deque<Waiting> waiting_;
  std::optional<msg::Goal> asked_;
  bool asked_cancelled_ = false;
  bool asked_refused_ = false;
  std::optional<Active> active_;
  std::optional<planner::GoalChange> change_;
  std::uint64_t sequence_ = 0;
  std::vector<msg::GoalStatus> statuses_;
};

}  // namespace hecaton::services
