#pragma once
/// Which program computed a set-point.

#include <string>

namespace hecaton::services {

/// Layout of the memory that a tick's snapshot has. Raise it with each change of what ArmPlanner::save() or
/// ArmPlannerOptions::describe() writes: a program of another layout cannot continue from the snapshot.
inline constexpr int kPlannerMemory = 3;

/// Version and instructions of the processor on which the results of mathematical functions may depend: "0.9.0 memory
/// 2 avx2 fma". Two programs with one text give the same set-points, bit by bit.
[[nodiscard]] std::string program_text();
/// The layout in the text of another program; 1: of a program before the text had it.
[[nodiscard]] int planner_memory_of(const std::string& program);

}  // namespace hecaton::services
