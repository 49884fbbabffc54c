#include "services/planner/goal_resolver.hpp"

#include <utility>

#include "services/planner/background_thread.hpp"

namespace hecaton::services {

struct GoalResolver::Impl {
  using Thread = BackgroundThread<GoalQuestion, GoalAnswer>;

  Impl(std::vector<planner::Arm> arms, int self)
      : geometry(std::move(arms), self), thread([this](auto question) {
          const GoalQuestion& asked = question.value();  // nothing goes on without one
          geometry.set_obstacles(*asked.obstacles);
          return Thread::Turn{resolve_goal(geometry, asked.goal, asked.q_now, asked.states)};
        }) {}

  planner::CellGeometry geometry;  ///< of the thread alone
  Thread thread;
};

GoalResolver::GoalResolver(std::vector<planner::Arm> arms, int self)
    : impl_(std::make_unique<Impl>(std::move(arms), self)) {}
GoalResolver::~GoalResolver() = default;

void GoalResolver::ask(GoalQuestion question) {
  impl_->thread.ask(std::move(question));
}

std::vector<GoalAnswer> GoalResolver::answers() {
  std::vector<GoalAnswer> all;
  while (auto answer = impl_->thread.answer()) all.push_back(std::move(*answer));
  return all;
}

TurnWatch::Clock::duration GoalResolver::silence(TurnWatch::Clock::time_point now) {
  return impl_->thread.silence(now);
}

}  // namespace hecaton::services
