#include "services/cli/strategy_progress.hpp"

#include <sstream>

#include <unistd.h>

#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"

namespace hecaton::services::cli {
namespace {

constexpr auto kRedraw = std::chrono::milliseconds(200);

/// What a file's evaluations depend on: another of it, another search.
std::string title_of(const planner::StrategyProblem& problem, const planner::SearchPlan& plan,
                     const planner::StrategyGrid& grid) {
  std::ostringstream out;
  out.precision(17);
  out << "hecaton strategies, seed " << plan.seed << ", tasks " << plan.screening_tasks << ' ' << plan.confirm_tasks
      << ' ' << plan.confirm_sets << ", complete " << plan.complete << ", halving " << plan.halving << ", refine "
      << plan.refine << ", alpha";
  for (const double value : grid.alpha) out << ' ' << value;
  out << ", beta";
  for (const double value : grid.beta) out << ' ' << value;
  // Of the problem, what its first tasks are says nearly all.
  const planner::TaskSet tasks = problem.draw(plan.seed, 2);
  out << ", problem " << problem.flat().boxes << ' ' << problem.flat().step << ' ' << problem.flat().distance;
  for (int arm = 0; arm < problem.arms(); ++arm) {
    const planner::FlatArm& flat = problem.flat().arm[arm];
    double mixed = flat.bodies + tasks.waits[arm].front();
    for (const double value : tasks.goals[arm]) mixed = 0.7 * mixed + value;
    for (int i = 0; i < flat.bodies; ++i) mixed = 0.7 * mixed + flat.body[i].radius + flat.body[i].p[0];
    for (int j = 0; j < flat.joints; ++j) mixed = 0.7 * mixed + flat.joint[j].p[0] + flat.joint[j].p[2];
    out << ' ' << problem.name_of(arm) << ' ' << mixed;
  }
  return out.str();
}

}  // namespace

StrategyProgress::StrategyProgress(const std::string& path, bool resume, const planner::StrategyProblem& problem,
                                   const planner::SearchPlan& plan, const planner::StrategyGrid& grid)
    : terminal_(isatty(STDERR_FILENO) != 0) {
  if (path.empty()) return;
  const std::string title = title_of(problem, plan, grid);
  if (resume) read(path, title);
  file_.open(path, std::ios::trunc);
  file_.precision(17);
  file_ << title << '\n';
  if (!file_) throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be written");
}

void StrategyProgress::read(const std::string& path, const std::string& title) {
  std::ifstream file(path);
  std::string line;
  if (!file) throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be read, so nothing can be resumed");
  if (!std::getline(file, line) || line != title) {
    throw Failure(ExitCode::kBadInput, path + " is of another search, or of another cell: it cannot be resumed");
  }
  while (std::getline(file, line)) {
    std::istringstream words(line);
    Key key;
    planner::Evaluation evaluation;
    std::size_t arms = 0;
    words >> key.first >> key.second >> evaluation.complete >> evaluation.arm_ticks >> arms;
    for (std::size_t i = 0; i < arms && words; ++i) {
      std::int64_t tasks = 0;
      std::int64_t faults = 0;
      double time = 0.0;
      double time2 = 0.0;
      words >> tasks >> faults >> time >> time2;
      evaluation.tasks.push_back(tasks);
      evaluation.faults.push_back(faults);
      evaluation.time.push_back(time);
      evaluation.time2.push_back(time2);
    }
    std::string end;
    words >> end;
    if (end == ".") known_[key] = std::move(evaluation);  // a line that was cut off is evaluated again
  }
}

void StrategyProgress::hook(planner::SearchHooks& hooks) {
  hooks.known = [this](const planner::Round& round, std::size_t index) {
    const auto found = known_.find({round.seed, index});
    return found == known_.end() ? nullptr : &found->second;
  };
  hooks.evaluated = [this](const planner::Round& round, std::size_t index, std::size_t all,
                           const planner::Evaluation& evaluation) {
    if (file_.is_open()) {
      file_ << round.seed << ' ' << index << ' ' << evaluation.complete << ' ' << evaluation.arm_ticks << ' '
            << evaluation.tasks.size();
      for (std::size_t i = 0; i < evaluation.tasks.size(); ++i) {
        file_ << ' ' << evaluation.tasks[i] << ' ' << evaluation.faults[i] << ' ' << evaluation.time[i] << ' '
              << evaluation.time2[i];
      }
      file_ << " .\n";
    }
    show(round, all);
  };
}

void StrategyProgress::show(const planner::Round& round, std::size_t all) {
  const auto now = std::chrono::steady_clock::now();
  if (round.seed != seed_ || done_ == 0) {
    seed_ = round.seed;
    done_ = 0;
    began_ = now;
    shown_ = now;
  }
  ++done_;
  if (!terminal_ || (now - shown_ < kRedraw && done_ != all)) return;
  shown_ = now;
  if (file_.is_open()) file_.flush();
  constexpr std::size_t kWidth = 30;
  const std::chrono::duration<double> spent = now - began_;
  const double left = spent.count() / static_cast<double>(done_) * static_cast<double>(all - done_);
  const std::string bar(kWidth * done_ / all, '#');
  std::fprintf(stderr, "\r%-12s [%-30s] %zu of %zu, %s left \x1b[K", round.name.c_str(), bar.c_str(), done_, all,
               duration_text(left).c_str());
}

void StrategyProgress::end() {
  if (terminal_ && done_ > 0) std::fputs("\r\x1b[K", stderr);
}

}  // namespace hecaton::services::cli
