#include "services/planner/background_thread.hpp"

#include <atomic>
#include <chrono>
#include <future>
#include <memory>

#include <gtest/gtest.h>

namespace hecaton::services {
namespace {

using Thread = BackgroundThread<int, int>;

std::optional<int> await_answer(Thread& thread) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (std::chrono::steady_clock::now() < until) {
    if (const auto answer = thread.answer()) return answer;
    std::this_thread::yield();
  }
  return std::nullopt;
}

TEST(BackgroundThread, AnswersEachQuestionOnceInOrder) {
  Thread thread([](std::optional<int> question) { return Thread::Turn{2 * *question}; });
  EXPECT_EQ(thread.answer(), std::nullopt);
  for (int i = 0; i < 100; ++i) thread.ask(i);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(await_answer(thread), 2 * i);
  EXPECT_EQ(thread.answer(), std::nullopt);
}

TEST(BackgroundThread, NeverBlocksTheLoop) {
  std::promise<void> may_go_on;
  const std::shared_future<void> gate = may_go_on.get_future().share();
  Thread thread([gate](std::optional<int> question) {
    gate.wait();
    return Thread::Turn{*question};
  });
  // If one of these calls waited for the thread, the test would hang.
  thread.ask(1);
  thread.ask(2);
  thread.grant();
  EXPECT_EQ(thread.answer(), std::nullopt);
  may_go_on.set_value();
  EXPECT_EQ(await_answer(thread), 1);
  EXPECT_EQ(await_answer(thread), 2);
}

TEST(BackgroundThread, ContinuesWhenATurnIsGranted) {
  std::atomic<int> turns = 0;
  int left = 0;  // used by the thread only
  Thread thread([&](std::optional<int> question) {
    ++turns;
    if (question) left = *question;
    --left;
    return left > 0 ? Thread::Turn{std::nullopt, true} : Thread::Turn{7};
  });
  thread.grant();
  EXPECT_EQ(turns, 0) << "nothing to do";
  thread.ask(3);
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  std::optional<int> answer;
  while (!answer && std::chrono::steady_clock::now() < until) {
    thread.grant();
    std::this_thread::yield();
    answer = thread.answer();
  }
  EXPECT_EQ(answer, 7);
  EXPECT_EQ(turns, 3);
}

TEST(BackgroundThread, MeasuresItsSilence) {
  using namespace std::chrono_literals;
  std::promise<void> may_go_on;
  const std::shared_future<void> gate = may_go_on.get_future().share();
  Thread thread([gate](std::optional<int> question) {
    gate.wait();
    return Thread::Turn{*question};
  });
  ProgressWatchdog::Clock::time_point now{1h};
  const auto look_for = [&](ProgressWatchdog::Clock::duration time) {
    ProgressWatchdog::Clock::duration silence{};
    for (const auto until = now + time; now < until;) silence = thread.silence(now += 10ms);
    return silence;
  };
  EXPECT_EQ(look_for(5s), 0s) << "no question";
  thread.ask(1);
  thread.ask(2);
  EXPECT_EQ(look_for(10ms), 0s);
  EXPECT_EQ(look_for(7s), 7s);
  may_go_on.set_value();
  EXPECT_EQ(await_answer(thread), 1);
  EXPECT_EQ(await_answer(thread), 2);
  EXPECT_EQ(look_for(5s), 0s);
}

TEST(BackgroundThread, IsNotSilentWithoutAGrantedTurn) {
  using namespace std::chrono_literals;
  Thread thread([](std::optional<int> question) { return Thread::Turn{question, true}; });
  thread.ask(1);
  EXPECT_EQ(await_answer(thread), 1);
  ProgressWatchdog::Clock::time_point now{1h};
  for (int i = 0; i < 100; ++i) EXPECT_EQ(thread.silence(now += 10ms), 0s);
}

TEST(BackgroundThread, EndsWithOpenQuestions) {
  Thread thread([](std::optional<int> question) { return Thread::Turn{*question}; });
  for (int i = 0; i < 1000; ++i) thread.ask(i);
}

}  // namespace
}  // namespace hecaton::services
