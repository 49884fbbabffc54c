#include "services/planner/goal_resolver.hpp"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "services/planner/background_thread.hpp"

namespace hecaton::services {
struct GoalResolver::Impl {
  Impl(std::vector<planner::Arm> arms, int self) : geometry(std::move(arms), self), thread([this] { work(); }) {}
  ~Impl() {
    {
      const std::scoped_lock lock(mutex);
      ending = true;
    }
    asked.notify_one();
    thread.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void work() {
    give_way_to_control_loop();
    while (true) {
      std::unique_lock lock(mutex);
      asked.wait(lock, [this] { return ending || !questions.empty(); });
      if (ending) return;
      const GoalQuestion question = std::move(questions.front());
      questions.pop_front();
      lock.unlock();
      geometry.set_obstacles(*question.obstacles);
      GoalAnswer answer = resolve_goal(geometry, question.goal, question.q_now, question.states);
      lock.lock();
      answers.push_back(std::move(answer));
    }
  }

  planner::CellGeometry geometry;  ///< of the thread alone
  std::mutex mutex;
  std::condition_variable asked;
  std::deque<GoalQuestion> questions;
  std::vector<GoalAnswer> answers;
  bool ending = false;
  std::thread thread;  ///< last: everything it uses exists before it starts
};

GoalResolver::GoalResolver(std::vector<planner::Arm> arms, int self)
    : impl_(std::make_unique<Impl>(std::move(arms), self)) {}
GoalResolver::~GoalResolver() = default;

void GoalResolver::ask(GoalQuestion question) {
  {
    const std::scoped_lock lock(impl_->mutex);
    impl_->questions.push_back(std::move(question));
  }
  impl_->asked.notify_one();
}

std::vector<GoalAnswer> GoalResolver::answers() {
  const std::scoped_lock lock(impl_->mutex);
  return std::exchange(impl_->answers, {});
}

}  // namespace hecaton::services
