#pragma once
/// Failover between the planners of one arm: which of them commands, what the other one does meanwhile, and what a
/// planner that was restarted may still believe. The arm keeps its goal under each of them; docs/design/0005-return.md.

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <idl/goal.h>

#include "services/planner/arm_view.hpp"
#include "services/planner/goal_checkpoint.hpp"
#include "services/planner/goal_manager.hpp"
#include "services/runtime/arm_lease.hpp"

namespace hecaton::services {

/// Whether a planner commands its arm or stands by for the one that does.
class Duty {
 public:
  /// `node`: of this planner. `first`: it is the first planner of its arm, and commands while a mandate names no
  /// planner.
  Duty(std::string node, bool first) : node_(std::move(node)), first_(first) {}

  /// From a cell mode; term 0: none was heard.
  void hear(const ArmLease& mandate) { mandate_.hear(mandate); }
  /// From the state of the arm's driver: a planner that was replaced while its process slept may learn it here.
  void hear_driver(const ArmLease& mandate) { mandate_.hear_driver(mandate); }

  [[nodiscard]] bool in_charge() const {
    const ArmLease& newest = mandate_.newest();
    if (newest.term == 0) return false;
    return newest.planner.empty() ? first_ : newest.planner == node_;
  }
  /// To be carried by commands.
  [[nodiscard]] std::uint64_t term() const { return mandate_.newest().term; }
  [[nodiscard]] const ArmLease& mandate() const { return mandate_.newest(); }
  bool operator==(const Duty&) const = default;

 private:
  std::string node_;
  bool first_;
  NewestArmLease mandate_;
};

/// Whether what a planner that was restarted has saved of its arm's goals still counts, or another planner may have
/// dealt with them since.
enum class Recollection : std::uint8_t {
  kUnknown,  ///< not yet
  kCounts,
  kOutdated,
};

/// The last command that the arm's driver has accepted, as its state tells.
struct LastCommand {
  std::uint64_t term = 0;
  std::chrono::nanoseconds at{0};  ///< on this host's steady clock
};

/// Two planners that die together do not die in the same instant: the standby may miss the last statuses of the planner
/// in charge. As long as a process may stall before it counts as stopped (services/bus/absence.hpp).
constexpr std::chrono::milliseconds kTogether{250};

/// `under`: the mandate under which it was saved; `until`: when it was last complete.
[[nodiscard]] Recollection judge_recollection(const ArmLease& under, std::chrono::nanoseconds until, const Duty& duty,
                                              const std::optional<LastCommand>& last);

/// What a planner does with a status that the other planner of its arm has published.
enum class Heed : std::uint8_t {
  kFollow,
  kLater,  ///< when the mandate has changed
  kIgnore,
};

/// `ready`: whether what was saved counts is decided.
[[nodiscard]] Heed heed(const msg::GoalStatus& status, const Duty& duty, bool ready);

/// Ends of goals that a standby planner knows and the planner in charge has not published. A successor publishes them.
class UnpublishedEnds {
 public:
  static constexpr std::size_t kKept = 8;  ///< of each kind; the bus keeps no more for a planner's clients, either

  /// Statuses that would be published now. One that is no end is not kept: while it lasts it is published repeatedly.
  void keep(std::vector<msg::GoalStatus> statuses);
  /// The planner in charge published this.
  void heard(const msg::GoalStatus& status);
  /// The oldest first.
  [[nodiscard]] std::vector<GoalSnapshot::End> ends() const;
  /// This planner is in charge now: what is left to be published, oldest first.
  [[nodiscard]] std::vector<msg::GoalStatus> take();

 private:
  std::deque<msg::GoalStatus> unpublished_;
  std::deque<std::string> published_;  ///< goals
};

/// One planner's part in failover. It owns the duty, the checkpoint, and everything that waits until it is known which
/// planner is in charge.
class FailoverParticipant {
 public:
  using Clock = std::chrono::steady_clock;

  struct Identity {
    std::string arm;
    std::string node;   ///< of this planner
    bool first = true;  ///< it is the first planner of its arm
    bool alone = true;  ///< the arm has no other planner
  };
  /// `checkpoint`: a file for the goals; empty: none. A file that cannot be used is logged, and goals then end with the
  /// process: an arm that could not be used at all would be worse.
  FailoverParticipant(Identity identity, const std::string& checkpoint, int joints);

  /// Between periods: from a cell mode. True when this planner is in charge.
  bool hear(const ArmLease& ordered);

  struct News {
    Clock::time_point now;                      ///< when the period began
    const ArmLease& ordered;                    ///< by the newest cell mode
    const std::optional<ArmView::Heard>& own;   ///< the last state of the arm's driver
    std::span<const msg::GoalStatus> statuses;  ///< that have arrived since the last period
  };
  /// Once a period, before goals are handled. Statuses are judged by the duty of the last period, then the new duty is
  /// taken, then saved goals are resumed if they count, and statuses that waited are judged again. An end that the
  /// other planner published just before this one was put in charge is so never lost.
  void update(const News& news, GoalManager& goals);

  /// Last in a period: saves what has changed, then returns what this planner is to publish. A standby publishes
  /// nothing.
  [[nodiscard]] std::vector<msg::GoalStatus> release(std::vector<msg::GoalStatus> statuses, GoalManager& goals,
                                                     Clock::time_point now);

  [[nodiscard]] bool in_charge() const { return in_charge_; }
  /// In charge now and in the period before: the drive follows this planner's set-points.
  [[nodiscard]] bool continues() const { return in_charge_ && was_in_charge_; }
  /// Whether saved goals count is decided: goals of clients may be handled.
  [[nodiscard]] bool ready() const { return !saved_; }
  [[nodiscard]] const Duty& duty() const { return duty_; }
  [[nodiscard]] const std::string& node() const { return identity_.node; }

 private:
  void judge(const msg::GoalStatus& status, GoalManager& goals, Clock::time_point now);
  void take_duty(const News& news);
  void resume(const News& news, GoalManager& goals);
  [[nodiscard]] Recollection judge_saved(const News& news);
  void save(const GoalManager& goals, Clock::time_point now);

  Identity identity_;
  Duty duty_;
  bool in_charge_;
  bool was_in_charge_;
  UnpublishedEnds unpublished_;
  std::unique_ptr<GoalCheckpoint> checkpoint_;        ///< null: the file cannot be used
  std::optional<GoalCheckpoint::Saved> saved_;        ///< until it is known whether it still counts
  std::optional<Clock::time_point> undecided_since_;  ///< that, while this planner is in charge
  std::deque<msg::GoalStatus> waiting_;               ///< statuses that are to be judged later
  ArmLease judged_under_;                             ///< all statuses that count under it were followed
  bool changed_ = false;                              ///< since the last save
};

}  // namespace hecaton::services
