#include "planner/simulation/virtual_time_searches.hpp"

#include <utility>

namespace hecaton::planner {
namespace {

/// Configurations that a planner's second thread checks in a control period, in a search for a route: a third of a
/// microsecond each, and it shares its processor.
constexpr std::uint64_t kChecksPerPeriod = 10'000;

}  // namespace

SearchAnswers VirtualTimeSearches::answers() {
  now_ = static_cast<double>(periods_++) * cell_->control_period;
  SearchAnswers answers;
  if (rollouts_ && rollouts_->busy()) {
    answers.rollout = rollouts_->advance(cell_->parameters[self_].rollout.ticks_per_period);
  }
  answers.route = due(routes_);
  answers.coupled_plan = due(coupled_plans_);
  return answers;
}

// The obstacles stay the cell's.
void VirtualTimeSearches::ask(SearchQuestions questions, const SharedObstacles& /*obstacles*/) {
  if (questions.rollout) {
    if (!rollouts_) {
      rollouts_ = std::make_unique<RolloutSearch>(cell_->arms, cell_->parameters, self_);
      rollouts_->set_obstacles(*cell_->obstacles);
    }
    rollouts_->begin(std::move(*questions.rollout));
  }
  if (questions.coupled_plan) begin(coupled_plans_, *questions.coupled_plan);
  if (questions.route) begin(routes_, *questions.route);
}

std::optional<RouteAnswer> VirtualTimeSearches::due(PendingSearch& way) const {
  if (!way.answer || now_ < way.at) return std::nullopt;
  return std::exchange(way.answer, std::nullopt);
}

void VirtualTimeSearches::begin(PendingSearch& way, const RouteQuestion& question) const {
  if (!way.search) {
    way.search = std::make_unique<RouteSearch>(cell_->arms, cell_->parameters, self_);
    way.search->set_obstacles(*cell_->obstacles);
  }
  way.answer = way.search->answer(question);
  const auto periods = static_cast<double>(1 + way.answer->checks / kChecksPerPeriod);
  way.at = now_ + (periods - 0.5) * cell_->control_period;
}

}  // namespace hecaton::planner
