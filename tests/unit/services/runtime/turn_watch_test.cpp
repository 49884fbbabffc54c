// Whether a thread that others wait for still works.
#include "services/runtime/turn_watch.hpp"

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

class Watched : public ::testing::Test {
 protected:
  /// Looks every 10 ms for so long.
  TurnWatch::Clock::duration look_for(TurnWatch::Clock::duration time, bool busy, std::uint64_t finished) {
    for (const auto until = now_ + time; now_ < until;) watch_.look(now_ += 10ms, busy, finished);
    return watch_.silence();
  }
  TurnWatch watch_;
  TurnWatch::Clock::time_point now_{1h};
};

TEST_F(Watched, CountsWhileItHasSomethingToDoAndFinishesNothing) {
  EXPECT_EQ(look_for(5s, false, 0), 0s);
  EXPECT_EQ(look_for(10ms, true, 0), 0s) << "it has just begun";
  EXPECT_EQ(look_for(3s, true, 0), 3s);
  EXPECT_EQ(look_for(10ms, true, 1), 0s) << "it has finished something";
  EXPECT_EQ(look_for(2s, true, 1), 2s);
  EXPECT_EQ(look_for(10ms, false, 1), 0s);
}

TEST_F(Watched, TheTimeInWhichNobodyLookedIsNotItsSilence) {
  look_for(10ms, true, 0);
  now_ += 1h;  // the whole process was stopped
  EXPECT_EQ(look_for(10ms, true, 0), TurnWatch::kLongestLook);
}

TEST_F(Watched, ComplaintSaysHowLong) {
  EXPECT_EQ(complaint_about("the thread that resolves goals", 5s, 5s), "");
  EXPECT_EQ(complaint_about("the thread that resolves goals", 7900ms, 5s),
            "the thread that resolves goals has not answered for 7 s");
}

}  // namespace
}  // namespace hecaton::services
