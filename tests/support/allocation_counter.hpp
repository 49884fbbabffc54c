#pragma once
/// Counts heap allocations of the calling thread. Link allocation_counter.cpp into the test.

namespace hecaton::test {

/// Allocations of this thread so far, by malloc, operator new and aligned variants.
[[nodiscard]] long allocations();

}  // namespace hecaton::test
