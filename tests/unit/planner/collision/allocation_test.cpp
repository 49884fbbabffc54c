/// A distance pass does not allocate, neither for separated nor for penetrating pairs.

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "random_cell.hpp"
#include "support/allocation_counter.hpp"

namespace hecaton::planner {
namespace {

TEST(AllocationCounter, CountsEveryKindOfAllocation) {
#ifdef __SANITIZE_THREAD__
  constexpr long kSeen = 2;  // its hook does not see aligned_alloc
#else
  constexpr long kSeen = 3;
#endif
  // Volatile, because the compiler may remove unused allocations.
  const long before = test::allocations();
  void* volatile one = std::malloc(8);
  void* volatile two = std::aligned_alloc(64, 128);
  int* volatile three = new int(1);
  EXPECT_EQ(test::allocations() - before, kSeen);
  std::free(one);
  std::free(two);
  delete three;
}

TEST(Clearances, DoNotAllocate) {
  int penetrating = 0;
  int separated = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    test::RandomCell cell(seed);
    ExactDistance distance(cell.geometry());
    std::vector<Clearance> found(64);
    for (int pose = 0; pose < 20; ++pose) {
      cell.shuffle();
      const CellPoses poses = cell.poses();
      const long before = test::allocations();
      const int count = distance.clearances(poses, {0.2, 0.1, {}}, found);
      ASSERT_EQ(test::allocations(), before) << "seed " << seed << ", pose " << pose;
      for (int i = 0; i < count; ++i) (found[i].distance < 0.0 ? penetrating : separated) += 1;
    }
  }
  // Both kinds of algorithm have run.
  EXPECT_GT(penetrating, 100);
  EXPECT_GT(separated, 100);
}

}  // namespace
}  // namespace hecaton::planner
