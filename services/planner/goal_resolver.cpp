#include "services/planner/goal_resolver.hpp"

#include <utility>

#include "services/planner/background_thread.hpp"

namespace hecaton::services {

struct GoalResolver::Impl {
  using Thread = BackgroundThread<GoalQuestion, GoalAnswer>;

  Impl(std::vector<planner::Arm> arms, int self)
      : geometry(std::move(arms), self), thread([this](auto question) {
          geometry.set_obstacles(*question->obstacles);
          return Thread::Turn{resolve_goal(geometry, question->goal, question->q_now, question->states)};
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

}  // namespace hecaton::services
