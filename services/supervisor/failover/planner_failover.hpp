#pragma once
/// Which planner commands each arm that has a standby planner, and when the standby replaces it. Pure: time is an
/// argument. Model-checked (tests/model, docs/explanation/0008-arm-leases.md).
///
/// Only the leading supervisor grants leases. It adopts leases that other supervisors granted and those that drivers
/// obey: a change of leader changes no lease, and after a partition both sides agree with what the arm follows.

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/runtime/arm_lease.hpp"
#include "services/runtime/stall_compensated_clock.hpp"
#include "services/supervisor/failover/leadership.hpp"

namespace hecaton::services {

/// What the supervisor observes of one planner.
struct PlannerObservations {
  bool ended = false;                    ///< its process has ended, or it never appeared
  std::optional<Time> silence{};         ///< of its loop, in stall-compensated time; empty: not heard yet
  bool stands_by = false;                ///< it reports that it is ready, with every input that it needs
  std::optional<Time> time_in_charge{};  ///< empty: it is not in charge
  /// Since the driver accepted a command, by its newest state; empty: it never did, or the driver is silent.
  std::optional<Time> command_silence{};
};

struct PlannerHealthLimits {
  Time silence = std::chrono::milliseconds(20);           ///< of a planner whose loop hangs
  Time command_silence = std::chrono::milliseconds(100);  ///< of a planner that the driver does not hear
};

struct PlannerHealth {
  bool failed = false;  ///< must be replaced
  bool ready = false;   ///< can replace the planner in charge
};

/// Commands count like heartbeats: lost heartbeats alone replace no planner.
[[nodiscard]] inline PlannerHealth health_of(const PlannerObservations& observed, const PlannerHealthLimits& limits) {
  const auto& in_charge = observed.time_in_charge;
  const auto& command_silence = observed.command_silence;
  const bool commands = in_charge && command_silence && *command_silence < limits.silence;
  const bool silent = observed.silence && *observed.silence >= limits.silence && !commands;
  const bool unheard = in_charge && *in_charge >= limits.command_silence && command_silence &&
                       *command_silence >= limits.command_silence;
  const bool failed = observed.ended || silent || unheard;
  return {failed, !failed && observed.stands_by && observed.silence.has_value()};  // not a report of its predecessor
}

/// For how long the planner in charge of an arm may be silent before its standby replaces it.
///
/// On busy machines two planners could replace each other for ever: each is silent for the failover timeout now and
/// then, and neither has died. So a planner that replaces a living one gets twice the time. The added time is halved
/// after each kQuietPeriod without a replacement.
class FailoverBackoff {
 public:
  static constexpr Time kQuietPeriod = std::chrono::seconds(10);

  /// `least`: the failover timeout of the cell file; `most` ≥ least.
  FailoverBackoff(Time least, Time most) : least_(least), most_(std::max(least, most)), limit_(least) {}

  /// A planner whose process has not ended was replaced.
  void replaced(Time now) {
    limit_ = std::min(most_, 2 * at(now));
    since_ = now;
  }
  /// The limit at `now`.
  [[nodiscard]] Time at(Time now) const {
    Time limit = limit_;
    for (Time quiet = now - since_; quiet >= kQuietPeriod && limit > least_; quiet -= kQuietPeriod) limit /= 2;
    return std::max(least_, limit);
  }

 private:
  Time least_, most_;
  Time limit_;
  Time since_{0};  ///< of the last replacement
};

struct ArmPlanners {
  std::string arm;
  std::vector<std::string> planners;  ///< nodes; the first gets the first lease
};

class PlannerFailover {
 public:
  /// `arms`: those with more than one planner; all calls ignore other arms. The only planner of another arm commands it
  /// under the term of the cell mode.
  explicit PlannerFailover(std::vector<ArmPlanners> arms) : arms_(std::move(arms)) {}

  /// A lease from another supervisor's cell mode or a planner's heartbeat.
  void update(std::string_view arm, const ArmLease& lease) { change(arm, &NewestArmLease::update, lease); }
  /// The lease from the state of the arm's driver.
  void update_from_driver(std::string_view arm, const ArmLease& lease) {
    change(arm, &NewestArmLease::update_from_driver, lease);
  }

  using Health = std::function<PlannerHealth(const std::string& arm, const std::string& planner)>;
  /// For a leader: grants a lease for each arm that has none, and replaces a failed planner by one that is ready. New
  /// leases have terms that `leadership` takes. Returns true when it granted any.
  bool decide(const Health& health, Leadership& leadership) {
    bool granted = false;
    for (const ArmPlanners& arm : arms_) {
      const std::string* next = next_of(arm, health);
      if (!next) continue;
      leadership.observe_lease(lease(arm.arm).term);
      granted = leases_[arm.arm].update({*next, leadership.take_term()}) || granted;
    }
    return granted;
  }

  /// Null: the arm has no standby.
  [[nodiscard]] const ArmPlanners* planners_of(std::string_view arm) const {
    for (const ArmPlanners& candidate : arms_) {
      if (candidate.arm == arm) return &candidate;
    }
    return nullptr;
  }
  /// The lease in force; term 0: no planner is in charge yet.
  [[nodiscard]] ArmLease lease(std::string_view arm) const {
    const auto found = leases_.find(arm);
    return found == leases_.end() ? ArmLease{} : found->second.newest();
  }
  [[nodiscard]] const std::vector<ArmPlanners>& arms() const { return arms_; }

 private:
  void change(std::string_view arm, bool (NewestArmLease::*how)(const ArmLease&), const ArmLease& lease) {
    if (planners_of(arm)) (leases_[std::string(arm)].*how)(lease);
  }

  /// The planner to be put in charge now; null: no change.
  [[nodiscard]] const std::string* next_of(const ArmPlanners& arm, const Health& health) const {
    const std::string incumbent = lease(arm.arm).planner;
    const auto known = std::find(arm.planners.begin(), arm.planners.end(), incumbent);
    if (known == arm.planners.end()) return &arm.planners.front();
    if (!health(arm.arm, incumbent).failed) return nullptr;
    for (const std::string& planner : arm.planners) {
      if (planner != incumbent && health(arm.arm, planner).ready) return &planner;
    }
    return nullptr;
  }

  std::vector<ArmPlanners> arms_;
  std::map<std::string, NewestArmLease, std::less<>> leases_;
};

}  // namespace hecaton::services
