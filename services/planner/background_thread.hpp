#pragma once
/// The planner's other threads: the control loop asks them and looks for answers every period, and never waits for one.

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

#include "services/runtime/turn_watch.hpp"
#include "services/runtime/urgency.hpp"

namespace hecaton::services {

/// A thread, its questions and its answers, each in their order. All functions are for the loop's thread alone. The
/// other one may be without a processor while it holds the lock: then what is handed over changes hands another period.
template <class Question, class Answer>
class BackgroundThread {
 public:
  struct Turn {
    std::optional<Answer> answer = {};
    bool goes_on = false;  ///< there is more to do, once the loop grants it
  };
  /// On the thread: with the next question, or, granted a turn, without.
  using Work = std::function<Turn(std::optional<Question>)>;

  explicit BackgroundThread(Work work) : work_(std::move(work)), thread_([this] { run(); }) {}
  /// Waits for the turn under way; what is asked besides is given up.
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
    unasked_.push_back(std::move(question));
    hand_over(false);
  }
  /// Allows a thread that goes on another turn.
  void grant() { hand_over(true); }
  /// The next one, once. To be called every period: it also hands over what could not be before.
  [[nodiscard]] std::optional<Answer> answer() {
    hand_over(false);
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || answers_.empty()) return std::nullopt;
    std::optional<Answer> next(std::move(answers_.front()));
    answers_.pop_front();
    return next;
  }
  /// To be called every period: for how long it has finished no turn though it has something to do. Also hands over.
  [[nodiscard]] TurnWatch::Clock::duration silence(TurnWatch::Clock::time_point now) {
    hand_over(false);
    watch_.look(now, open_ > 0, finished_);
    return watch_.silence();
  }

 private:
  void hand_over(bool grants) {
    if (unasked_.empty() && !grants) return;
    {
      const std::unique_lock lock(mutex_, std::try_to_lock);
      if (!lock) return;
      std::move(unasked_.begin(), unasked_.end(), std::back_inserter(questions_));
      unasked_.clear();
      granted_ = granted_ || grants;
    }
    wake_.notify_one();
  }

  void run() {
    constexpr int kNiceness = 10;
    stand_back(kNiceness);
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
        ++open_;  // a turn that was granted
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

  Work work_;                     ///< of the thread alone
  std::deque<Question> unasked_;  ///< of the control loop alone
  TurnWatch watch_;               ///< likewise
  std::atomic<int> open_ = 0;     ///< questions that were asked and turns that were begun, and are not finished
  std::atomic<std::uint64_t> finished_ = 0;  ///< of them
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Question> questions_;
  std::deque<Answer> answers_;
  bool granted_ = false;
  bool ending_ = false;
  std::thread thread_;  ///< last: everything it uses exists before it starts
};

}  // namespace hecaton::services
