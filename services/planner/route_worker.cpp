#include "services/planner/route_worker.hpp"

#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "services/planner/background_thread.hpp"

namespace hecaton::services {

struct RouteWorker::Impl {
  struct Asked {
    planner::RouteQuestion question;
    Obstacles obstacles;
  };

  Impl(std::vector<planner::Arm> arms, std::vector<planner::LocalParameters> parameters, int self)
      : search(std::move(arms), std::move(parameters), self), thread([this] { work(); }) {}
  ~Impl() {
    {
      const std::scoped_lock lock(mutex);
      ending = true;
    }
    wake.notify_one();
    thread.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void work() {
    give_way_to_control_loop();
    std::unique_lock lock(mutex);
    while (true) {
      wake.wait(lock, [this] { return ending || asked; });
      if (ending) return;
      const Asked now = *std::exchange(asked, std::nullopt);
      lock.unlock();
      const auto began = std::chrono::steady_clock::now();
      if (now.obstacles != known) {
        known = now.obstacles;
        search.set_obstacles(*known);
      }
      planner::RouteAnswer found = search.answer(now.question);
      const auto taken = std::chrono::steady_clock::now() - began;
      lock.lock();
      answer = Answer{std::move(found), taken};
    }
  }

  /// The thread may be without a processor while it holds the lock: then another period.
  void hand_over() {
    if (!unasked) return;
    {
      const std::unique_lock lock(mutex, std::try_to_lock);
      if (!lock) return;
      asked = std::exchange(unasked, std::nullopt);
    }
    wake.notify_one();
  }

  std::optional<Asked> unasked;  ///< of the control loop alone
  planner::RouteSearch search;   ///< of the thread alone, with
  Obstacles known;               ///< its obstacles
  std::mutex mutex;
  std::condition_variable wake;
  std::optional<Asked> asked;
  std::optional<Answer> answer;
  bool ending = false;
  std::thread thread;  ///< last: everything it uses exists before it starts
};

RouteWorker::RouteWorker(std::vector<planner::Arm> arms, std::vector<planner::LocalParameters> parameters, int self)
    : impl_(std::make_unique<Impl>(std::move(arms), std::move(parameters), self)) {}
RouteWorker::~RouteWorker() = default;

void RouteWorker::ask(planner::RouteQuestion question, Obstacles obstacles) {
  impl_->unasked = {std::move(question), std::move(obstacles)};
  impl_->hand_over();
}

std::optional<RouteWorker::Answer> RouteWorker::answer() {
  impl_->hand_over();
  const std::unique_lock lock(impl_->mutex, std::try_to_lock);
  return lock ? std::exchange(impl_->answer, std::nullopt) : std::nullopt;
}

}  // namespace hecaton::services
