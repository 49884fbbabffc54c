#pragma once
/// What a driver must not forget when its process ends: where its simulated arm stands, and who may command it.
///
/// An arm does not jump when its driver's process is killed; a simulated one whose pose is in that process alone would.
/// And a driver that forgot its newest mandate would follow a planner that was replaced (docs/design/0008-terms.md).
/// The file is mapped into memory: remembering costs a copy, and is there for a successor however suddenly the process
/// ends. It is not meant to survive the machine.

#include <cstdint>
#include <optional>
#include <string>

#include "planner/model/limits.hpp"
#include "services/runtime/arm_lease.hpp"
#include "services/runtime/mapped_file.hpp"

namespace hecaton::services {

class ArmMemory {
 public:
  struct Remembered {
    planner::JointVector q;  ///< [rad | m]
    ArmLease mandate;        ///< the newest that the driver knew; of a planner whose name is too long the term alone
  };

  /// An empty path: nothing is remembered. Throws std::runtime_error with a sentence when the file cannot be used.
  explicit ArmMemory(const std::string& path, int joints);

  /// What was last remembered, of an arm with so many joints.
  [[nodiscard]] std::optional<Remembered> recall() const;
  void remember(const planner::JointVector& q, const ArmLease& mandate);

 private:
  struct Slot;
  [[nodiscard]] const Slot* newest() const;

  int joints_;
  MappedFile file_;
  Slot* slots_;  ///< two, written in turns: one is whole whenever the process ends
  std::uint64_t number_ = 0;
};

}  // namespace hecaton::services
