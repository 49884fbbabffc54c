#include "services/cli/supervisor_news.hpp"

#include <gtest/gtest.h>

namespace hecaton::services::cli {
namespace {

using namespace std::chrono_literals;

constexpr bus::Clock::time_point kBegin{1h};
constexpr int kPid = 123;

msg::ProcessEvent exited(const std::string& node, int pid = kPid, bool wanted = false) {
  msg::ProcessEvent event;
  event.node(node);
  event.pid(pid);
  event.kind(msg::ProcessEventKind::PROCESS_EXITED);
  event.signal_number(9);
  event.wanted(wanted);
  return event;
}

/// `pid`: 0 where it has not heard its own heartbeat yet.
msg::CellStatus up_for(double uptime, int pid = kPid, const std::string& node = "supervisor",
                       const std::string& standby = {}) {
  msg::CellStatus status;
  status.supervisor(node);
  status.standby(standby);
  status.uptime(uptime);
  if (pid == 0) return status;
  msg::NodeStatus own;
  own.heartbeat().node(node);
  own.heartbeat().pid(pid);
  status.nodes().push_back(own);
  return status;
}

class SupervisorStoryTest : public testing::Test {
 protected:
  std::string answer(const msg::CellStatus& status, bus::Clock::duration at) {
    return story_.answer(&status, kBegin + at);
  }
  std::string silence(bus::Clock::duration at) { return story_.answer(nullptr, kBegin + at); }
  std::string event(const msg::ProcessEvent& told, bus::Clock::duration at = 0s) {
    return story_.process(told, kBegin + at);
  }

  SupervisorStory story_;
};

TEST_F(SupervisorStoryTest, DeathAndReturnAreALineEach) {
  EXPECT_EQ(answer(up_for(20.0), 0s), "");
  EXPECT_EQ(event(exited("supervisor")),
            "the supervisor died (process 123, signal 9): arms go on, faults and orders wait for its successor");
  EXPECT_EQ(answer(up_for(20.0), 10ms), "") << "the dead one's last answer";
  EXPECT_EQ(silence(500ms), "") << "known already";
  EXPECT_EQ(answer(up_for(0.2, 124), 600ms), "the supervisor is back: a successor took its place");
  EXPECT_EQ(answer(up_for(0.3, 124), 700ms), "");
  EXPECT_EQ(silence(1200ms), "the supervisor does not answer: arms go on, faults and orders wait for it");
}

TEST_F(SupervisorStoryTest, ASuccessorIsKnownByItsProcessOrItsAge) {
  EXPECT_EQ(answer(up_for(20.0), 0s), "");
  EXPECT_NE(event(exited("supervisor"), 1s), "") << "told late, when the successor is up already";
  EXPECT_EQ(answer(up_for(0.9, 124), 1100ms), "the supervisor is back: a successor took its place");
  EXPECT_NE(event(exited("supervisor", 124), 2s), "");
  EXPECT_EQ(answer(up_for(0.1, 0), 2500ms), "the supervisor is back: a successor took its place");
  EXPECT_EQ(answer(up_for(0.2, 125), 2600ms), "") << "told already";
  EXPECT_NE(event(exited("supervisor", 125), 3s), "");
  EXPECT_EQ(answer(up_for(0.1, 125), 3500ms), "the supervisor is back: a successor took its place")
      << "with the number of the dead one";
}

TEST_F(SupervisorStoryTest, ADeathThatIsToldAfterTheSuccessorsAnswerIsHistory) {
  EXPECT_EQ(answer(up_for(20.0), 0s), "");
  EXPECT_EQ(answer(up_for(0.1, 124), 300ms), "the supervisor is back: a successor took its place");
  EXPECT_EQ(event(exited("supervisor"), 400ms), "");
  EXPECT_EQ(answer(up_for(0.3, 124), 500ms), "");
}

TEST_F(SupervisorStoryTest, TheStandbyTakesOverAndItsOwnSilenceIsTold) {
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor", "supervisor@beta"), 0s), "");
  EXPECT_EQ(event(exited("supervisor")),
            "the supervisor died (process 123, signal 9): arms go on, supervisor@beta takes over");
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor", "supervisor@beta"), 5ms), "") << "the dead one's last answer";
  // As long up as the dead one was.
  EXPECT_EQ(answer(up_for(20.0, 200, "supervisor@beta"), 20ms), "supervisor@beta leads, in place of the supervisor");
  EXPECT_EQ(answer(up_for(21.0, 200, "supervisor@beta", "supervisor"), 1s), "") << "the other one stands by";
  EXPECT_EQ(silence(2s),
            "supervisor@beta does not answer: arms go on, faults and orders wait for it or the supervisor");
  EXPECT_EQ(answer(up_for(23.0, 200, "supervisor@beta", "supervisor"), 3s), "supervisor@beta answers again");
  EXPECT_EQ(event(exited("supervisor@beta", 200), 4s),
            "supervisor@beta died (process 200, signal 9): arms go on, the supervisor takes over");
  EXPECT_EQ(answer(up_for(4.0, 124, "supervisor"), 4100ms), "the supervisor leads, in place of supervisor@beta");
}

TEST_F(SupervisorStoryTest, TheDeathOfWhoStandsByIsTheLeadersToTell) {
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor@beta", "supervisor"), 0s), "");
  EXPECT_EQ(event(exited("supervisor", 200)), "");
  EXPECT_EQ(event(exited("supervisor@beta")),
            "supervisor@beta died (process 123, signal 9): arms go on, faults and orders wait for its successor")
      << "nobody stands by any more";
}

TEST_F(SupervisorStoryTest, WhenBothDieNobodyTakesOver) {
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor", "supervisor@beta"), 0s), "");
  EXPECT_NE(event(exited("supervisor")), "");
  EXPECT_EQ(event(exited("supervisor@beta", 200)),
            "supervisor@beta died (process 200, signal 9): arms go on, faults and orders wait for its successor");
  EXPECT_EQ(silence(500ms), "") << "known already";
  EXPECT_EQ(answer(up_for(0.1, 124), 600ms), "the supervisor is back: a successor took its place");
}

TEST_F(SupervisorStoryTest, WhoIsCutOffIsReplacedToo) {
  EXPECT_EQ(answer(up_for(20.0, kPid, "supervisor", "supervisor@beta"), 0s), "");
  EXPECT_EQ(silence(500ms),
            "the supervisor does not answer: arms go on, faults and orders wait for it or supervisor@beta");
  EXPECT_EQ(answer(up_for(20.4, 200, "supervisor@beta"), 600ms), "supervisor@beta leads, in place of the supervisor");
  EXPECT_EQ(answer(up_for(20.5, 200, "supervisor@beta"), 700ms), "");
}

TEST_F(SupervisorStoryTest, SilenceIsToldOnce) {
  EXPECT_EQ(silence(0s), "the supervisor does not answer: arms go on, faults and orders wait for it");
  EXPECT_EQ(silence(500ms), "");
  EXPECT_EQ(answer(up_for(20.0), 1s), "the supervisor answers again");
  EXPECT_EQ(answer(up_for(21.0), 2s), "");
}

TEST_F(SupervisorStoryTest, OtherProcessesWantedEndsAndThePastAreNotItsMatter) {
  EXPECT_EQ(event(exited("supervisor")), "") << "before anybody answered";
  EXPECT_EQ(answer(up_for(20.0), 0s), "");
  EXPECT_EQ(event(exited("world")), "");
  EXPECT_EQ(event(exited("supervisor", kPid, true)), "");
  EXPECT_EQ(event(exited("supervisor", 122)), "") << "its predecessor";
  EXPECT_NE(silence(500ms), "");
}

}  // namespace
}  // namespace hecaton::services::cli
