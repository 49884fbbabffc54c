#pragma once
/// Where a planner keeps the snapshot of its arm's goals for its successor. It saves a change before it publishes it:
/// a goal that a client knows as accepted is never lost with the planner's process.

#include <cstdint>
#include <optional>
#include <string>

#include "services/planner/goal_manager.hpp"
#include "services/runtime/arm_lease.hpp"
#include "services/runtime/mapped_file.hpp"

namespace hecaton::services {

class GoalCheckpoint {
 public:
  struct Saved {
    GoalSnapshot snapshot;
    ArmLease mandate;           ///< under which it was saved
    std::int64_t stamp_ns = 0;  ///< when, on this host's steady clock
    std::int64_t until_ns = 0;  ///< when it was last complete
  };

  /// An empty path: nothing is saved. Throws std::runtime_error with a sentence when the file cannot be used, for
  /// example on a full disk; afterwards saving cannot fail.
  GoalCheckpoint(const std::string& path, int joints);

  /// What was saved last, of an arm with so many joints.
  [[nodiscard]] std::optional<Saved> load() const;
  /// Names of up to GoalSnapshot::kLongestName, and of the lists no more than their limits.
  void save(const Saved& what);
  /// What was saved last is still complete.
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
