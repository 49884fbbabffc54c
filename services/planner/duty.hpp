#pragma once
/// Whether a planner commands its arm or stands by for the one that does. Standard library only.

#include <cstdint>
#include <string>
#include <utility>

#include "services/runtime/arm_lease.hpp"

namespace hecaton::services {

class Duty {
 public:
  /// `node`: of this planner. `first`: it is the one for an arm without a standby, whose mandate names nobody.
  Duty(std::string node, bool first) : node_(std::move(node)), first_(first) {}

  /// From a cell mode; term 0: none was heard.
  void hear(const ArmLease& mandate) { mandate_.hear(mandate); }
  /// From the state that the arm's driver tells: who was replaced while it slept may learn it here.
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

}  // namespace hecaton::services
