#pragma once
/// Runs rollouts on a thread of its own, a share in every control period, so that they never delay a command and never
/// take more of a processor than they were granted. The loop's side never waits for the thread, which may be without a
/// processor while it holds the lock.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planner/rollout/rollout_search.hpp"
#include "services/runtime/turn_watch.hpp"

namespace hecaton::services {

class RolloutWorker {
 public:
  /// As RolloutSearch. `share`: ticks of single arms that one grant() allows.
  RolloutWorker(std::vector<planner::Arm> arms, std::vector<planner::LocalParameters> parameters, int self, int share);
  ~RolloutWorker();  ///< gives up the question under way
  RolloutWorker(const RolloutWorker&) = delete;
  RolloutWorker& operator=(const RolloutWorker&) = delete;

  using Obstacles = std::shared_ptr<const std::vector<world::Obstacle>>;

  /// `obstacles`: those whose states the question holds. At most one question at a time.
  void ask(planner::RolloutQuestion question, Obstacles obstacles);
  /// A control period has begun: the thread may go on.
  void grant();
  /// Once, when it is there.
  [[nodiscard]] std::optional<planner::RolloutAnswer> answer();
  /// As of BackgroundThread.
  [[nodiscard]] TurnWatch::Clock::duration silence(TurnWatch::Clock::time_point now);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
