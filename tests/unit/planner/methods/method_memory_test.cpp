#include "planner/methods/method_memory.hpp"

#include <memory>

#include <gtest/gtest.h>

namespace hecaton::planner {
namespace {

struct Count {
  int value = 7;
};

TEST(MethodMemory, ReturnsADefaultValueUntilOneIsStored) {
  MethodMemory memory;
  EXPECT_EQ(memory.as<Count>().value, 7);
  memory.as<Count>().value = 9;
  EXPECT_EQ(memory.as<Count>().value, 9);
  memory.clear();
  EXPECT_EQ(memory.as<Count>().value, 7);
}

TEST(MethodMemory, CopiesAreIndependent) {
  MethodMemory memory;
  memory.as<Count>().value = 1;
  MethodMemory copy = memory;
  memory.as<Count>().value = 2;
  EXPECT_EQ(copy.as<Count>().value, 1);
  copy = memory;
  EXPECT_EQ(copy.as<Count>().value, 2);
  copy = MethodMemory();
  EXPECT_EQ(copy.as<Count>().value, 7);
}

TEST(MethodMemory, DestroysTheValueOfAnotherType) {
  const auto counted = std::make_shared<int>(0);
  MethodMemory memory;
  memory.as<std::shared_ptr<int>>() = counted;
  EXPECT_EQ(counted.use_count(), 2);
  EXPECT_EQ(memory.as<Count>().value, 7);
  EXPECT_EQ(counted.use_count(), 1);
}

}  // namespace
}  // namespace hecaton::planner
