#pragma once
/// The right to command an arm, as one process knows it (docs/explanation/0008-arm-leases.md). Pure.

#include <cstdint>
#include <string>

#include <idl/health.h>

namespace hecaton::services {

/// The right of one planner to command an arm. The term is its fencing token: a driver refuses commands of older terms.
struct ArmLease {
  std::string planner;     ///< node name; empty: the first planner that commands under the term
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

/// The newest lease that a message has proved to exist. Its term never decreases.
class NewestArmLease {
 public:
  /// The higher term counts; of one term, the planner that was named first. True when the newest lease has changed.
  bool update(const ArmLease& other) {
    const bool names_holder = other.term == newest_.term && newest_.planner.empty() && !other.planner.empty();
    if (other.term <= newest_.term && !names_holder) return false;
    newest_ = other;
    return true;
  }

  /// As update(), for the lease in force at the arm's driver. The driver decides between two planners of one term,
  /// which exist after a supervisor has lost its checkpoint.
  bool update_from_driver(const ArmLease& driver) {
    if (driver.term != newest_.term || driver.planner.empty() || driver.planner == newest_.planner)
      return update(driver);
    newest_ = driver;
    return true;
  }

  [[nodiscard]] const ArmLease& newest() const { return newest_; }
  bool operator==(const NewestArmLease&) const = default;

 private:
  ArmLease newest_;
};

}  // namespace hecaton::services
