#pragma once
/// The newest lease that a driver knew, kept beyond the end of its process: a driver that forgot it would follow a
/// planner that was replaced (docs/design/0008-terms.md). It is not meant to survive the machine.

#include <array>
#include <optional>
#include <string>

#include "services/runtime/arm_lease.hpp"
#include "services/runtime/mapped_file.hpp"

namespace hecaton::services {

class LeaseCheckpoint {
 public:
  /// An empty path: nothing is kept. Throws std::runtime_error with a sentence when the file cannot be used.
  explicit LeaseCheckpoint(const std::string& path);

  /// What was remembered last.
  [[nodiscard]] std::optional<ArmLease> recall() const;
  /// Of a planner whose name is longer than 255 bytes the term alone.
  void remember(const ArmLease& lease);

 private:
  struct Kept {
    std::uint64_t term;
    std::array<char, 256> planner;  ///< ends with 0
  };
  MappedRecord<Kept> record_;
};

}  // namespace hecaton::services
