#pragma once
/// Runs an arm's searches in virtual time: each takes as many control periods as the planner's second thread would need
/// for it. Repeatable on every machine.

#include <memory>

#include "planner/arm_planner/search_executor.hpp"

namespace hecaton::planner {

class VirtualTimeSearches : public SearchExecutor {
 public:
  /// What the searches know; outlives them.
  struct Cell {
    std::vector<Arm> arms;
    std::vector<LocalParameters> parameters;
    SharedObstacles obstacles;
    double control_period = 0.010;  ///< [s]
  };
  /// `self`: index of the own arm.
  VirtualTimeSearches(const Cell& cell, int self) : cell_(&cell), self_(self) {}

  [[nodiscard]] SearchAnswers answers() override;
  void ask(SearchQuestions questions, const SharedObstacles& obstacles) override;

  /// Ticks of single arms that all rollouts took.
  [[nodiscard]] std::uint64_t rollout_ticks() const { return rollouts_ ? rollouts_->ticks() : 0; }

 private:
  /// A search for ways, whose answer comes when the configurations that it took could have been checked.
  struct PendingSearch {
    std::unique_ptr<RouteSearch> search;  ///< null until the first question
    std::optional<RouteAnswer> answer;    ///< known to the arm `at` this time [s]
    double at = 0.0;
  };
  [[nodiscard]] std::optional<RouteAnswer> due(PendingSearch& way) const;
  void begin(PendingSearch& way, const RouteQuestion& question) const;

  const Cell* cell_;
  int self_;
  long periods_ = 0;
  double now_ = 0.0;                         ///< [s]
  std::unique_ptr<RolloutSearch> rollouts_;  ///< null until the first question: most arms of a large cell never ask
  PendingSearch routes_;
  PendingSearch coupled_plans_;
};

}  // namespace hecaton::planner
