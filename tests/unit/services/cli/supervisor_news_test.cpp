#include "services/cli/supervisor_news.hpp"

#include <gtest/gtest.h>

namespace hecaton::services::cli {
namespace {

using namespace std::chrono_literals;

constexpr bus::Clock::time_point kBegin{1h};

msg::ProcessEvent exited(const std::string& node, bool wanted = false) {
  msg::ProcessEvent event;
  event.node(node);
  event.pid(123);
  event.kind(msg::PROCESS_EXITED);
  event.signal_number(9);
  event.wanted(wanted);
  return event;
}

msg::CellStatus up_for(double uptime) {
  msg::CellStatus status;
  status.uptime(uptime);
  return status;
}

TEST(SupervisorStory, DeathAndReturnAreALineEach) {
  SupervisorStory story;
  const msg::CellStatus old = up_for(20.0);
  EXPECT_EQ(story.answer(&old, kBegin), "");
  EXPECT_EQ(story.process(exited("supervisor"), kBegin),
            "the supervisor died (process 123, signal 9): arms go on, faults and orders wait for its successor");
  EXPECT_EQ(story.answer(&old, kBegin + 10ms), "") << "the dead one's last answer";
  EXPECT_EQ(story.answer(nullptr, kBegin + 500ms), "") << "known already";
  const msg::CellStatus successor = up_for(0.2);
  EXPECT_EQ(story.answer(&successor, kBegin + 600ms), "the supervisor is back: a successor took its place");
  EXPECT_EQ(story.answer(&successor, kBegin + 700ms), "");
}

TEST(SupervisorStory, SilenceIsToldOnce) {
  SupervisorStory story;
  EXPECT_EQ(story.answer(nullptr, kBegin), "the supervisor does not answer: arms go on, faults and orders wait for it");
  EXPECT_EQ(story.answer(nullptr, kBegin + 500ms), "");
  const msg::CellStatus status = up_for(20.0);
  EXPECT_EQ(story.answer(&status, kBegin + 1s), "the supervisor answers again");
  EXPECT_EQ(story.answer(&status, kBegin + 2s), "");
}

TEST(SupervisorStory, OtherProcessesAndWantedEndsAreNotItsMatter) {
  SupervisorStory story;
  EXPECT_EQ(story.process(exited("world"), kBegin), "");
  EXPECT_EQ(story.process(exited("supervisor", true), kBegin), "");
}

}  // namespace
}  // namespace hecaton::services::cli
