#include "services/bus/removal.hpp"

#include <cstdlib>
#include <mutex>

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

using namespace std::chrono_literals;

TEST(Removal, IsWaitedFor) {
  bool removed = false;
  EXPECT_TRUE(done_within(kRemoval, [&] { removed = true; }));
  EXPECT_TRUE(removed);
}

/// As Fast DDS does: whoever is destroyed at the end of the process wants a lock that nobody gives back.
struct Global {
  ~Global() { mutex.lock(); }
  std::mutex mutex;
};

void leave_a_removal_behind_and_return(int exit_code) {
  static Global global;
  global.mutex.lock();
  if (done_within(10ms, [] { global.mutex.lock(); })) std::exit(1);
  std::exit(exit_code);
}

TEST(RemovalDeathTest, ThatIsLeftBehindKeepsNoProcessAndChangesNoExitCode) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(leave_a_removal_behind_and_return(7), testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace hecaton::bus
