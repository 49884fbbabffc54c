#pragma once
/// Where a planner keeps the account of its arm's goals for its successor, before anybody is told of it: who was told
/// that a goal is accepted will not find it gone with the planner's process.

#include <cstdint>
#include <optional>
#include <string>

#include "services/planner/goal_account.hpp"
#include "services/runtime/arm_lease.hpp"
#include "services/runtime/mapped_file.hpp"

namespace hecaton::services {

class GoalMemory {
 public:
  struct Remembered {
    GoalAccount account;
    ArmLease mandate;           ///< under which it was
    std::int64_t stamp_ns = 0;  ///< when, on this host's steady clock
    std::int64_t until_ns = 0;  ///< when that was last all that there was to know
  };

  /// An empty path: nothing is remembered. Throws std::runtime_error with a sentence when the file cannot be used, a
  /// full disk among other reasons; afterwards remembering cannot fail.
  GoalMemory(const std::string& path, int joints);

  /// What was last remembered, of an arm with so many joints.
  [[nodiscard]] std::optional<Remembered> recall() const;
  /// Names of up to GoalAccount::kLongestName, no more of the lists than their limits.
  void remember(const Remembered& what);
  /// What was remembered last is still all that there is to know.
  void confirm(std::int64_t now_ns);

 private:
  struct Slot;
  [[nodiscard]] const Slot* newest() const;

  int joints_;
  MappedFile file_;
  Slot* slots_;  ///< two, written in turns: one is whole whenever the process ends
  std::uint64_t number_ = 0;
};

}  // namespace hecaton::services
