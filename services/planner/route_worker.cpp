#include "services/planner/route_worker.hpp"

#include <utility>

#include "services/planner/background_thread.hpp"

namespace hecaton::services {

struct RouteWorker::Impl {
  struct Asked {
    planner::RouteQuestion question;
    Obstacles obstacles;
  };
  using Thread = BackgroundThread<Asked, Answer>;

  Impl(std::vector<planner::Arm> arms, std::vector<planner::LocalParameters> parameters, int self)
      : search(std::move(arms), std::move(parameters), self),
        thread([this](auto asked) { return Thread::Turn{answer(asked.value())}; }) {}

  Answer answer(const Asked& asked) {
    const auto began = std::chrono::steady_clock::now();
    if (asked.obstacles != known) {
      known = asked.obstacles;
      search.set_obstacles(*known);
    }
    planner::RouteAnswer found = search.answer(asked.question);
    return {std::move(found), std::chrono::steady_clock::now() - began};
  }

  planner::RouteSearch search;  ///< of the thread alone, with
  Obstacles known;              ///< its obstacles
  Thread thread;
};

RouteWorker::RouteWorker(std::vector<planner::Arm> arms, std::vector<planner::LocalParameters> parameters, int self)
    : impl_(std::make_unique<Impl>(std::move(arms), std::move(parameters), self)) {}
RouteWorker::~RouteWorker() = default;

void RouteWorker::ask(planner::RouteQuestion question, Obstacles obstacles) {
  impl_->thread.ask({std::move(question), std::move(obstacles)});
}

std::optional<RouteWorker::Answer> RouteWorker::answer() {
  return impl_->thread.answer();
}

TurnWatch::Clock::duration RouteWorker::silence(TurnWatch::Clock::time_point now) {
  return impl_->thread.silence(now);
}

}  // namespace hecaton::services
