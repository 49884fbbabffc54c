#pragma once
/// A cell for exhaustive exploration: two supervisors, two planners of one arm, its driver, and a network that may
/// lose, delay, repeat and reorder messages. The decisions are those of the real code: Leadership, PlannerFailover,
/// CellModeView, FailoverRole, CommandGate (docs/explanation/0008-arm-leases.md).
///
/// Every message that was ever sent may arrive at any time, any number of times, or never. This covers partitions,
/// links of one direction and stopped processes. Only a leader that detects its own absence is an action of its own.
/// Deaths are actions because of what survives them: of a planner nothing; of a supervisor at most a cell term; of a
/// driver its lease when the process dies, and nothing when the host does.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/model/terms_actors.hpp"
#include "tests/model/terms_messages.hpp"
#include "tests/model/terms_processes.hpp"

namespace hecaton::services::model {

enum class Death : std::uint8_t {
  kSupervisor0,  ///< its checkpoint has the last cell term that it wrote, an older one, or none
  kSupervisor1,
  kPlanner,  ///< either
  kDriver,
  kDriverHost,
};

struct Bounds {
  std::uint64_t highest_term = 6;  ///< that a supervisor may take
  int most_deaths = 0;             ///< in all
  std::vector<Death> deaths{};     ///< kinds that happen
};

/// The state on which the future depends. What can happen in a state can also happen with the same processes, more
/// messages and fewer deaths.
struct Cell {
  Processes processes;
  MessageSet messages;  ///< all that were ever sent
  std::uint8_t deaths = 0;
  std::uint8_t returned = 0;  ///< a set of Returned; only coverage depends on it
};

/// Processes that replace dead ones.
enum Returned : std::uint8_t {
  kSupervisorWithCheckpoint = 1,     // of the other supervisor: the next bit
  kSupervisorWithoutCheckpoint = 4,  // likewise
  kPlannerReturned = 16,             // likewise
  kDriverWithCheckpoint = 64,
  kDriverWithoutCheckpoint = 128,
};

/// A transition of the cell.
struct Step {
  enum class Kind : std::uint8_t {
    kSupervisorReceives,
    kPlannerReceives,
    kDriverReceives,
    kBecomesLeader,
    kDetectsAbsence,
    kReplaces,
    kSupervisorDies,
    kPlannerDies,
    kDriverDies,
    kDriverHostDies,
  };
  Kind kind{};
  std::uint8_t who = 0;
  std::uint8_t what =
      0;  ///< receives: the message; replaces: the planner; a supervisor dies: the term in its checkpoint
};

class Model {
 public:
  Model(const Rules& rules, const Bounds& bounds) : actors_(rules, bounds.highest_term), bounds_(bounds) {}

  [[nodiscard]] Cell start() const;
  using Visit = std::function<void(const Cell& next, const Step& step)>;
  /// Visits the result of every action that changes something.
  void for_each_successor(const Cell& cell, const Visit& visit);

  /// A sentence about a forbidden motion of the arm; empty: there was none.
  [[nodiscard]] const std::string& violation(const Cell& cell) const;

  [[nodiscard]] Actors& actors() { return actors_; }
  [[nodiscard]] const Actors& actors() const { return actors_; }

 private:
  void receive(const Cell& cell, std::uint8_t who, const Visit& visit);
  void driver_receives(const Cell& cell, const Visit& visit);
  void decide(const Cell& cell, std::uint8_t who, const Visit& visit);
  void die(const Cell& cell, Death death, const Visit& visit);
  void supervisor_dies(const Cell& cell, std::uint8_t who, const Visit& visit);

  void supervisor_becomes(Number to, const Cell& cell, const Step& step, const Visit& visit) const;
  void planner_becomes(Number to, const Cell& cell, const Step& step, const Visit& visit) const;
  void driver_becomes(Number to, const Cell& cell, const Step& step, const Visit& visit) const;

  Actors actors_;
  Bounds bounds_;
};

[[nodiscard]] std::string text(const Step& step, const Actors& actors);

}  // namespace hecaton::services::model
