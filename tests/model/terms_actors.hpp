#pragma once
/// The five processes of a cell by the numbers of their states, and the transitions of each.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "tests/model/terms_messages.hpp"
#include "tests/model/terms_processes.hpp"

namespace hecaton::services::model {

using Number = std::uint16_t;

/// A process as an automaton. Each state that it was ever in has a number, and the real code is run once for each
/// transition. `Process`: key() contains all that its future depends on; sends() returns its messages in this state.
template <class Process>
class Automaton {
 public:
  /// `table` must outlive it.
  explicit Automaton(MessageTable& table) : table_(table) {}

  [[nodiscard]] Number number_of(const Process& process) {
    const auto [place, is_new] = numbers_.try_emplace(process.key(), static_cast<Number>(states_.size()));
    if (!is_new) return place->second;
    if (states_.size() == kUnknown) throw std::length_error("a process of the model has too many states");
    State& state = states_.emplace_back(State{process, {}, {}, {}, {}, {}});
    for (const Message& message : process.sends()) {
      const std::size_t number = table_.number_of(message);
      state.sends.push_back(number);
      if (number < MessageSet::kMost) state.sends_within.insert(number);
    }
    return place->second;
  }

  /// The state after a message or an action, each given by a number that always means the same. `change` applies it to
  /// a copy.
  template <class Change>
  [[nodiscard]] Number after_message(Number from, std::size_t message, const Change& change) {
    const Number to = after(from, message, change, &State::after_message);
    if (to == from && message < MessageSet::kMost) states_[from].ignores.insert(message);
    return to;
  }
  template <class Change>
  [[nodiscard]] Number after_action(Number from, std::size_t action, const Change& change) {
    return after(from, action, change, &State::after_action);
  }

  [[nodiscard]] const Process& operator[](Number number) const { return states_[number].process; }
  /// Numbers of messages.
  [[nodiscard]] const std::vector<std::size_t>& sends(Number number) const { return states_[number].sends; }
  [[nodiscard]] const MessageSet& sends_within(Number number) const { return states_[number].sends_within; }
  /// Messages that are known to change nothing.
  [[nodiscard]] const MessageSet& ignores(Number number) const { return states_[number].ignores; }

 private:
  static constexpr Number kUnknown = std::numeric_limits<Number>::max();
  struct State {
    Process process;
    std::vector<std::size_t> sends;
    MessageSet sends_within;
    MessageSet ignores;
    std::vector<Number> after_message, after_action;
  };

  template <class Change>
  Number after(Number from, std::size_t event, const Change& change, std::vector<Number> State::*memory) {
    const std::vector<Number>& known = states_[from].*memory;
    if (event < known.size() && known[event] != kUnknown) return known[event];
    Process process(states_[from].process);
    change(process);
    const Number to = number_of(process);
    std::vector<Number>& now_known = states_[from].*memory;
    if (now_known.size() <= event) now_known.resize(event + 1, kUnknown);
    return now_known[event] = to;
  }

  MessageTable& table_;
  std::unordered_map<std::string, Number> numbers_;  // by key
  std::deque<State> states_;
};

struct Processes {
  std::array<Number, 2> supervisors{};
  std::array<Number, 2> planners{};
  Number driver = 0;
  bool operator==(const Processes&) const = default;

  struct Hash {
    std::size_t operator()(const Processes& processes) const;
  };
};

/// The processes of the cell and their transitions. Messages are given by number.
class Actors {
 public:
  Actors(const Rules& rules, std::uint64_t highest_term);
  Actors(const Actors&) = delete;
  Actors& operator=(const Actors&) = delete;

  [[nodiscard]] Processes new_ones() const { return new_; }
  /// The supervisor that replaces one whose checkpoint has this term (at most the highest).
  [[nodiscard]] Number successor(std::size_t supervisor, std::size_t remembered) const {
    return successors_[supervisor].at(remembered);
  }

  /// Of a supervisor. An action that does not apply changes nothing.
  enum class Action : std::uint8_t { kMissesLeader, kDetectsAbsence, kGrants, kReplacesP, kReplacesQ };
  [[nodiscard]] Number supervisor_does(Number supervisor, Action action);
  [[nodiscard]] Number supervisor_receives(Number supervisor, std::size_t message);
  [[nodiscard]] Number planner_receives(Number planner, std::size_t message);
  [[nodiscard]] Number driver_receives(Number driver, std::size_t message);
  [[nodiscard]] Number driver_restarts(Number driver);

  [[nodiscard]] const Message& message(std::size_t number) const { return table_.message(number); }
  [[nodiscard]] const Automaton<SupervisorProcess>& supervisors() const { return supervisors_; }
  [[nodiscard]] const Automaton<PlannerProcess>& planners() const { return planners_; }
  [[nodiscard]] const Automaton<DriverProcess>& drivers() const { return drivers_; }

 private:
  SupervisorProcess::Time later();

  MessageTable table_;
  Automaton<SupervisorProcess> supervisors_{table_};
  Automaton<PlannerProcess> planners_{table_};
  Automaton<DriverProcess> drivers_{table_};
  Processes new_;
  std::array<std::vector<Number>, 2> successors_;  // by the term in the checkpoint
  SupervisorProcess::Time now_{0};
};

}  // namespace hecaton::services::model
