#pragma once
/// The searches that an arm's planner runs beside its control periods: what it asks, what it is answered, and who runs
/// them. The planner service runs them on threads, the simulation in virtual time.

#include <memory>
#include <optional>
#include <vector>

#include "planner/rollout/rollout_search.hpp"
#include "planner/route/route_search.hpp"

namespace hecaton::planner {

/// The cell's obstacles, shared by all that read them.
using SharedObstacles = std::shared_ptr<const std::vector<world::Obstacle>>;

/// At most one question of each kind is open at a time.
struct SearchQuestions {
  std::optional<RolloutQuestion> rollout = {};
  std::optional<RouteQuestion> route = {};
  std::optional<RouteQuestion> coupled_plan = {};
};

struct SearchAnswers {
  std::optional<RolloutAnswer> rollout = {};
  std::optional<RouteAnswer> route = {};
  std::optional<RouteAnswer> coupled_plan = {};
};

/// Used by one thread, the one of the control loop. No function waits for a search.
class SearchExecutor {
 public:
  SearchExecutor() = default;
  virtual ~SearchExecutor() = default;
  SearchExecutor(const SearchExecutor&) = delete;
  SearchExecutor& operator=(const SearchExecutor&) = delete;

  /// At the beginning of a control period: the answers that have been found since the last call, each once.
  [[nodiscard]] virtual SearchAnswers answers() = 0;
  /// At the end of a control period: takes the period's questions, and lets open searches continue. `obstacles`: those
  /// whose states the questions hold.
  virtual void ask(SearchQuestions questions, const SharedObstacles& obstacles) = 0;

 protected:
  SearchExecutor(SearchExecutor&&) = default;
  SearchExecutor& operator=(SearchExecutor&&) = default;
};

}  // namespace hecaton::planner
