#pragma once
/// Where a simulated arm stands, for the process that comes after this one.
///
/// An arm does not jump when its driver's process is killed; a simulated one whose pose is in that process alone would.
/// The file is mapped into memory: remembering costs a copy, and is there for a successor however suddenly the process
/// ends. It is not meant to survive the machine.

#include <cstdint>
#include <string>

#include "planner/model/limits.hpp"

namespace hecaton::services {

class PoseMemory {
 public:
  /// An empty path: nothing is remembered. Throws std::runtime_error with a sentence when the file cannot be used.
  explicit PoseMemory(const std::string& path, int joints);
  ~PoseMemory();
  PoseMemory(const PoseMemory&) = delete;
  PoseMemory& operator=(const PoseMemory&) = delete;

  /// What was last remembered [rad | m]; of size 0 when nothing was.
  [[nodiscard]] planner::JointVector recall() const;
  void remember(const planner::JointVector& q);

 private:
  struct Slot;
  [[nodiscard]] const Slot* newest() const;

  int joints_;
  Slot* slots_ = nullptr;  ///< two, written in turns: one is whole whenever the process ends
  std::uint64_t number_ = 0;
};

}  // namespace hecaton::services
