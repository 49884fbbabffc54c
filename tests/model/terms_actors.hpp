#pragma once
/// The five processes of a cell by the numbers of their states, and what becomes of each.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/model/terms_automaton.hpp"
#include "tests/model/terms_letters.hpp"
#include "tests/model/terms_processes.hpp"

namespace hecaton::services::model {

struct Processes {
  std::array<Number, 2> supervisors{};
  std::array<Number, 2> planners{};
  Number driver = 0;
  bool operator==(const Processes&) const = default;

  struct Hash {
    std::size_t operator()(const Processes& processes) const;
  };
};

/// Letters are given by their numbers.
class Actors {
 public:
  Actors(const Rules& rules, std::uint64_t highest_term);
  Actors(const Actors&) = delete;
  Actors& operator=(const Actors&) = delete;

  [[nodiscard]] Processes new_ones() const { return new_; }
  /// In place of one that died with this term on its disk, at most the highest.
  [[nodiscard]] Number successor(std::size_t supervisor, std::size_t remembered) const {
    return successors_[supervisor].at(remembered);
  }

  /// Of a supervisor; nothing changes when it does not apply.
  enum class Deed : std::uint8_t { kLosesPatience, kComesBack, kGrants, kReplacesP, kReplacesQ };
  [[nodiscard]] Number supervisor_does(Number supervisor, Deed deed);
  [[nodiscard]] Number supervisor_hears(Number supervisor, std::size_t letter);
  [[nodiscard]] Number planner_hears(Number planner, std::size_t letter);
  [[nodiscard]] Number driver_hears(Number driver, std::size_t letter);
  [[nodiscard]] Number driver_restarts(Number driver);

  [[nodiscard]] const Letter& letter(std::size_t number) const { return post_.letter(number); }
  [[nodiscard]] const Automaton<SupervisorProcess>& supervisors() const { return supervisors_; }
  [[nodiscard]] const Automaton<PlannerProcess>& planners() const { return planners_; }
  [[nodiscard]] const Automaton<DriverProcess>& drivers() const { return drivers_; }

 private:
  SupervisorProcess::Time later();

  Post post_;
  Automaton<SupervisorProcess> supervisors_{post_};
  Automaton<PlannerProcess> planners_{post_};
  Automaton<DriverProcess> drivers_{post_};
  Processes new_;
  std::array<std::vector<Number>, 2> successors_;  // by the term on the disk
  SupervisorProcess::Time now_{0};
};

}  // namespace hecaton::services::model
