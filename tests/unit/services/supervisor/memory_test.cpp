#include "services/supervisor/memory.hpp"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <gtest/gtest.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

Memory some_memory() {
  Memory memory;
  memory.term = 7;
  memory.orders.cell = MoveMode::kHold;
  memory.orders.arms = {{"left", MoveMode::kStop}, {"right", MoveMode::kHold}};
  return memory;
}

class MemoryFile : public ::testing::Test {
 protected:
  ~MemoryFile() override { std::filesystem::remove(path_); }
  std::string path_ = (std::filesystem::temp_directory_path() / ("memory_test-" + std::to_string(getpid()))).string();
};

TEST(MemoryText, SaysWhatIsRemembered) {
  EXPECT_EQ(memory_text(some_memory()), "term 7\ncell hold\narm left stop\narm right hold\n");
  EXPECT_EQ(parse_memory("term 7\ncell hold\narm left stop\narm right hold\n"), some_memory());
}

TEST(MemoryText, RefusesWhatItDidNotWrite) {
  for (const auto* text : {"", "term\n", "term x\n", "cell run\n", "term 1\ncell sleep\n", "term 1\narm left\n",
                           "term 1\nsomething else\n"}) {
    EXPECT_FALSE(parse_memory(text)) << text;
  }
}

TEST_F(MemoryFile, SurvivesAndIsReplaced) {
  EXPECT_FALSE(read_memory(path_));
  ASSERT_TRUE(write_memory(path_, some_memory()));
  EXPECT_EQ(read_memory(path_), some_memory());
  Memory next = some_memory();
  next.term = 8;
  next.orders = {};
  ASSERT_TRUE(write_memory(path_, next));
  EXPECT_EQ(read_memory(path_), next);
}

TEST_F(MemoryFile, DamageIsNotTakenForFreedom) {
  std::ofstream(path_) << "term 7\ncell st";
  EXPECT_THROW(static_cast<void>(read_memory(path_)), std::runtime_error);
}

TEST_F(MemoryFile, UnwritablePlaceIsTold) {
  EXPECT_FALSE(write_memory(path_ + "/no/such/folder", some_memory()));
}

}  // namespace
}  // namespace hecaton::services
