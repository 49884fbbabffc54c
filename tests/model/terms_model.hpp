#pragma once
/// A cell for exhaustive exploration: two supervisors, two planners of one arm, its driver, and a network that may
/// lose, delay, repeat and reorder whatever it likes. What the processes decide is the real code: Leadership,
/// PlannerFailover, CellModeView, Duty, CommandGate (docs/design/0008-terms.md).
///
/// Whatever was ever told may arrive at any time, any number of times, or never. So there is nothing to model for a
/// partition, a link of one direction, or a process that is stopped and goes on, but that a leading supervisor finds
/// out: it is not delivered to, then it is. Deaths are actions of their own, for what they leave of memories: of a
/// planner's nothing, of a supervisor's at most a cell term, of a driver's its mandate when its process dies and
/// nothing when its host does.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/model/terms_actors.hpp"
#include "tests/model/terms_letters.hpp"
#include "tests/model/terms_processes.hpp"

namespace hecaton::services::model {

enum class Death : std::uint8_t {
  kSupervisor0,  ///< leaves on its disk the last cell term that it wrote there, an older one, or none
  kSupervisor1,
  kPlanner,  ///< either
  kDriver,
  kDriverHost,
};

struct Bounds {
  std::uint64_t highest_term = 6;  ///< no higher one is taken
  int most_deaths = 0;             ///< together
  std::vector<Death> deaths{};     ///< that happen
};

/// What its future depends on. Whatever can happen can also happen when the processes are the same, more was told, and
/// fewer have died.
struct Cell {
  Processes processes;
  Letters letters;  ///< all that were ever told
  std::uint8_t deaths = 0;
  std::uint8_t returned = 0;  ///< who did, a set of Returned; nothing depends on it
};

/// Whoever is in the place of one that died.
enum Returned : std::uint8_t {
  kSupervisorWithMemory = 1,     // of the other supervisor: the next bit
  kSupervisorWithoutMemory = 4,  // likewise
  kPlannerAnew = 16,             // likewise
  kDriverWithMemory = 64,
  kDriverWithoutMemory = 128,
};

/// What happened.
struct Step {
  enum class Kind : std::uint8_t {
    kSupervisorHears,
    kPlannerHears,
    kDriverHears,
    kTakesOver,
    kComesBack,
    kReplaces,
    kSupervisorDies,
    kPlannerDies,
    kDriverDies,
    kDriverHostDies,
  };
  Kind kind{};
  std::uint8_t who = 0;
  std::uint8_t what = 0;  ///< hears: the letter; replaces: the planner; a supervisor dies: the term on its disk
};

class Model {
 public:
  Model(const Rules& rules, const Bounds& bounds) : actors_(rules, bounds.highest_term), bounds_(bounds) {}

  [[nodiscard]] Cell start() const;
  using Visit = std::function<void(const Cell& next, const Step& step)>;
  /// Every action that changes something.
  void for_each_successor(const Cell& cell, const Visit& visit);

  /// What the arm did that it must not, a sentence; empty when all is well.
  [[nodiscard]] const std::string& violation(const Cell& cell) const;

  [[nodiscard]] Actors& actors() { return actors_; }
  [[nodiscard]] const Actors& actors() const { return actors_; }

 private:
  void hear(const Cell& cell, std::uint8_t who, const Visit& visit);
  void driver_hears(const Cell& cell, const Visit& visit);
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
