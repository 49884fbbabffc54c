#pragma once
/// Which planner may command an arm, as one process knows it. Pure; docs/design/0008-terms.md has the proof.

#include <cstdint>
#include <string>

#include <idl/health.h>

namespace hecaton::services {

/// The right of one planner to command an arm. Its term is the fencing token: a driver refuses commands of older terms.
struct ArmLease {
  std::string planner;     ///< its node; empty: the planner that commands first under the term
  std::uint64_t term = 0;  ///< 0: no lease yet
  bool operator==(const ArmLease&) const = default;
};

[[nodiscard]] inline ArmLease lease_of(const msg::ArmLease& message) {
  return {message.planner(), message.term()};
}
[[nodiscard]] inline msg::ArmLease lease_message(const std::string& arm, const ArmLease& lease) {
  msg::ArmLease message;
  message.arm(arm);
  message.planner(lease.planner);
  message.term(lease.term);
  return message;
}

/// The newest lease that anything proved to exist. It never goes back to an older term.
class NewestArmLease {
 public:
  /// The higher term counts, and of one term the planner that was named first. True when it changed.
  bool hear(const ArmLease& other) {
    const bool names_holder = other.term == newest_.term && newest_.planner.empty() && !other.planner.empty();
    if (other.term <= newest_.term && !names_holder) return false;
    newest_ = other;
    return true;
  }

  /// The lease that the arm's driver obeys: of two planners of one term (a supervisor lost its checkpoint) the driver
  /// has chosen.
  bool hear_driver(const ArmLease& driver) {
    if (driver.term != newest_.term || driver.planner.empty() || driver.planner == newest_.planner) return hear(driver);
    newest_ = driver;
    return true;
  }

  [[nodiscard]] const ArmLease& newest() const { return newest_; }
  bool operator==(const NewestArmLease&) const = default;

 private:
  ArmLease newest_;
};

}  // namespace hecaton::services
