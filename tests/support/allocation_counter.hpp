#pragma once
/// Counts heap allocations of the calling thread: link allocation_counter.cpp into the test.

namespace hecaton::test {

/// How often this thread has allocated so far, by whatever way (malloc, operator new, aligned variants).
[[nodiscard]] long allocations();

}  // namespace hecaton::test
