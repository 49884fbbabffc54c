#include "services/strategies/progress.hpp"

#include <bit>
#include <sstream>

#include <unistd.h>

#include "planner/model/fnv1a.hpp"
#include "services/command_line/failure.hpp"
#include "services/command_line/quantities.hpp"

namespace hecaton::services::cli {
namespace {

constexpr auto kRedraw = std::chrono::milliseconds(200);
constexpr auto kNextLine = std::chrono::seconds(5);

/// Over the bits of what is added.
class Fingerprint {
 public:
  void add(double value) {
    std::uint64_t bits = std::bit_cast<std::uint64_t>(value + 0.0);  // −0 is 0
    for (int byte = 0; byte < 8; ++byte, bits >>= 8U) hash_.add(bits & 0xFFU);
  }
  template <std::size_t N>
  void add(const double (&values)[N]) {
    for (const double value : values) add(value);
  }
  [[nodiscard]] std::uint64_t value() const { return hash_.value(); }

 private:
  planner::Fnv1a hash_;
};

/// Of all that is simulated, and of the tasks that are drawn first: they tell whether another machine draws the same.
std::uint64_t fingerprint(const planner::StrategyProblem& problem, const planner::SearchPlan& plan,
                          const std::vector<planner::SystemStrategy>& candidates) {
  Fingerprint print;
  for (const planner::SystemStrategy& candidate : candidates) {
    for (int arm = 0; arm < problem.arms(); ++arm) {
      print.add(candidate[arm].direction);
      for (int k = 0; k < problem.coefficients(arm); ++k) print.add(candidate[arm].coefficients[k]);
    }
  }
  const planner::FlatProblem& flat = problem.flat();
  for (const double value : {flat.step, flat.distance, flat.self_distance, static_cast<double>(flat.timeout_factor),
                             static_cast<double>(flat.basis), static_cast<double>(flat.nearest_first)})
    print.add(value);
  for (int i = 0; i < flat.boxes; ++i) {
    print.add(flat.box[i].R);
    print.add(flat.box[i].c);
    print.add(flat.box[i].half);
  }
  const planner::TaskSet tasks = problem.draw(plan.seed, plan.screening_tasks);
  for (int i = 0; i < problem.arms(); ++i) {
    const planner::FlatArm& arm = flat.arm[i];
    for (int j = 0; j < arm.joints; ++j) {
      print.add(arm.joint[j].R);
      print.add(arm.joint[j].p);
      for (const double value : {arm.joint[j].lower, arm.joint[j].upper}) print.add(value);
    }
    for (int k = 0; k < arm.bodies; ++k) {
      print.add(arm.body[k].p);
      print.add(arm.body[k].d);
      print.add(arm.body[k].radius);
    }
    for (const double value : tasks.goals[i]) print.add(value);
    for (const double value : tasks.starts[i]) print.add(value);
    for (const std::int32_t value : tasks.waits[i]) print.add(value);
  }
  return print.value();
}

}  // namespace

std::string search_title(const planner::StrategyProblem& problem, const planner::SearchPlan& plan,
                         const std::vector<planner::SystemStrategy>& candidates) {
  std::ostringstream out;
  out.precision(17);
  out << "hecaton-strategies, seed " << plan.seed << ", tasks " << plan.screening_tasks << ' ' << plan.confirm_tasks
      << ' ' << plan.confirm_sets << ", complete " << plan.complete << ", halving " << plan.halving << ", refine "
      << plan.refine << ", strategies " << candidates.size();
  out << ", arms";
  for (int arm = 0; arm < problem.arms(); ++arm) out << ' ' << problem.name_of(arm);
  out << ", problem " << std::hex << fingerprint(problem, plan, candidates);
  return out.str();
}

std::string search_so_far(const std::string& path, const std::string& title) {
  std::ifstream file(path);
  std::string line;
  if (!file) throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be read, so nothing can be resumed");
  if (!std::getline(file, line) || line != title) {
    throw Failure(ExitCode::kBadInput, path + " is of another search, or of another cell: it cannot be resumed");
  }
  std::ostringstream rest;
  rest << file.rdbuf();
  return rest.str();
}

StrategyProgress::StrategyProgress() : terminal_(isatty(STDERR_FILENO) != 0) {}

void StrategyProgress::keep(const std::string& path, const std::string& title) {
  file_.open(path, std::ios::trunc);
  file_ << title << '\n';
  file_.flush();
  if (!file_) throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be written");
}

void StrategyProgress::know(const std::string& so_far) {
  std::istringstream lines(so_far);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    Key key;
    std::string text;
    if (!(words >> key.first >> key.second) || !std::getline(words, text)) continue;
    // A line that was cut off is evaluated again.
    if (const auto evaluation = planner::evaluation_of(text)) known_[key] = *evaluation;
  }
}

void StrategyProgress::hook(planner::SearchHooks& hooks) {
  hooks.known = [this](const planner::Round& round, std::size_t index) {
    const auto found = known_.find({round.seed, index});
    return found == known_.end() ? nullptr : &found->second;
  };
  hooks.evaluated = [this](const planner::Round& round, std::size_t index, std::size_t all,
                           const planner::Evaluation& evaluation) {
    if (file_.is_open()) file_ << round.seed << ' ' << index << ' ' << planner::text_of(evaluation) << '\n';
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
    said_ = now;
  }
  ++done_;
  if (now - shown_ < kRedraw && done_ != all) return;
  shown_ = now;
  if (file_.is_open()) file_.flush();
  if (!terminal_ && !(lines_ && now - said_ >= kNextLine)) return;
  said_ = now;
  constexpr std::size_t kWidth = 30;
  const std::chrono::duration<double> spent = now - began_;
  const double left = spent.count() / static_cast<double>(done_) * static_cast<double>(all - done_);
  const std::string bar(kWidth * done_ / all, '#');
  std::fprintf(stderr, "%s%-12s [%-30s] %zu of %zu, %s left%s", terminal_ ? "\r" : "", round.name.c_str(), bar.c_str(),
               done_, all, duration_text(left).c_str(), terminal_ ? " \x1b[K" : "\n");
}

void StrategyProgress::end() {
  if (terminal_ && done_ > 0) std::fputs("\r\x1b[K", stderr);
}

}  // namespace hecaton::services::cli
