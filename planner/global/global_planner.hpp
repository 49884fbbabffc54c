#pragma once
/// The interface of a global planner: a path between two configurations. docs/how-to/add-a-global-planner.md leads
/// through it; planner/global/registry.cpp lists the planners.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planner/global/space.hpp"
#include "planner/global/validity.hpp"

namespace hecaton::planner::global {

enum class PlanStatus {
  kSolved,
  kStartInvalid,
  kGoalInvalid,
  kBudgetEnded,
  kStuck,  ///< more time would not help: a planner that does not search cannot go on
};

/// When a search gives up.
struct Budget {
  std::uint64_t iterations = 1'000'000;  ///< samples drawn
  std::function<bool()> ended;  ///< asked every now and then; empty: never. Has the clock that planners have not
};

/// How straight ways are looked at.
struct EdgeCheck {
  int finer = 1;           ///< at so many times as many configurations as the validity says
  bool proven = false;     ///< and then everywhere in between (Validity::proven_free)
  double clearance = 0.0;  ///< proven only: kept from the world beyond the validity's padding [m]

  [[nodiscard]] bool free(const Validity& validity, const float* a, const float* b) const {
    return validity.edge_free(a, b, finer) && (!proven || validity.proven_free(a, b, clearance));
  }
};

/// What a search has built, for pictures.
struct SearchRecord {
  Points nodes;
  std::vector<std::pair<int, int>> edges;  ///< of nodes
};

/// References and pointers are valid during the search. Points are `space.stride` floats [rad | m].
struct SearchProblem {
  const Validity& validity;
  const Space& space;
  const float* start;  ///< free
  const float* goal;   ///< free
  std::uint64_t seed = 1;
  Budget budget = {};
  EdgeCheck check = {};
  SearchRecord* record = nullptr;  ///< filled at the end of a search; null: not

  [[nodiscard]] bool edge_free(const float* a, const float* b) const { return check.free(validity, a, b); }

  /// Whether a search has to give up after so many samples. The budget is asked by how much has been looked at, too:
  /// with fine steps one sample may take longer than a thousand otherwise.
  [[nodiscard]] bool over(std::uint64_t iteration) const {
    if (ended || iteration >= budget.iterations) return true;
    if (!budget.ended || (iteration % 64 != 63 && validity.checks() - asked_at < kChecksUnasked)) return false;
    asked_at = validity.checks();
    ended = budget.ended();
    return ended;
  }

  static constexpr std::uint64_t kChecksUnasked = 8192;  ///< some ms at most
  mutable std::uint64_t asked_at = 0;                    ///< checks when the budget was asked
  mutable bool ended = false;
};

/// A path, or why there is none.
struct SearchResult {
  PlanStatus status = PlanStatus::kBudgetEnded;  ///< this, kSolved or kStuck
  std::string reason = {};                       ///< of kStuck: one sentence without a full stop
  Points path = Points();                        ///< start … goal; every straight way between two is free
  std::uint64_t iterations = 0;                  ///< samples drawn
  int nodes = 0;                                 ///< of all trees, or of the roadmap

  [[nodiscard]] bool solved() const { return status == PlanStatus::kSolved; }
};

struct PlannerTraits {
  std::string_view name;     ///< on the command line and in reports
  std::string_view summary;  ///< one phrase, for lists
};

/// Immutable: threads share a planner. plan() (planner/global/plan.hpp) checks start and goal, proves and shortens the
/// path; a planner only searches.
class GlobalPlanner {
 public:
  explicit GlobalPlanner(const PlannerTraits& traits) : traits_(traits) {}
  virtual ~GlobalPlanner() = default;

  [[nodiscard]] const PlannerTraits& traits() const { return traits_; }

  /// Looks at straight ways by problem.edge_free() alone, and gives up soon after problem.over(). All random choices
  /// come from problem.seed: the same problem has the same result, to the last bit. No clock, log or network.
  /// Thread-safe for problems that share no validity.
  [[nodiscard]] virtual SearchResult search(const SearchProblem& problem) const = 0;

 private:
  PlannerTraits traits_;
};

}  // namespace hecaton::planner::global
