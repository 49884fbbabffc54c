#pragma once
/// Execution of a strategy search: its processes (`mpirun hecaton-strategies search …`) and its progress.

#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "planner/strategy_search/search.hpp"
#include "services/command_line/long_work.hpp"

namespace hecaton::services::cli {

/// The processes of one mpirun, possibly on several machines, as seen by one of them. Each evaluates a part of the
/// candidates; all get all results; rank 0 writes files and output. Not thread-safe. An MPI error ends all processes.
class Ranks {
 public:
  /// Uses MPI only if mpirun started this process.
  Ranks();
  /// Waits for the other processes.
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] bool first() const;
  [[nodiscard]] bool alone() const { return mpi_ == nullptr; }
  [[nodiscard]] int count() const;
  /// Threads for this rank: the processors of the machine, divided among its ranks.
  [[nodiscard]] int threads() const;

  /// Runs `work` on all ranks. If it throws on any, throws Failure on all: with the message on rank 0, without on
  /// others.
  void together(const std::function<void()>& work);
  /// Throws such a Failure unless `text` is the same on all ranks.
  void require_same(const std::string& text);
  /// The text of rank 0.
  [[nodiscard]] std::string broadcast(const std::string& own);

  /// Changes hooks of a single process to those of this rank. On rank 0, hooks.evaluated gets the evaluations of all
  /// ranks.
  void divide(planner::SearchHooks& hooks);

 private:
  class Mpi;
  using Evaluated = std::function<void(const planner::Round&, std::size_t, std::size_t, const planner::Evaluation&)>;
  [[nodiscard]] std::size_t own_count(std::size_t all) const;
  /// Passes one evaluation of another rank to evaluated_. Returns false if there was none.
  bool receive(bool wait);
  /// Fills in the texts of the other ranks.
  void exchange(std::vector<std::string>& texts);

  std::unique_ptr<Mpi> mpi_;
  Evaluated evaluated_;
  bool in_round_ = false;
  planner::Round round_;     ///< the present round
  std::size_t all_ = 0;      ///< candidates in it
  std::size_t missing_ = 0;  ///< evaluations of other ranks, not received yet
};

/// One line that identifies a search: all options and the motion problem on which its evaluations depend.
[[nodiscard]] std::string search_title(const planner::StrategyProblem& problem, const planner::SearchPlan& plan,
                                       const std::vector<planner::SystemStrategy>& candidates);
/// The evaluations in the progress file of an interrupted search, as text. Throws Failure if the file is of another
/// search.
[[nodiscard]] std::string read_progress(const std::string& path, const std::string& title);

/// Progress of a search: on stderr, and in a file from which the search can resume.
class StrategyProgress {
 public:
  /// `lines`: also prints a line from time to time if stderr is not a terminal, as under mpirun.
  explicit StrategyProgress(bool lines);
  /// Writes evaluations to this file as well. Throws Failure if it cannot be written.
  void write_to(const std::string& path, const std::string& title);
  /// Reuses the evaluations of read_progress(), and keeps them in the file.
  void reuse(const std::string& evaluations);

  /// Installs the hooks.
  void hook(planner::SearchHooks& hooks);
  /// Clears the progress on stderr. The file has all evaluations so far.
  void end();

  /// Evaluations in the present round.
  [[nodiscard]] std::size_t done() const { return done_; }

 private:
  using Key = std::pair<std::uint64_t, std::size_t>;  ///< seed of the round, index
  void show(const planner::Round& round, std::size_t all);

  std::ofstream file_;
  std::map<Key, planner::Evaluation> known_;
  Progress progress_;
  std::uint64_t seed_ = 0;  ///< of the present round
  std::size_t done_ = 0;
  std::chrono::steady_clock::time_point flushed_;
};

}  // namespace hecaton::services::cli
