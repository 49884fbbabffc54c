#include "services/cli/strategy_ranks.hpp"

#include <algorithm>
#include <optional>
#include <sstream>
#include <thread>

#include "planner/strategy_search/as_text.hpp"
#include "services/cli/failure.hpp"

namespace hecaton::services::cli {
int StrategyRanks::threads() const {
  const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return ranks_ ? std::max(1, processors / ranks_->on_host()) : processors;
}

void StrategyRanks::together(const std::function<void()>& work) {
  if (!ranks_) return work();
  std::string trouble;
  ExitCode code = ExitCode::kBadInput;
  try {
    work();
  } catch (const Failure& failure) {
    trouble = failure.what();
    code = failure.code();
  } catch (const std::exception& error) {
    trouble = error.what();
  }
  const std::vector<std::string> all = ranks_->all_of(trouble);
  const auto failed = std::find_if(all.begin(), all.end(), [](const std::string& text) { return !text.empty(); });
  if (failed == all.end()) return;
  if (!first()) throw Failure(code, "");
  const std::string who = failed == all.begin() ? "" : "rank " + std::to_string(failed - all.begin()) + ": ";
  throw Failure(code, who + *failed);
}

void StrategyRanks::require_same(const std::string& what) {
  if (!ranks_) return;
  const std::vector<std::string> all = ranks_->all_of(what);
  const auto other = std::find_if(all.begin(), all.end(), [&](const std::string& text) { return text != all[0]; });
  if (other == all.end()) return;
  if (!first()) throw Failure(ExitCode::kBadInput, "");
  throw Failure(ExitCode::kBadInput, "rank " + std::to_string(other - all.begin()) +
                                         " has another cell file, other options or another version than rank 0");
}

void StrategyRanks::divide(planner::SearchHooks& hooks) {
  if (!ranks_) return;
  hooks.part = ranks_->rank();
  hooks.parts = ranks_->count();
  evaluated_ = std::move(hooks.evaluated);
  hooks.evaluated = [this](const planner::Round& round, std::size_t index, std::size_t all,
                           const planner::Evaluation& evaluation) {
    if (!first()) return ranks_->tell_first(std::to_string(index) + ' ' + text_of(evaluation));
    if (!in_round_) {
      in_round_ = true;
      round_ = round;
      all_ = all;
      missing_ = all - own_count(all);
    }
    evaluated_(round, index, all, evaluation);
    while (hear(false)) continue;
  };
  hooks.share = [this](std::vector<std::string>& texts) {
    while (in_round_ && missing_ > 0) hear(true);
    in_round_ = false;
    exchange(texts);
  };
}

std::size_t StrategyRanks::own_count(std::size_t all) const {
  const auto parts = static_cast<std::size_t>(ranks_->count());
  return (all + parts - 1 - static_cast<std::size_t>(ranks_->rank())) / parts;
}

bool StrategyRanks::hear(bool wait) {
  const std::optional<std::string> told = ranks_->told(wait);
  if (!told) return false;
  --missing_;
  const std::size_t cut = told->find(' ');
  const std::optional<planner::Evaluation> evaluation = planner::evaluation_of(told->substr(cut + 1));
  if (evaluation) evaluated_(round_, std::stoul(told->substr(0, cut)), all_, *evaluation);
  return true;
}

void StrategyRanks::exchange(std::vector<std::string>& texts) {
  const auto parts = static_cast<std::size_t>(ranks_->count());
  std::string own;
  for (auto i = static_cast<std::size_t>(ranks_->rank()); i < texts.size(); i += parts) own += texts[i] + '\n';
  const std::vector<std::string> all = ranks_->all_of(own);
  for (std::size_t part = 0; part < parts; ++part) {
    std::istringstream lines(all[part]);
    for (std::size_t i = part; i < texts.size(); i += parts) std::getline(lines, texts[i]);
  }
}

}  // namespace hecaton::services::cli
