#pragma once
/// A search for strategies by several processes (`mpirun hecaton strategies search …`): each evaluates its part of the
/// candidates, all get all results, and the first keeps the files and tells people.

#include <functional>
#include <memory>
#include <string>

#include "planner/strategy_search/search.hpp"
#include "services/cli/ranks.hpp"

namespace hecaton::services::cli {

class StrategyRanks {
 public:
  /// Alone unless mpirun started this process. Throws Failure as join_ranks() does.
  StrategyRanks() : ranks_(join_ranks()) {}

  [[nodiscard]] bool first() const { return !ranks_ || ranks_->rank() == 0; }
  [[nodiscard]] bool alone() const { return !ranks_; }
  [[nodiscard]] int count() const { return ranks_ ? ranks_->count() : 1; }
  /// Processors of this machine for this rank: those that it may use, shared with its neighbours.
  [[nodiscard]] int threads() const;

  /// Does the same work on every rank, and when it throws on any, throws a Failure on all: one that says what happened
  /// on the first, without words on others.
  void together(const std::function<void()>& work);
  /// Throws such a Failure unless `what` is the same everywhere.
  void require_same(const std::string& what);
  /// The first rank's text.
  [[nodiscard]] std::string first_of(const std::string& own) { return ranks_ ? ranks_->first_of(own) : own; }

  /// Divides the work. `hooks` as it would be alone; `evaluated` in it is told of all evaluations, on the first rank.
  void divide(planner::SearchHooks& hooks);

 private:
  using Evaluated = std::function<void(const planner::Round&, std::size_t, std::size_t, const planner::Evaluation&)>;
  [[nodiscard]] std::size_t own_count(std::size_t all) const;
  /// One evaluation of another rank, passed on; whether there was one.
  bool hear(bool wait);
  /// Fills in what is missing.
  void exchange(std::vector<std::string>& texts);

  std::unique_ptr<Ranks> ranks_;
  Evaluated evaluated_;
  bool in_round_ = false;
  planner::Round round_;     ///< the present one
  std::size_t all_ = 0;      ///< candidates in it
  std::size_t missing_ = 0;  ///< of other ranks, not heard of yet
};

}  // namespace hecaton::services::cli
