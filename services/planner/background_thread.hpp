#pragma once
/// A background thread of a planner, which the control loop uses without waiting.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <iterator>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "services/runtime/progress_watchdog.hpp"
#include "services/runtime/thread_priority.hpp"

namespace hecaton::services {

/// A thread that answers questions in their order. All functions are for the thread of the control loop and never wait,
/// except the destructor. The loop only tries to lock: if the background thread is preempted while it holds the lock,
/// questions and answers change hands in a later period.
template <class Question, class Answer>
class BackgroundThread {
 public:
  struct Turn {
    std::optional<Answer> answer = {};
    bool goes_on = false;  ///< the work continues in another turn, when the loop grants it
  };
  /// Runs in the background thread: with the next question, or without one to continue the work.
  using Work = std::function<Turn(std::optional<Question>)>;

  explicit BackgroundThread(Work work) : work_(std::move(work)), thread_([this] { run(); }) {}
  /// Waits for the present turn and drops all other questions.
  ~BackgroundThread() {
    {
      const std::scoped_lock lock(mutex_);
      ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  BackgroundThread(const BackgroundThread&) = delete;
  BackgroundThread& operator=(const BackgroundThread&) = delete;

  void ask(Question question) {
    ++open_;
    unsent_.push_back(std::move(question));
    hand_over(false);
  }
  /// Grants one more turn to a thread whose work continues.
  void grant() { hand_over(true); }
  /// The next answer. Call it every period: it also hands over questions.
  [[nodiscard]] std::optional<Answer> answer() {
    hand_over(false);
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || answers_.empty()) return std::nullopt;
    std::optional<Answer> next(std::move(answers_.front()));
    answers_.pop_front();
    return next;
  }
  /// For how long the thread has finished no turn although it has work. Call it every period: it also hands over
  /// questions.
  [[nodiscard]] ProgressWatchdog::Clock::duration silence(ProgressWatchdog::Clock::time_point now) {
    hand_over(false);
    watch_.update(now, open_ > 0, finished_);
    return watch_.silence();
  }

 private:
  void hand_over(bool grants) {
    if (unsent_.empty() && !grants) return;
    {
      const std::unique_lock lock(mutex_, std::try_to_lock);
      if (!lock) return;
      std::move(unsent_.begin(), unsent_.end(), std::back_inserter(questions_));
      unsent_.clear();
      granted_ = granted_ || grants;
    }
    wake_.notify_one();
  }

  void run() {
    constexpr int kNiceness = 10;
    lower_priority(kNiceness);
    bool goes_on = false;
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [&] { return ending_ || !questions_.empty() || (granted_ && goes_on); });
      if (ending_) return;
      std::optional<Question> question;
      if (!questions_.empty()) {
        question = std::move(questions_.front());
        questions_.pop_front();
      } else {
        ++open_;  // a granted turn
      }
      granted_ = false;
      lock.unlock();
      Turn turn = work_(std::move(question));
      goes_on = turn.goes_on;
      ++finished_;
      --open_;
      lock.lock();
      if (turn.answer) answers_.push_back(std::move(*turn.answer));
    }
  }

  Work work_;                                ///< used by the background thread only
  std::deque<Question> unsent_;              ///< used by the control loop only
  ProgressWatchdog watch_;                   ///< used by the control loop only
  std::atomic<int> open_ = 0;                ///< questions and granted turns that are not finished
  std::atomic<std::uint64_t> finished_ = 0;  ///< number of finished turns
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Question> questions_;
  std::deque<Answer> answers_;
  bool granted_ = false;
  bool ending_ = false;
  std::thread thread_;  ///< last: all members exist before it starts
};

}  // namespace hecaton::services
