#pragma once
/// Searches routes on a thread of its own, so that they never delay a command.

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "planner/route/route_search.hpp"
#include "services/runtime/turn_watch.hpp"

namespace hecaton::services {

class RouteWorker {
 public:
  /// As RouteSearch.
  RouteWorker(std::vector<planner::Arm> arms, std::vector<planner::LocalParameters> parameters, int self);
  ~RouteWorker();  ///< waits for the question under way
  RouteWorker(const RouteWorker&) = delete;
  RouteWorker& operator=(const RouteWorker&) = delete;

  using Obstacles = std::shared_ptr<const std::vector<world::Obstacle>>;

  /// `obstacles`: those whose states the question holds. At most one question at a time.
  void ask(planner::RouteQuestion question, Obstacles obstacles);

  struct Answer {
    planner::RouteAnswer route;
    std::chrono::steady_clock::duration taken;  ///< by the search
  };
  /// Once, when it is there. To be called every period; neither this nor ask() ever waits for the thread.
  [[nodiscard]] std::optional<Answer> answer();
  /// As of BackgroundThread.
  [[nodiscard]] TurnWatch::Clock::duration silence(TurnWatch::Clock::time_point now);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
