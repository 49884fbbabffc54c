#pragma once
/// The searches that an arm's planner runs in parallel with its control periods: questions, answers and their executor.

#include <memory>
#include <optional>
#include <vector>

#include "planner/rollout/rollout_search.hpp"
#include "planner/route/route_search.hpp"

namespace hecaton::planner {

/// The cell's obstacles. Immutable, shared between threads.
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

/// The planner service runs searches on threads, the simulation runs them in virtual time. Only the thread of the
/// control loop calls an executor. No function waits for a search.
class SearchExecutor {
 public:
  SearchExecutor() = default;
  virtual ~SearchExecutor() = default;
  SearchExecutor(const SearchExecutor&) = delete;
  SearchExecutor& operator=(const SearchExecutor&) = delete;

  /// Call at the beginning of a control period. Returns the answers since the last call, each once.
  [[nodiscard]] virtual SearchAnswers answers() = 0;
  /// Call at the end of a control period. Takes the period's questions and lets open searches continue. `obstacles`:
  /// the obstacles that the states in the questions belong to.
  virtual void ask(SearchQuestions questions, const SharedObstacles& obstacles) = 0;

 protected:
  SearchExecutor(SearchExecutor&&) = default;
  SearchExecutor& operator=(SearchExecutor&&) = default;
};

}  // namespace hecaton::planner
