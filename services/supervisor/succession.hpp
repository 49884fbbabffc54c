#pragma once
/// Which planner is in charge of each arm that has a standby. Standard library only.
///
/// Only a leading supervisor grants; what others granted, and what drivers go by, it takes as it is. So a change of the
/// leader changes no mandate, and the two sides of a healed partition agree with what the arm really follows.

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "services/runtime/arm_lease.hpp"
#include "services/supervisor/leadership.hpp"
#include "services/supervisor/planner_fitness.hpp"

namespace hecaton::services {

struct ArmPlanners {
  std::string arm;
  std::vector<std::string> planners;  ///< nodes, of which the first is to be in charge at the beginning
};

class Succession {
 public:
  /// The arms that have more than one planner; the others' need no mandate but the cell's term.
  explicit Succession(std::vector<ArmPlanners> arms) : arms_(std::move(arms)) {}

  /// From another supervisor's cell mode. Other arms are ignored, here and below.
  void hear(std::string_view arm, const ArmLease& mandate) { change(arm, &NewestArmLease::hear, mandate); }
  /// From the state that the arm's driver tells.
  void hear_driver(std::string_view arm, const ArmLease& mandate) {
    change(arm, &NewestArmLease::hear_driver, mandate);
  }

  using Fitness = std::function<PlannerFitness(const std::string& arm, const std::string& planner)>;
  /// While we lead: puts somebody in charge of an arm that has nobody, and replaces who is out by who is ready. New
  /// mandates are of terms that `leadership` takes. True when there are any.
  bool decide(const Fitness& fitness, Leadership& leadership) {
    bool granted = false;
    for (const ArmPlanners& arm : arms_) {
      const std::string* next = next_of(arm, fitness);
      if (!next) continue;
      leadership.heard_mandate(mandate_of(arm.arm).term);
      granted = mandates_[arm.arm].hear({*next, leadership.take_term()}) || granted;
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
  /// Of arms that have a standby; term 0: nobody is in charge yet.
  [[nodiscard]] ArmLease mandate_of(std::string_view arm) const {
    const auto found = mandates_.find(arm);
    return found == mandates_.end() ? ArmLease{} : found->second.newest();
  }
  [[nodiscard]] const std::vector<ArmPlanners>& arms() const { return arms_; }

 private:
  void change(std::string_view arm, bool (NewestArmLease::*how)(const ArmLease&), const ArmLease& mandate) {
    if (planners_of(arm)) (mandates_[std::string(arm)].*how)(mandate);
  }

  /// Who is to be put in charge now; null: nothing is to change.
  [[nodiscard]] const std::string* next_of(const ArmPlanners& arm, const Fitness& fitness) const {
    const std::string incumbent = mandate_of(arm.arm).planner;
    const auto known = std::find(arm.planners.begin(), arm.planners.end(), incumbent);
    if (known == arm.planners.end()) return &arm.planners.front();
    if (!fitness(arm.arm, incumbent).out) return nullptr;
    for (const std::string& planner : arm.planners) {
      if (planner != incumbent && fitness(arm.arm, planner).ready) return &planner;
    }
    return nullptr;
  }

  std::vector<ArmPlanners> arms_;
  std::map<std::string, NewestArmLease, std::less<>> mandates_;
};

}  // namespace hecaton::services
