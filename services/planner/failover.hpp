#pragma once
/// Failover between the planners of one arm (docs/explanation/0005-process-recovery.md). The planner in charge holds
/// the lease of the arm and commands it; the standby planner follows its goals. The arm keeps its goal when the other
/// planner takes over, and when a planner is restarted.

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
#include "services/planner/goal_manager.hpp"
#include "services/runtime/arm_lease.hpp"
#include "services/runtime/atomic_file.hpp"

namespace hecaton::services {

/// Checkpoint of an arm's goals in a file. A planner saves a change before it publishes it, so that an accepted goal is
/// not lost when the planner's process ends.
class GoalCheckpoint {
 public:
  struct Saved {
    GoalSnapshot snapshot;
    ArmLease lease;             ///< newest known when it was saved
    std::int64_t stamp_ns = 0;  ///< time of the save, on this host's steady clock
    std::int64_t until_ns = 0;  ///< time until which the snapshot was complete, on the same clock
  };

  /// `path` empty: saves nothing. Throws std::runtime_error with a sentence when the file cannot be used, for example
  /// on a full disk. Afterwards saving cannot fail.
  GoalCheckpoint(const std::string& path, int joints);

  /// The last save; empty when there is none, or when it is from an arm with another number of joints.
  [[nodiscard]] std::optional<Saved> load() const;
  /// Names must have at most GoalSnapshot::kLongestName bytes. Saves at most GoalSnapshot::kResults results and
  /// GoalSnapshot::kHandled digests.
  void save(const Saved& what);
  /// The last save is complete until `now_ns`.
  void confirm(std::int64_t now_ns);

 private:
  struct Slot;
  [[nodiscard]] const Slot* newest() const;

  int joints_;
  MappedFile file_;
  Slot* slots_;  ///< two, written in turn, so that one is complete whenever the process ends
  std::uint64_t number_ = 0;
};

/// Whether a planner is in charge of its arm, by the newest lease that it knows.
class FailoverRole {
 public:
  /// `node`: of this planner. `first`: it is the first planner of its arm, which is in charge under a lease without a
  /// planner.
  FailoverRole(std::string node, bool first) : node_(std::move(node)), first_(first) {}

  /// A lease of a cell mode; term 0: none.
  void update(const ArmLease& lease) { lease_.update(lease); }
  /// The lease in force at the arm's driver. It may be newer than the last cell mode of this process.
  void update_from_driver(const ArmLease& lease) { lease_.update_from_driver(lease); }

  [[nodiscard]] bool in_charge() const {
    const ArmLease& newest = lease_.newest();
    if (newest.term == 0) return false;
    return newest.planner.empty() ? first_ : newest.planner == node_;
  }
  /// Term of commands and goal statuses.
  [[nodiscard]] std::uint64_t term() const { return lease_.newest().term; }
  [[nodiscard]] const ArmLease& lease() const { return lease_.newest(); }
  bool operator==(const FailoverRole&) const = default;

 private:
  std::string node_;
  bool first_;
  NewestArmLease lease_;
};

/// Whether the checkpoint of a restarted planner is valid. It is outdated when another planner has been in charge
/// since.
enum class CheckpointValidity : std::uint8_t {
  kUndecided,
  kValid,
  kOutdated,
};

/// The last command that the arm's driver accepted, from its state.
struct LastCommand {
  std::uint64_t term = 0;
  std::chrono::nanoseconds at{0};  ///< on this host's steady clock
};

/// A command up to this much later than the checkpoint does not outdate it: both planners of an arm may die within this
/// time, and the standby then misses the last statuses. Equals the longest stall of a process
/// (services/bus/local_stall_guard.hpp).
constexpr std::chrono::milliseconds kSimultaneousLoss{250};

/// `under`, `until`: lease and until_ns of the checkpoint.
[[nodiscard]] CheckpointValidity judge_checkpoint(const ArmLease& under, std::chrono::nanoseconds until,
                                                  const FailoverRole& role, const std::optional<LastCommand>& last);

/// What a planner does with a goal status of the other planner of its arm.
enum class StatusAction : std::uint8_t {
  kApply,
  kDefer,  ///< until the lease changes
  kIgnore,
};

/// `ready`: the validity of the checkpoint is decided.
[[nodiscard]] StatusAction action_for(const msg::GoalStatus& status, const FailoverRole& role, bool ready);

/// Final statuses of goals that a standby planner has and the planner in charge has not published. The standby
/// publishes them when it takes over.
class UnpublishedResults {
 public:
  static constexpr std::size_t kKept = 8;  ///< as many as the bus keeps for late clients

  /// Keeps the final statuses among `statuses`. Other statuses are published repeatedly and need not be kept.
  void keep(std::vector<msg::GoalStatus> statuses);
  /// The planner in charge has published `status`.
  void on_published(const msg::GoalStatus& status);
  /// Oldest first.
  [[nodiscard]] std::vector<GoalSnapshot::Result> results() const;
  /// Removes and returns all statuses, oldest first.
  [[nodiscard]] std::vector<msg::GoalStatus> take();

 private:
  std::deque<msg::GoalStatus> unpublished_;
  std::deque<std::string> published_;  ///< goals with published results
};

/// Failover in one planner: role, checkpoint, and everything that waits until it is known which planner is in charge.
/// For one thread.
class FailoverParticipant {
 public:
  using Clock = std::chrono::steady_clock;

  struct Identity {
    std::string arm;
    std::string node;   ///< of this planner
    bool first = true;  ///< it is the first planner of its arm
    bool alone = true;  ///< the arm has no other planner
  };
  /// `checkpoint`: path of a file; empty: none. A file that cannot be used is logged and then not used: goals end with
  /// the process, but the arm can be used.
  FailoverParticipant(Identity identity, const std::string& checkpoint, int joints);

  /// Between periods: takes the lease of a cell mode. True when this planner is in charge.
  bool update_lease(const ArmLease& ordered);

  struct Inputs {
    Clock::time_point now;                             ///< beginning of the period
    const ArmLease& ordered;                           ///< of the newest cell mode
    const std::optional<ArmView::ReceivedState>& own;  ///< last state of the arm's driver
    std::span<const msg::GoalStatus> statuses;         ///< received since the last period
  };
  /// Call it once per period, before goals are handled. In this order it handles the statuses by the role of the last
  /// period, updates the role, resumes saved goals if the checkpoint is valid, and handles deferred statuses again. So
  /// no result is lost that the other planner publishes just before this planner is put in charge.
  void update(const Inputs& inputs, GoalManager& goals);

  /// Call it last in a period. Saves changes, then returns the statuses to publish: none for a standby planner.
  [[nodiscard]] std::vector<msg::GoalStatus> release(std::vector<msg::GoalStatus> statuses, GoalManager& goals,
                                                     Clock::time_point now);

  [[nodiscard]] bool in_charge() const { return in_charge_; }
  /// In charge now and in the last period: the drive follows set-points of this planner.
  [[nodiscard]] bool continues() const { return in_charge_ && was_in_charge_; }
  /// The validity of the checkpoint is decided: goals of clients may be handled.
  [[nodiscard]] bool ready() const { return !saved_; }
  /// The term of the checkpoint, until its validity is decided; 0: there is none.
  [[nodiscard]] std::uint64_t saved_term() const { return saved_ ? saved_->lease.term : 0; }
  [[nodiscard]] const FailoverRole& role() const { return role_; }
  [[nodiscard]] const std::string& node() const { return identity_.node; }

 private:
  void handle(const msg::GoalStatus& status, GoalManager& goals, Clock::time_point now);
  void update_role(const Inputs& inputs);
  void resume(const Inputs& inputs, GoalManager& goals);
  [[nodiscard]] CheckpointValidity validity_of_saved(const Inputs& inputs);
  void save(const GoalManager& goals, Clock::time_point now);

  Identity identity_;
  FailoverRole role_;
  bool in_charge_;
  bool was_in_charge_;
  UnpublishedResults unpublished_;
  std::unique_ptr<GoalCheckpoint> checkpoint_;        ///< null: the file cannot be used
  std::optional<GoalCheckpoint::Saved> saved_;        ///< until its validity is decided
  std::optional<Clock::time_point> undecided_since_;  ///< while this planner is in charge
  std::deque<msg::GoalStatus> deferred_;              ///< statuses to handle again
  ArmLease handled_under_;                            ///< lease under which deferred statuses were handled last
  bool changed_ = false;                              ///< since the last save
};

}  // namespace hecaton::services
