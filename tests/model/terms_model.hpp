#pragma once
/// A cell for exhaustive exploration: two supervisors, two planners of one arm, its driver, and a network that may
/// lose, delay, repeat and reorder whatever it likes. What the processes decide is the real code: Leadership,
/// Succession, CellModeView, Duty, CommandGate (docs/design/0008-terms.md).
///
/// Whatever was ever sent may arrive at any time, any number of times, or never. So there is nothing to model for a
/// partition, a link of one direction, or a process that is stopped and goes on: it is not delivered to, then it is.
/// Only death is an action of its own, for it loses memory.

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "services/arm_driver/command_gate.hpp"
#include "services/planner/duty.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/supervisor/leadership.hpp"
#include "services/supervisor/succession.hpp"

namespace hecaton::services::model {

/// What a mutant leaves out.
struct Rules {
  bool gate = true;            ///< the driver looks at terms at all
  bool binding = true;         ///< the driver gives each term to one planner
  bool unique_terms = true;    ///< supervisors share the terms out
  bool driver_proves = true;   ///< supervisors and planners learn from the driver what it goes by
  bool planners_prove = true;  ///< supervisors learn from planners what these were granted
};

struct Bounds {
  std::uint64_t highest_term = 6;  ///< no higher one is taken
  int deaths = 1;                  ///< of any process, together
};

/// Something that was sent.
struct Letter {
  enum class Kind : std::uint8_t { kMode, kCommand, kState };
  Kind kind{};
  std::uint8_t sender = 0;   ///< of a mode: the supervisor
  std::uint8_t term = 0;     ///< of a mode: the cell's
  std::uint8_t granted = 0;  ///< term of the mandate that it tells, or commands under
  std::uint8_t planner = 0;  ///< whose mandate it is: 0, 1, or kNobody

  [[nodiscard]] auto fields() const { return std::make_tuple(kind, sender, term, granted, planner); }
  bool operator==(const Letter& other) const { return fields() == other.fields(); }
  bool operator<(const Letter& other) const { return fields() < other.fields(); }

  static constexpr std::uint8_t kNobody = 2;
};

class Cell {
 public:
  Cell(const Rules& rules, const Bounds& bounds);

  using Visit = std::function<void(Cell&& next, const std::string& what)>;
  /// Every action that is possible now.
  void for_each_successor(const Visit& visit) const;

  /// What has happened that must not, a sentence; empty when all is well.
  [[nodiscard]] const std::string& violation() const { return violation_; }
  /// What its future depends on: the processes, and what was ever sent. Whatever can happen can also happen when the
  /// processes are the same and more was sent.
  [[nodiscard]] std::string processes() const;
  [[nodiscard]] const std::vector<Letter>& letters() const { return letters_; }  ///< sorted

  /// −1: none of them.
  struct Dead {
    int supervisor = -1;
    int planner = -1;
  };
  /// From now on nothing fails any more and the network is quick, but these stay dead. What is wrong after some rounds;
  /// empty: one supervisor leads, one planner is in charge, and the driver follows it.
  [[nodiscard]] std::string wrong_after_calm(const Dead& dead) const;

 private:
  struct SupervisorProcess {
    Leadership leadership;
    Succession succession;
    std::uint64_t memory = 0;  // on its disk: the last term under which it led
  };
  struct PlannerProcess {
    CellModeView view;
    Duty duty;
  };
  struct DriverProcess {
    CellModeView view;
    CommandGate gate{1};
  };

  [[nodiscard]] SupervisorProcess born_supervisor(int i, std::uint64_t memory) const;
  [[nodiscard]] static PlannerProcess born_planner(int j);
  [[nodiscard]] bool leads(int i) const;
  [[nodiscard]] Letter mode_of(int i) const;
  [[nodiscard]] Letter command_of(int j) const;
  [[nodiscard]] Letter driver_state() const;
  [[nodiscard]] std::array<std::uint64_t, 3> followed_terms() const;

  void send();
  void supervisor_hears(int i, const Letter& letter, Leadership::Time at);
  void planner_hears(int j, const Letter& letter);
  void driver_hears(const Letter& letter);
  void driver_follows(const Letter& command);
  void decide(int i, Leadership::Time now);
  void grant(int i, int out);
  void deaths(const Visit& visit) const;
  void calm_round(const Dead& dead, Leadership::Time now);
  void step(const Visit& visit, const std::string& what, const std::function<void(Cell&)>& action) const;

  Rules rules_;
  Bounds bounds_;
  std::array<SupervisorProcess, 2> supervisors_;
  std::array<PlannerProcess, 2> planners_;
  DriverProcess driver_;
  int deaths_ = 0;
  std::vector<Letter> letters_;  // all that were ever sent, sorted

  // The model's own account of the driver, by which the gate is judged.
  Letter followed_;          // the last command that moved the arm; granted 0: none yet
  std::uint8_t proved_ = 0;  // the highest term of a mandate that the driver was shown
  std::string violation_;
};

}  // namespace hecaton::services::model
