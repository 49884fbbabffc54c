#pragma once
/// Which planner commands each arm that has a standby, and when the standby takes over. Pure: time is an argument.
/// Model-checked (tests/model, docs/design/0008-terms.md).
///
/// Only a leading supervisor grants leases. Leases that other supervisors granted, and those that drivers obey, are
/// adopted as they are: a change of leader changes no lease, and both sides of a healed partition agree with what the
/// arm really follows.

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
  bool ended = false;               ///< its process has ended, or it never appeared
  std::optional<Time> silence{};    ///< of its loop, in stall-compensated time; empty: not heard yet
  bool stands_by = false;           ///< as it reports itself: with every input that it needs
  std::optional<Time> in_charge{};  ///< for how long; empty: it is not
  /// Since the driver accepted a command, as its newest state says; empty: it never did, or the driver is silent.
  std::optional<Time> uncommanded{};
};

struct PlannerHealthLimits {
  Time silence = std::chrono::milliseconds(20);       ///< of a planner whose loop hangs
  Time uncommanded = std::chrono::milliseconds(100);  ///< of a planner that the driver does not hear
};

struct PlannerHealth {
  bool out = false;    ///< must be replaced
  bool ready = false;  ///< stands by with all that it needs
};

/// Commands that arrive are a sign of life, too: lost heartbeats alone replace no planner.
[[nodiscard]] inline PlannerHealth health_of(const PlannerObservations& seen, const PlannerHealthLimits& limits) {
  const bool commands = seen.in_charge && seen.uncommanded && *seen.uncommanded < limits.silence;
  const bool silent = seen.silence && *seen.silence >= limits.silence && !commands;
  const bool unheard = seen.in_charge && *seen.in_charge >= limits.uncommanded && seen.uncommanded &&
                       *seen.uncommanded >= limits.uncommanded;
  const bool out = seen.ended || silent || unheard;
  return {out, !out && seen.stands_by && seen.silence.has_value()};  // a report of its predecessor does not count
}

/// How long the planner in charge of an arm may hang before its standby takes over.
///
/// Two planners on busy machines could take an arm from each other for ever: each is silent for the takeover lease now
/// and then, and neither has died. So a planner that replaces a living one gets twice the time. The added time is
/// halved after each kCalm without a replacement.
class FailoverBackoff {
 public:
  static constexpr Time kCalm = std::chrono::seconds(10);

  /// `least`: as the cell file says; `most` ≥ least.
  FailoverBackoff(Time least, Time most) : least_(least), most_(std::max(least, most)), limit_(least) {}

  /// A planner whose process has not ended was replaced.
  void replaced(Time now) {
    limit_ = std::min(most_, 2 * at(now));
    since_ = now;
  }
  /// The limit now.
  [[nodiscard]] Time at(Time now) const {
    Time limit = limit_;
    for (Time calm = now - since_; calm >= kCalm && limit > least_; calm -= kCalm) limit /= 2;
    return std::max(least_, limit);
  }

 private:
  Time least_, most_;
  Time limit_;
  Time since_{0};  ///< of the last replacement
};

struct ArmPlanners {
  std::string arm;
  std::vector<std::string> planners;  ///< nodes; the first is to be in charge at the beginning
};

class PlannerFailover {
 public:
  /// `arms`: those with more than one planner. The planner of any other arm needs no lease but the cell's term.
  explicit PlannerFailover(std::vector<ArmPlanners> arms) : arms_(std::move(arms)) {}

  /// A lease in another supervisor's cell mode or a planner's heartbeat. Other arms are ignored, here and below.
  void hear(std::string_view arm, const ArmLease& lease) { change(arm, &NewestArmLease::hear, lease); }
  /// The lease in the state of the arm's driver.
  void hear_driver(std::string_view arm, const ArmLease& lease) { change(arm, &NewestArmLease::hear_driver, lease); }

  using Health = std::function<PlannerHealth(const std::string& arm, const std::string& planner)>;
  /// For a leader: grants a lease for each arm that has none, and replaces a planner that is out by one that is ready.
  /// New leases are of terms that `leadership` takes. True when it granted any.
  bool decide(const Health& health, Leadership& leadership) {
    bool granted = false;
    for (const ArmPlanners& arm : arms_) {
      const std::string* next = next_of(arm, health);
      if (!next) continue;
      leadership.heard_lease(lease(arm.arm).term);
      granted = leases_[arm.arm].hear({*next, leadership.take_term()}) || granted;
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
  /// Of an arm that has a standby; term 0: no planner is in charge yet.
  [[nodiscard]] ArmLease lease(std::string_view arm) const {
    const auto found = leases_.find(arm);
    return found == leases_.end() ? ArmLease{} : found->second.newest();
  }
  [[nodiscard]] const std::vector<ArmPlanners>& arms() const { return arms_; }

 private:
  void change(std::string_view arm, bool (NewestArmLease::*how)(const ArmLease&), const ArmLease& lease) {
    if (planners_of(arm)) (leases_[std::string(arm)].*how)(lease);
  }

  /// The planner to be put in charge now; null: nothing is to change.
  [[nodiscard]] const std::string* next_of(const ArmPlanners& arm, const Health& health) const {
    const std::string incumbent = lease(arm.arm).planner;
    const auto known = std::find(arm.planners.begin(), arm.planners.end(), incumbent);
    if (known == arm.planners.end()) return &arm.planners.front();
    if (!health(arm.arm, incumbent).out) return nullptr;
    for (const std::string& planner : arm.planners) {
      if (planner != incumbent && health(arm.arm, planner).ready) return &planner;
    }
    return nullptr;
  }

  std::vector<ArmPlanners> arms_;
  std::map<std::string, NewestArmLease, std::less<>> leases_;
};

}  // namespace hecaton::services
