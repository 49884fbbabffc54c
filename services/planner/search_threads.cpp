#include "services/planner/search_threads.hpp"

#include <utility>
#include <vector>

#include "services/planner/background_thread.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::services {
namespace {

using planner::SharedObstacles;

/// Searches have no time limit and low priority. A search that takes longer than this counts as stalled.
constexpr std::chrono::seconds kLongestSearch{60};

template <class Question>
struct Asked {
  Question question;
  SharedObstacles obstacles;
};

/// A search with its obstacles, for one thread.
template <class Search>
struct UpToDate {
  Search search;
  SharedObstacles known;

  template <class Question>
  void renew(const Asked<Question>& asked) {
    if (asked.obstacles == known) return;
    known = asked.obstacles;
    search.set_obstacles(*known);
  }
};

class RolloutThread {
 public:
  RolloutThread(const planner::Cell& cell, int self)
      : search_{planner::RolloutSearch(arms_of(cell), parameters_of(cell), self), nullptr},
        share_(cell.arms[self].parameters.rollout.ticks_per_period),
        thread_([this](auto asked) {
          if (asked) {
            search_.renew(*asked);
            search_.search.begin(std::move(asked->question));
          }
          auto found = search_.search.advance(share_);
          return Thread::Turn{std::move(found), search_.search.busy()};
        }) {}

  [[nodiscard]] auto& thread() { return thread_; }

 private:
  using Thread = BackgroundThread<Asked<planner::RolloutQuestion>, planner::RolloutAnswer>;

  UpToDate<planner::RolloutSearch> search_;  ///< used by the background thread only
  int share_;                                ///< ticks of single arms per turn
  Thread thread_;
};

class RouteThread {
 public:
  RouteThread(const planner::Cell& cell, int self)
      : search_{planner::RouteSearch(arms_of(cell), parameters_of(cell), self), nullptr}, thread_([this](auto asked) {
          search_.renew(asked.value());
          const auto began = std::chrono::steady_clock::now();
          planner::RouteAnswer answer = search_.search.answer(asked->question);
          return Thread::Turn{Answer{std::move(answer), std::chrono::steady_clock::now() - began}};
        }) {}

  [[nodiscard]] std::optional<planner::RouteAnswer> answer() {
    std::optional<Answer> found = thread_.answer();
    if (!found) return std::nullopt;
    if (found->route.kind == planner::RouteAnswer::Kind::kFound) {
      log_debug("route", {{"points", found->route.points.size()},
                          {"ms", std::chrono::duration<double, std::milli>(found->taken).count()}});
    }
    return std::move(found->route);
  }
  [[nodiscard]] auto& thread() { return thread_; }

 private:
  struct Answer {
    planner::RouteAnswer route;
    std::chrono::steady_clock::duration taken;
  };
  using Thread = BackgroundThread<Asked<planner::RouteQuestion>, Answer>;

  UpToDate<planner::RouteSearch> search_;  ///< used by the background thread only
  Thread thread_;
};

}  // namespace

struct SearchThreads::Impl {
  Impl(const planner::Cell& cell, int self) : rollouts(cell, self), routes(cell, self), coupled_plans(cell, self) {}

  RolloutThread rollouts;
  RouteThread routes;
  RouteThread coupled_plans;
};

SearchThreads::SearchThreads(const planner::Cell& cell, int self) : impl_(std::make_unique<Impl>(cell, self)) {}
SearchThreads::~SearchThreads() = default;

planner::SearchAnswers SearchThreads::answers() {
  return {impl_->rollouts.thread().answer(), impl_->routes.answer(), impl_->coupled_plans.answer()};
}

void SearchThreads::ask(planner::SearchQuestions questions, const SharedObstacles& obstacles) {
  if (questions.rollout) {
    impl_->rollouts.thread().ask({std::move(*questions.rollout), obstacles});
  } else {
    impl_->rollouts.thread().grant();
  }
  if (questions.route) impl_->routes.thread().ask({std::move(*questions.route), obstacles});
  if (questions.coupled_plan) impl_->coupled_plans.thread().ask({std::move(*questions.coupled_plan), obstacles});
}

std::optional<std::string> SearchThreads::stalled(ProgressWatchdog::Clock::time_point now) {
  // All threads are checked in every period: silence() also hands over questions.
  const std::vector<std::pair<const char*, ProgressWatchdog::Clock::duration>> silences{
      {"the thread that runs rollouts", impl_->rollouts.thread().silence(now)},
      {"the thread that searches routes", impl_->routes.thread().silence(now)},
      {"the thread that searches coupled plans", impl_->coupled_plans.thread().silence(now)}};
  for (const auto& [thread, silence] : silences) {
    if (silence > kLongestSearch) return stall_text(thread, silence, kLongestSearch);
  }
  return std::nullopt;
}

}  // namespace hecaton::services
