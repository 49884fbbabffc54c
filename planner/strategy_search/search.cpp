#include "planner/strategy_search/search.hpp"

#include <algorithm>
#include <atomic>
#include <future>
#include <mutex>
#include <stdexcept>

#include <nlopt.hpp>

#include "planner/methods/strategy/strategy.hpp"

namespace hecaton::planner {

std::vector<Strategy> StrategyGrid::of_arm(int coefficients) const {
  std::vector<Strategy> grid(1);
  for (int k = 0; k < coefficients; ++k) {
    std::vector<Strategy> wider;
    for (const Strategy& strategy : grid) {
      for (const double value : k == 0 ? alpha : beta) {
        wider.push_back(strategy);
        wider.back().coefficients[k] = value;
      }
    }
    grid = std::move(wider);
  }
  std::vector<Strategy> both;
  for (const Strategy& strategy : grid) {
    for (const double direction : {1.0, -1.0}) {
      both.push_back(strategy);
      both.back().direction = direction;
    }
  }
  return both;
}

std::vector<SystemStrategy> StrategyGrid::of(const StrategyProblem& problem, std::size_t limit) const {
  std::vector<SystemStrategy> grid(1);
  for (int arm = 0; arm < problem.arms(); ++arm) {
    const std::vector<Strategy> own = of_arm(problem.coefficients(arm));
    if (grid.size() * own.size() > limit) {
      throw ProblemError("the grid has more than " + std::to_string(limit) +
                         " strategies: give fewer values of α and β");
    }
    std::vector<SystemStrategy> wider;
    for (const SystemStrategy& system : grid) {
      for (const Strategy& strategy : own) {
        wider.push_back(system);
        wider.back().push_back(strategy);
      }
    }
    grid = std::move(wider);
  }
  return grid;
}

namespace {

/// Calls work(i) for each candidate of this process, on all its threads. Rethrows an exception of work.
template <typename Work>
void for_each_own(const SearchHooks& hooks, std::size_t count, const Work& work) {
  std::atomic<std::size_t> next{static_cast<std::size_t>(hooks.part)};
  const auto parts = static_cast<std::size_t>(hooks.parts);
  const auto take = [&] {
    for (std::size_t i = next.fetch_add(parts); i < count; i = next.fetch_add(parts)) work(i);
  };
  std::vector<std::future<void>> others;
  for (int i = 1; i < hooks.threads; ++i) others.push_back(std::async(std::launch::async, take));
  take();
  for (std::future<void>& other : others) other.get();
}

/// Exchanges results with the other processes, if there are any.
template <typename Found, typename FromText>
void share(const SearchHooks& hooks, std::vector<Found>& found, const FromText& from_text) {
  if (!hooks.share) return;
  std::vector<std::string> texts(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (is_own(hooks, i)) texts[i] = text_of(found[i]);
  }
  hooks.share(texts);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (is_own(hooks, i)) continue;
    auto theirs = from_text(texts.at(i));
    if (!theirs) throw std::runtime_error("another process of the search has sent an invalid result");
    found[i] = std::move(*theirs);
  }
}

struct Objective {
  const StrategyProblem& problem;
  const TaskSet& tasks;
  const SimplexOptions& options;
  SimplexResult result;

  [[nodiscard]] SystemStrategy strategy_at(const std::vector<double>& x) const {
    SystemStrategy strategy = result.strategy;
    std::size_t at = 0;
    for (int arm = 0; arm < problem.arms(); ++arm) {
      for (int k = 0; k < problem.coefficients(arm); ++k) strategy[arm].coefficients[k] = x[at++];
    }
    return strategy;
  }

  double operator()(const std::vector<double>& x) {
    // NLopt returns from the optimisation with this exception.
    if (result.steps > 0 && options.ended && options.ended(result.steps)) throw nlopt::forced_stop();
    SystemStrategy strategy = strategy_at(x);
    Evaluation evaluation = evaluate(problem, tasks, strategy);
    const double time = evaluation.mean_time();
    if (result.steps++ == 0) result.initial = result.final = evaluation;
    if (time < result.final.mean_time()) {
      result.final = std::move(evaluation);
      result.strategy = std::move(strategy);
    }
    return time;
  }
};

}  // namespace

std::vector<Evaluation> evaluate_round(const StrategyProblem& problem, std::span<const SystemStrategy> strategies,
                                       const Round& round, const SearchHooks& hooks) {
  TaskSet tasks = problem.draw(round.seed, round.tasks);
  constexpr std::size_t kPrecheckFrom = 4;  // candidates
  if (strategies.size() >= kPrecheckFrom) problem.precheck_paths(tasks);
  EvaluateOptions options{.stop_at_fault = round.stop_at_fault};
  if (hooks.ended) options.ended = [&hooks](std::int64_t) { return hooks.ended(); };
  std::vector<Evaluation> evaluations(strategies.size());
  std::mutex reporting;
  for_each_own(hooks, strategies.size(), [&](std::size_t i) {
    const Evaluation* known = hooks.known ? hooks.known(round, i) : nullptr;
    if (known == nullptr && hooks.ended && hooks.ended()) return;
    Evaluation evaluation = known != nullptr ? *known : evaluate(problem, tasks, strategies[i], options);
    if (known == nullptr && hooks.ended && hooks.ended()) return;  // maybe incomplete
    evaluations[i] = std::move(evaluation);
    if (!hooks.evaluated) return;
    const std::lock_guard lock(reporting);
    hooks.evaluated(round, i, strategies.size(), evaluations[i]);
  });
  share(hooks, evaluations, evaluation_of);
  return evaluations;
}

bool better(const Evaluation& a, const Evaluation& b) {
  const double rate_a = a.fault_rate();
  const double rate_b = b.fault_rate();
  if (rate_a != rate_b) return rate_a < rate_b;
  return a.mean_time() < b.mean_time();
}

namespace {

/// Successive halving: two rounds with 1/9 and 1/3 of the tasks of the last one, each keeping a third of the
/// candidates.
constexpr int kKeptShare = 3;
constexpr int kHalvings = 2;

class Search {
 public:
  Search(const StrategyProblem& problem, const SearchPlan& plan, const SearchHooks& hooks)
      : problem_(problem), plan_(plan), hooks_(hooks) {}

  void begin(const std::vector<SystemStrategy>& strategies) {
    for (const SystemStrategy& strategy : strategies) report_.best.push_back({strategy, {}});
  }

  /// Evaluates the remaining candidates and sorts them.
  void run(Round round) {
    round.seed = plan_.seed + report_.stages.size();
    std::vector<SystemStrategy> strategies;
    for (const Candidate& candidate : report_.best) strategies.push_back(candidate.strategy);
    const std::vector<Evaluation> evaluations = evaluate_round(problem_, strategies, round, hooks_);
    SearchReport::Stage stage{round, strategies.size(), 0, 0, 0};
    for (std::size_t i = 0; i < evaluations.size(); ++i) {
      if (evaluations[i].tasks.empty()) continue;
      ++stage.evaluated;
      stage.without_fault += evaluations[i].all_faults() == 0 ? 1 : 0;
      stage.arm_ticks += evaluations[i].arm_ticks;
      report_.best[i].evaluation += evaluations[i];
    }
    report_.stages.push_back(stage);
    report_.ended_early = stage.evaluated < stage.candidates;
    std::erase_if(report_.best, [](const Candidate& candidate) { return candidate.evaluation.tasks.empty(); });
    std::stable_sort(report_.best.begin(), report_.best.end(),
                     [](const Candidate& a, const Candidate& b) { return better(a.evaluation, b.evaluation); });
  }

  /// Keeps the candidates without faults; if there are none, the best SearchPlan::keep.
  void keep_faultless() {
    const auto first_faulty = std::find_if(report_.best.begin(), report_.best.end(),
                                           [](const Candidate& c) { return c.evaluation.all_faults() > 0; });
    auto end = first_faulty;
    if (end == report_.best.begin()) end += static_cast<std::ptrdiff_t>(std::min(plan_.keep, report_.best.size()));
    report_.best.erase(end, report_.best.end());
  }

  void keep(std::size_t count) {
    if (report_.best.size() > count) report_.best.resize(count);
  }

  /// Adds candidates near the best ones, and resets all evaluations; unless the search is ended meanwhile.
  void refine() {
    std::vector<SystemStrategy> refined(std::min<std::size_t>(plan_.refine, report_.best.size()));
    TaskSet tasks = problem_.draw(plan_.seed, plan_.screening_tasks);
    problem_.precheck_paths(tasks);
    for_each_own(hooks_, refined.size(), [&](std::size_t i) {
      SimplexOptions options;
      options.max_steps = plan_.refine_steps;
      if (hooks_.ended) options.ended = [this](int) { return hooks_.ended(); };
      if (hooks_.ended && hooks_.ended()) return;
      refined[i] = refine_by_simplex(problem_, tasks, report_.best[i].strategy, options).strategy;
    });
    report_.ended_early = hooks_.ended && hooks_.ended();
    if (report_.ended_early) return;
    share(hooks_, refined, strategy_of);
    for (Candidate& candidate : report_.best) candidate.evaluation = {};
    for (SystemStrategy& strategy : refined) {
      // Without an improvement, the result is the initial strategy.
      const bool known = std::any_of(report_.best.begin(), report_.best.end(),
                                     [&](const Candidate& other) { return other.strategy == strategy; });
      if (!known) report_.best.push_back({std::move(strategy), {}});
    }
  }

  [[nodiscard]] bool any_faultless() const {
    return !report_.best.empty() && report_.best.front().evaluation.all_faults() == 0;
  }
  [[nodiscard]] bool ended() const { return report_.ended_early; }
  [[nodiscard]] std::size_t left() const { return report_.best.size(); }
  [[nodiscard]] SearchReport& report() { return report_; }

 private:
  const StrategyProblem& problem_;
  const SearchPlan& plan_;
  const SearchHooks& hooks_;
  SearchReport report_;
};

}  // namespace

SearchReport search_strategies(const StrategyProblem& problem, const std::vector<SystemStrategy>& candidates,
                               const SearchPlan& plan, const SearchHooks& hooks) {
  Search search(problem, plan, hooks);
  search.begin(candidates);
  if (plan.complete) {
    search.run({"complete", plan.screening_tasks, 0, false});
    return std::move(search.report());
  }
  int share = 1;
  for (int k = 0; plan.halving && k < kHalvings; ++k) share *= kKeptShare;
  for (; share > 1 && !search.ended(); share /= kKeptShare) {
    search.run({"halving", std::max(1, plan.screening_tasks / share), 0, true});
    if (!search.ended()) search.keep(std::max(plan.keep, search.left() / kKeptShare));
  }
  if (!search.ended()) search.run({"screening", plan.screening_tasks, 0, true});
  if (!search.ended()) search.keep_faultless();
  if (!search.ended() && plan.refine > 0) search.refine();
  for (int set = 0; set < plan.confirm_sets && !search.ended(); ++set) {
    search.run({"confirmation", plan.confirm_tasks, 0, search.any_faultless()});
    if (!search.ended()) search.keep_faultless();
  }
  return std::move(search.report());
}

SimplexResult refine_by_simplex(const StrategyProblem& problem, const TaskSet& tasks, const SystemStrategy& initial,
                                const SimplexOptions& options) {
  std::vector<double> x;
  for (int arm = 0; arm < problem.arms(); ++arm) {
    for (int k = 0; k < problem.coefficients(arm); ++k) x.push_back(initial[arm].coefficients[k]);
  }
  Objective objective{problem, tasks, options, {}};
  objective.result.strategy = initial;
  if (x.empty()) {
    objective(x);
    return objective.result;
  }
  nlopt::opt search(nlopt::LN_NELDERMEAD, static_cast<unsigned>(x.size()));
  search.set_min_objective([](const std::vector<double>& at, std::vector<double>&,
                              void* data) { return (*static_cast<Objective*>(data))(at); },
                           &objective);
  search.set_lower_bounds(-kMostCoefficient);
  search.set_upper_bounds(kMostCoefficient);
  search.set_initial_step(options.initial_size);
  search.set_ftol_abs(options.tolerance);
  search.set_maxeval(options.max_steps);
  double least = 0.0;
  try {
    search.optimize(x, least);
  } catch (const nlopt::roundoff_limited&) {
    // Rounding prevents further progress; the best value so far counts.
  } catch (const nlopt::forced_stop&) {
    // Ended by SimplexOptions::ended; the best value so far counts.
  }
  return objective.result;
}

}  // namespace hecaton::planner
