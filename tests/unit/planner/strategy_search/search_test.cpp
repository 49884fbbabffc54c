#include "planner/strategy_search/search.hpp"

#include <mutex>
#include <set>

#include <gtest/gtest.h>

#include "planner/strategy_search/motion_problem.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::planner {
namespace {

Cell two_scorbots() {
  return config::load_cell_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/scorbot_2a.yaml").cell;
}

bool same(const Evaluation& a, const Evaluation& b) {
  return a.tasks == b.tasks && a.faults == b.faults && a.time == b.time && a.arm_ticks == b.arm_ticks;
}

// Section 5: three values of α, four of β, two directions, two robots: 576.
TEST(StrategyGridTest, HasTheCombinationsOfThePaper) {
  const StrategyProblem problem(two_scorbots());
  const std::vector<SystemStrategy> grid = StrategyGrid{}.of(problem);
  EXPECT_EQ(grid.size(), 576U);
  std::set<std::vector<double>> different;
  for (const SystemStrategy& s : grid) {
    different.insert({s[0].coefficients[0], s[0].coefficients[1], s[0].direction, s[1].coefficients[0],
                      s[1].coefficients[1], s[1].direction});
  }
  EXPECT_EQ(different.size(), 576U);
  EXPECT_THROW(static_cast<void>(StrategyGrid{}.of(problem, 100)), ProblemError);
}

TEST(SearchTest, IsTheSameForAllThreadsPartsAndResumptions) {
  const StrategyProblem problem(two_scorbots());
  const std::vector<SystemStrategy> grid = StrategyGrid{}.of(problem);
  const std::vector<SystemStrategy> some(grid.begin(), grid.begin() + 60);
  const Round round{"screening", 30, 9, true};
  const std::vector<Evaluation> one = evaluate_round(problem, some, round);

  SearchHooks threads;
  threads.threads = 3;
  const std::vector<Evaluation> three = evaluate_round(problem, some, round, threads);
  SearchHooks halves[2];
  std::vector<std::vector<Evaluation>> parts;
  for (int k = 0; k < 2; ++k) {
    halves[k].part = k;
    halves[k].parts = 2;
    parts.push_back(evaluate_round(problem, some, round, halves[k]));
  }
  SearchHooks resumed;
  std::size_t made = 0;
  resumed.known = [&](const Round&, std::size_t i) { return i < 50 ? &one[i] : nullptr; };
  resumed.evaluated = [&](const Round&, std::size_t, std::size_t, const Evaluation&) { ++made; };
  const std::vector<Evaluation> again = evaluate_round(problem, some, round, resumed);
  EXPECT_EQ(made, 60U);
  for (std::size_t i = 0; i < some.size(); ++i) {
    EXPECT_TRUE(same(one[i], three[i])) << i;
    EXPECT_TRUE(same(one[i], parts[i % 2][i])) << i;
    EXPECT_TRUE(parts[1 - i % 2][i].tasks.empty()) << i;
    EXPECT_TRUE(same(one[i], again[i])) << i;
  }
}

// Each of three processes has its own texts; the exchange gives all texts to all.
TEST(SearchTest, ProcessesExchangeTheirResults) {
  const StrategyProblem problem(two_scorbots());
  const std::vector<SystemStrategy> grid = StrategyGrid{}.of(problem);
  const std::vector<SystemStrategy> some(grid.begin() + 100, grid.begin() + 150);
  const Round round{"screening", 20, 5, true};
  const std::vector<Evaluation> alone = evaluate_round(problem, some, round);
  std::vector<std::string> known(some.size());
  for (int part = 0; part < 3; ++part) {
    SearchHooks hooks;
    hooks.part = part;
    hooks.parts = 3;
    hooks.share = [&](std::vector<std::string>& texts) {
      for (std::size_t i = 0; i < texts.size(); ++i) {
        EXPECT_EQ(texts[i].empty(), !is_own(hooks, i));
        if (is_own(hooks, i)) known[i] = texts[i];
        texts[i] = is_own(hooks, i) ? texts[i] : text_of(alone[i]);
      }
    };
    const std::vector<Evaluation> all = evaluate_round(problem, some, round, hooks);
    for (std::size_t i = 0; i < some.size(); ++i) EXPECT_TRUE(same(all[i], alone[i])) << part << ' ' << i;
  }
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(known[i], text_of(alone[i])) << i;

  SearchHooks garbled;
  garbled.parts = 2;
  garbled.share = [](std::vector<std::string>& texts) { texts[1] = "1 2"; };
  EXPECT_THROW(static_cast<void>(evaluate_round(problem, some, round, garbled)), std::runtime_error);
}

TEST(TextTest, ReadsWrittenTextAndRejectsOtherText) {
  Evaluation evaluation;
  evaluation.tasks = {3, 4};
  evaluation.faults = {0, 1};
  evaluation.time = {1.0 / 3.0, 2e17};
  evaluation.time2 = {0.1, 7.0};
  evaluation.arm_ticks = 12;
  evaluation.complete = true;
  const std::string text = text_of(evaluation);
  const std::optional<Evaluation> read = evaluation_of(text);
  ASSERT_TRUE(read);
  EXPECT_TRUE(same(*read, evaluation));
  EXPECT_EQ(read->time2, evaluation.time2);
  EXPECT_TRUE(read->complete);
  for (std::size_t cut = 0; cut < text.size(); ++cut) EXPECT_FALSE(evaluation_of(text.substr(0, cut))) << cut;
  EXPECT_FALSE(evaluation_of(text + " 5"));

  SystemStrategy strategy(2);
  strategy[0].coefficients = {-0.1, 1.0 / 7.0};
  strategy[1].direction = -1.0;
  const std::optional<SystemStrategy> again = strategy_of(text_of(strategy));
  ASSERT_TRUE(again);
  EXPECT_EQ(*again, strategy);
  EXPECT_FALSE(strategy_of(text));
}

TEST(SearchTest, ConfirmsCandidatesWithoutFault) {
  const StrategyProblem problem(two_scorbots());
  SearchPlan plan;
  plan.screening_tasks = 60;
  plan.confirm_tasks = 100;
  const SearchReport report = search_strategies(problem, StrategyGrid{}.of(problem), plan);
  ASSERT_EQ(report.stages.size(), 3U);
  EXPECT_EQ(report.stages[0].candidates, 576U);
  EXPECT_EQ(report.stages[1].candidates, report.stages[0].without_fault);
  EXPECT_EQ(report.best.size(), report.stages[2].without_fault);
  ASSERT_FALSE(report.best.empty());
  for (std::size_t i = 0; i < report.best.size(); ++i) {
    EXPECT_EQ(report.best[i].evaluation.all_faults(), 0);
    EXPECT_EQ(report.best[i].evaluation.all_tasks(), 2 * 260);
    const double before = i > 0 ? report.best[i - 1].evaluation.mean_time() : 0.0;
    EXPECT_LE(before, report.best[i].evaluation.mean_time());
  }
}

TEST(SimplexTest, ResultIsNotWorseThanTheInitialStrategy) {
  const StrategyProblem problem(two_scorbots());
  const TaskSet tasks = problem.draw(1, 100);
  SystemStrategy initial(2);
  initial[0].coefficients = {0.0, 1.0};
  initial[1].coefficients = {2.0, 1.0};
  SimplexOptions options;
  options.max_steps = 40;
  const SimplexResult result = refine_by_simplex(problem, tasks, initial, options);
  EXPECT_LE(result.steps, 40);
  EXPECT_LT(result.final.mean_time(), result.initial.mean_time());
  EXPECT_DOUBLE_EQ(evaluate(problem, tasks, result.strategy).mean_time(), result.final.mean_time());
}

TEST(StrategyProblemTest, RejectsCellsThatItCannotSimulate) {
  Cell cell = two_scorbots();
  cell.tasks.problem.areas.clear();
  EXPECT_THROW(StrategyProblem{cell}, ProblemError);
  cell = two_scorbots();
  cell.tasks.problem.areas.erase("robot2");
  EXPECT_THROW(StrategyProblem{cell}, ProblemError);
}

}  // namespace
}  // namespace hecaton::planner
