#pragma once
/// The processes of the model: the real code, and for each process a key with all that its future depends on.
///
/// Every step happens later than the one before by more than all time limits. So the times that a Leadership stores do
/// not matter afterwards.

#include <cstdint>
#include <string>
#include <vector>

#include "services/arm_driver/command_gate.hpp"
#include "services/planner/failover.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/supervisor/failover/leadership.hpp"
#include "services/supervisor/failover/planner_failover.hpp"
#include "tests/model/terms_messages.hpp"

namespace hecaton::services::model {

/// Rules that a mutant leaves out.
struct Rules {
  bool gate = true;                   ///< the driver refuses commands of older terms
  bool binding = true;                ///< the driver binds each term to one planner
  bool driver_has_checkpoint = true;  ///< a restarted driver begins with the lease of its predecessor
  bool unique_terms = true;           ///< two supervisors never take the same term
  bool counts_observed = true;        ///< a supervisor takes terms above those that it has observed, not only its own
  bool driver_proves = true;          ///< supervisors and planners adopt the driver's lease
  bool planners_prove = true;         ///< supervisors adopt leases that planners know
};

class SupervisorProcess {
 public:
  using Time = Leadership::Time;

  SupervisorProcess(const Rules& rules, int index);
  /// Replaces one that died, whose messages may still arrive. `remembered`: the term in its checkpoint.
  [[nodiscard]] static SupervisorProcess successor(const Rules& rules, int index, std::uint64_t remembered);

  void receive(const Message& message, Time now);
  /// The leader is silent or has died: becomes leader, if it does not lead.
  void miss_leader(Time now);
  /// It detects that it was stopped.
  void detect_absence(Time now);
  /// For a leader: grants leases. `failed`: the planner that has failed for it, −1: none; the other one is ready.
  void grant(int failed);

  [[nodiscard]] Leadership::Role role() const { return leadership_.role(); }
  [[nodiscard]] bool leads() const { return role() == Leadership::Role::kLeading; }
  [[nodiscard]] std::uint64_t cell_term() const { return leadership_.term(); }
  [[nodiscard]] std::uint64_t highest() const { return leadership_.highest(); }
  [[nodiscard]] std::uint64_t next_term() const;  ///< that it would take now
  [[nodiscard]] ArmLease lease() const;

  [[nodiscard]] std::vector<Message> sends() const;
  [[nodiscard]] std::string key() const;

 private:
  [[nodiscard]] std::uint64_t counted(std::uint64_t term) const;
  void receive_mode(const Message& mode, Time now);

  Rules rules_;
  int index_;
  bool is_successor_ = false;
  Leadership leadership_;
  PlannerFailover failover_;
};

class PlannerProcess {
 public:
  PlannerProcess(const Rules& rules, int index);

  void receive(const Message& message);

  [[nodiscard]] std::vector<Message> sends() const;
  [[nodiscard]] std::string key() const;

 private:
  Rules rules_;
  int index_;
  CellModeView view_;
  FailoverRole role_;
};

/// The driver, and an independent record of what the arm followed, against which the gate is checked.
class DriverProcess {
 public:
  explicit DriverProcess(const Rules& rules) : rules_(rules) {}

  void receive(const Message& message);
  /// The process dies, and a successor starts on the same host.
  void restart();

  [[nodiscard]] const ArmLease& lease() const { return gate_.lease(); }
  /// The last command that moved the arm was under this lease, and no newer lease was received since.
  [[nodiscard]] bool follows(const ArmLease& lease) const { return lease.term > 0 && followed_ == lease; }
  /// A sentence about a forbidden motion of the arm; empty: there was none.
  [[nodiscard]] const std::string& violation() const { return violation_; }

  [[nodiscard]] std::vector<Message> sends() const;
  [[nodiscard]] std::string key() const;

 private:
  void receive_mode(const Message& mode);
  void receive_command(const Message& message);
  void follow(const Message& command);
  void prove(std::uint64_t term);

  Rules rules_;
  CellModeView view_;
  CommandGate gate_{1};

  // The record survives the death of the process.
  ArmLease followed_;         // of the last command that moved the arm, until a newer lease is proved
  std::uint64_t proved_ = 0;  // highest term of a lease that the driver has received
  std::string violation_;
};

}  // namespace hecaton::services::model
