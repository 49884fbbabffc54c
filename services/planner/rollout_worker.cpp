#include "services/planner/rollout_worker.hpp"

#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "services/planner/background_thread.hpp"

namespace hecaton::services {
struct RolloutWorker::Impl {
  Impl(const std::vector<planner::Arm>& arms, std::vector<planner::LocalParameters> parameters, int self, int ticks)
      : search(arms, std::move(parameters), self), share(ticks), thread([this] { work(); }) {}
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
      wake.wait(lock, [this] { return ending || question || (granted && search.busy()); });
      if (ending) return;
      const auto asked = std::exchange(question, std::nullopt);
      const Obstacles present = obstacles;
      granted = false;
      lock.unlock();
      if (asked && present != known) {
        known = present;
        search.set_obstacles(*known);
      }
      if (asked) search.begin(*asked);
      const auto found = search.advance(share);
      lock.lock();
      if (found) answer = found;
    }
  }

  /// The thread may be without a processor while it holds the lock: then another period.
  void hand_over() {
    if (!unasked) return;
    {
      const std::unique_lock lock(mutex, std::try_to_lock);
      if (!lock) return;
      question = std::exchange(unasked, std::nullopt);
      obstacles = unasked_obstacles;
    }
    wake.notify_one();
  }

  std::optional<planner::RolloutQuestion> unasked;  ///< of the control loop alone, with
  Obstacles unasked_obstacles;                      ///< its obstacles
  planner::RolloutSearch search;                    ///< of the thread alone, with
  Obstacles known;                                  ///< its obstacles
  int share;
  std::mutex mutex;
  std::condition_variable wake;
  Obstacles obstacles;  ///< of the question
  std::optional<planner::RolloutQuestion> question;
  std::optional<planner::RolloutAnswer> answer;
  bool granted = false;
  bool ending = false;
  std::thread thread;  ///< last: everything it uses exists before it starts
};

RolloutWorker::RolloutWorker(std::vector<planner::Arm> arms, std::vector<planner::LocalParameters> parameters, int self,
                             int share)
    : impl_(std::make_unique<Impl>(arms, std::move(parameters), self, share)) {}
RolloutWorker::~RolloutWorker() = default;

void RolloutWorker::ask(planner::RolloutQuestion question, Obstacles obstacles) {
  impl_->unasked = std::move(question);
  impl_->unasked_obstacles = std::move(obstacles);
  impl_->hand_over();
}

void RolloutWorker::grant() {
  impl_->hand_over();
  {
    const std::unique_lock lock(impl_->mutex, std::try_to_lock);
    if (!lock) return;
    impl_->granted = true;
  }
  impl_->wake.notify_one();
}

std::optional<planner::RolloutAnswer> RolloutWorker::answer() {
  const std::unique_lock lock(impl_->mutex, std::try_to_lock);
  return lock ? std::exchange(impl_->answer, std::nullopt) : std::nullopt;
}

}  // namespace hecaton::services
