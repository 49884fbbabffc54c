#include "services/planner/rollout_worker.hpp"

#include <utility>

#include "services/planner/background_thread.hpp"

namespace hecaton::services {

struct RolloutWorker::Impl {
  struct Asked {
    planner::RolloutQuestion question;
    Obstacles obstacles;
  };
  using Thread = BackgroundThread<Asked, planner::RolloutAnswer>;

  Impl(const std::vector<planner::Arm>& arms, std::vector<planner::LocalParameters> parameters, int self, int ticks)
      : search(arms, std::move(parameters), self), share(ticks), thread([this](auto asked) {
          if (asked) begin(*asked);
          auto found = search.advance(share);
          return Thread::Turn{std::move(found), search.busy()};
        }) {}

  void begin(const Asked& asked) {
    if (asked.obstacles != known) {
      known = asked.obstacles;
      search.set_obstacles(*known);
    }
    search.begin(asked.question);
  }

  planner::RolloutSearch search;  ///< of the thread alone, with
  Obstacles known;                ///< its obstacles
  int share;
  Thread thread;
};

RolloutWorker::RolloutWorker(std::vector<planner::Arm> arms, std::vector<planner::LocalParameters> parameters, int self,
                             int share)
    : impl_(std::make_unique<Impl>(arms, std::move(parameters), self, share)) {}
RolloutWorker::~RolloutWorker() = default;

void RolloutWorker::ask(planner::RolloutQuestion question, Obstacles obstacles) {
  impl_->thread.ask({std::move(question), std::move(obstacles)});
}

void RolloutWorker::grant() {
  impl_->thread.grant();
}

std::optional<planner::RolloutAnswer> RolloutWorker::answer() {
  return impl_->thread.answer();
}

TurnWatch::Clock::duration RolloutWorker::silence(TurnWatch::Clock::time_point now) {
  return impl_->thread.silence(now);
}

}  // namespace hecaton::services
