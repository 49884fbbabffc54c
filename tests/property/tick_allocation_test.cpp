// A tick never allocates: free motion, contact, relaxation, boundary following, new subspaces.
#include <gtest/gtest.h>

#include "planner/methods/registry.hpp"
#include "planner/tick.hpp"
#include "services/config/cell_file.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/random_situation.hpp"

namespace hecaton::planner {
namespace {

TEST(TickAllocation, NeverAllocates) {
  const Cell cell = config::load_cell_file(HECATON_SOURCE_DIR "/deploy/cells/three_puma.yaml").cell;
  const CellGeometry geometry = test::geometry_of(cell, 0);
  TickScratch scratch(geometry);
  Random random(21);
  int following = 0;
  int relaxed = 0;
  for (int trial = 0; trial < 150; ++trial) {
    test::Situation situation(cell, 0, random);
    TickMemory memory{LocalMemory(random.next())};
    for (int step = 0; step < 400; ++step) {
      const long before = test::allocations();
      const TickResult result = tick(geometry, cell.arms[0].parameters, situation.input, memory, scratch);
      ASSERT_EQ(test::allocations(), before) << "trial " << trial << ", step " << step;
      following += memory.local.deviation.active ? 1 : 0;
      relaxed += result.relaxed ? 1 : 0;
      situation.input.q = result.q;
      situation.input.qd = result.qd;
    }
  }
  EXPECT_GT(following, 100);  // the situations were hard enough to reach every branch
  EXPECT_GT(relaxed, 20);
}

class TickAllocationOf : public testing::TestWithParam<std::string_view> {};

TEST_P(TickAllocationOf, MethodNeverAllocates) {
  const Cell cell = config::load_cell_file(HECATON_SOURCE_DIR "/deploy/cells/three_puma.yaml").cell;
  LocalParameters parameters = cell.arms[0].parameters;
  parameters.method = built_in_method(GetParam());
  const CellGeometry geometry = test::geometry_of(cell, 0);
  TickScratch scratch(geometry, parameters);
  Random random(22);
  double moved = 0.0;
  for (int trial = 0; trial < 50; ++trial) {
    test::Situation situation(cell, 0, random);
    TickMemory memory{LocalMemory(random.next())};
    for (int step = 0; step < 100; ++step) {
      const long before = test::allocations();
      const TickResult result = tick(geometry, parameters, situation.input, memory, scratch);
      ASSERT_EQ(test::allocations(), before) << "trial " << trial << ", step " << step;
      moved += (result.q - situation.input.q).norm();
      situation.input.q = result.q;
      situation.input.qd = result.qd;
    }
  }
  EXPECT_GT(moved, 10.0);
}

INSTANTIATE_TEST_SUITE_P(Methods, TickAllocationOf, testing::ValuesIn(built_in_methods().names()),
                         [](const auto& method) { return std::string(method.param); });

}  // namespace
}  // namespace hecaton::planner
