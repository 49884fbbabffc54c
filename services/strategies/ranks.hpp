#pragma once
/// A search for strategies by several processes (`mpirun hecaton-strategies search …`): each evaluates its part of the
/// candidates, all get all results, and the first keeps the files and writes to the user.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "planner/strategy_search/search.hpp"

namespace hecaton::services::cli {

/// The processes that mpirun started together, perhaps on several machines, as one of them sees them. Not for two
/// threads at a time. An error of MPI ends all of them, with a message of its own.
class Ranks {
 public:
  /// Alone, without MPI, unless mpirun started this process.
  Ranks();
  /// Waits until the other processes end theirs, too.
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] bool first() const;
  [[nodiscard]] bool alone() const { return mpi_ == nullptr; }
  [[nodiscard]] int count() const;
  /// Processors of this machine for this rank: those that it may use, shared with its neighbours.
  [[nodiscard]] int threads() const;

  /// Does the same work on every rank, and when it throws on any, throws a Failure on all: one that says what happened
  /// on the first, without words on others.
  void together(const std::function<void()>& work);
  /// Throws such a Failure unless `what` is the same everywhere.
  void require_same(const std::string& what);
  /// The first rank's text.
  [[nodiscard]] std::string first_of(const std::string& own);

  /// Divides the work. `hooks` as it would be alone; `evaluated` in it gets all evaluations, on the first rank.
  void divide(planner::SearchHooks& hooks);

 private:
  class Mpi;
  using Evaluated = std::function<void(const planner::Round&, std::size_t, std::size_t, const planner::Evaluation&)>;
  [[nodiscard]] std::size_t own_count(std::size_t all) const;
  /// Passes on one evaluation of another rank; whether there was one.
  bool receive(bool wait);
  /// Fills in what is missing.
  void exchange(std::vector<std::string>& texts);

  std::unique_ptr<Mpi> mpi_;
  Evaluated evaluated_;
  bool in_round_ = false;
  planner::Round round_;     ///< the present one
  std::size_t all_ = 0;      ///< candidates in it
  std::size_t missing_ = 0;  ///< of other ranks, not received yet
};

}  // namespace hecaton::services::cli
