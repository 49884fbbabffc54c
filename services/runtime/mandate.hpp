#pragma once
/// Who may command an arm, as one process knows it. Standard library only; docs/design/0008-terms.md has the proof.

#include <cstdint>
#include <string>

namespace hecaton::services {

struct Mandate {
  std::string planner;     ///< its node; empty: whoever commands first under the term
  std::uint64_t term = 0;  ///< 0: nobody yet
  bool operator==(const Mandate&) const = default;
};

/// The newest mandate that anything proved to exist. It never goes back to an older term.
class NewestMandate {
 public:
  /// The higher term counts, and of one term the planner that was heard of first. True when it changed.
  bool hear(const Mandate& other) {
    const bool names_holder = other.term == newest_.term && newest_.planner.empty() && !other.planner.empty();
    if (other.term <= newest_.term && !names_holder) return false;
    newest_ = other;
    return true;
  }

  /// What the arm's driver goes by: of two planners of one term (a supervisor lost its memory) it has chosen.
  bool hear_driver(const Mandate& driver) {
    if (driver.term != newest_.term || driver.planner.empty() || driver.planner == newest_.planner) return hear(driver);
    newest_ = driver;
    return true;
  }

  [[nodiscard]] const Mandate& newest() const { return newest_; }
  bool operator==(const NewestMandate&) const = default;

 private:
  Mandate newest_;
};

}  // namespace hecaton::services
