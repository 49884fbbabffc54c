#pragma once
/// The processes of the model: the code of the real ones, and of each all that its future depends on as a text.
///
/// Time only has to go on: whatever happens next happens later by more than every limit. So of the times that a
/// Leadership remembers nothing matters later.

#include <cstdint>
#include <string>
#include <vector>

#include "services/arm_driver/command_gate.hpp"
#include "services/planner/failover.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/supervisor/failover/leadership.hpp"
#include "services/supervisor/failover/planner_failover.hpp"
#include "tests/model/terms_letters.hpp"

namespace hecaton::services::model {

/// What a mutant leaves out.
struct Rules {
  bool gate = true;              ///< the driver looks at terms at all
  bool binding = true;           ///< the driver gives each term to one planner
  bool driver_remembers = true;  ///< a driver's process begins with the mandate that the one before it knew
  bool unique_terms = true;      ///< supervisors share the terms out
  bool counts_heard = true;      ///< a supervisor counts above the cell terms that it has heard of, not only its own
  bool driver_proves = true;     ///< supervisors and planners learn from the driver what it goes by
  bool planners_prove = true;    ///< supervisors learn from planners what these were granted
};

class SupervisorProcess {
 public:
  using Time = Leadership::Time;

  SupervisorProcess(const Rules& rules, int index);
  /// In place of one that died: what that one told may still arrive. `remembered`: the term on its disk.
  [[nodiscard]] static SupervisorProcess successor(const Rules& rules, int index, std::uint64_t remembered);

  void hear(const Letter& letter, Time now);
  /// Hears no leader for too long, or that it died: leads, if it did not.
  void lose_patience(Time now);
  /// It was stopped, and finds out.
  void come_back(Time now);
  /// While it leads. `out`: the planner that it takes for dead or hanging, −1: none; the other is ready.
  void grant(int out);

  [[nodiscard]] Leadership::Role role() const { return leadership_.role(); }
  [[nodiscard]] bool leads() const { return role() == Leadership::Role::kLeading; }
  [[nodiscard]] std::uint64_t cell_term() const { return leadership_.term(); }
  [[nodiscard]] std::uint64_t highest() const { return leadership_.highest(); }
  [[nodiscard]] std::uint64_t next_term() const;  ///< that it would take
  [[nodiscard]] ArmLease mandate() const;

  [[nodiscard]] std::vector<Letter> tells() const;
  [[nodiscard]] std::string key() const;

 private:
  [[nodiscard]] std::uint64_t counted(std::uint64_t term) const;
  void hear_mode(const Letter& mode, Time now);

  Rules rules_;
  int index_;
  bool is_successor_ = false;
  Leadership leadership_;
  PlannerFailover failover_;
};

class PlannerProcess {
 public:
  PlannerProcess(const Rules& rules, int index);

  void hear(const Letter& letter);

  [[nodiscard]] std::vector<Letter> tells() const;
  [[nodiscard]] std::string key() const;

 private:
  Rules rules_;
  int index_;
  CellModeView view_;
  Duty duty_;
};

/// Also the model's own account of what the arm did, by which the gate is judged.
class DriverProcess {
 public:
  explicit DriverProcess(const Rules& rules) : rules_(rules) {}

  void hear(const Letter& letter);
  /// Its process dies and another begins, on the same host.
  void restart();

  [[nodiscard]] const ArmLease& mandate() const { return gate_.lease(); }
  /// The last command that moved the arm was of this mandate, and nothing newer was heard of since.
  [[nodiscard]] bool follows(const ArmLease& mandate) const { return mandate.term > 0 && followed_ == mandate; }
  /// The arm did what it must not, a sentence; empty: all is well.
  [[nodiscard]] const std::string& violation() const { return violation_; }

  [[nodiscard]] std::vector<Letter> tells() const;
  [[nodiscard]] std::string key() const;

 private:
  void hear_mode(const Letter& mode);
  void hear_command(const Letter& letter);
  void follow(const Letter& command);
  void prove(std::uint64_t term);

  Rules rules_;
  CellModeView view_;
  CommandGate gate_{1};

  // The account goes on when the process dies.
  ArmLease followed_;         // of the last command that moved the arm, until a newer mandate was proved
  std::uint64_t proved_ = 0;  // the highest term of a mandate that the driver was shown
  std::string violation_;
};

}  // namespace hecaton::services::model
