#pragma once
/// A process as an automaton: each state that it was ever in has a number, and the real code is asked only once what
/// becomes of it.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "tests/model/terms_letters.hpp"

namespace hecaton::services::model {

using Number = std::uint16_t;

/// `Process`: key() says all that its future depends on, tells() what it tells in this state.
template <class Process>
class Automaton {
 public:
  /// The post must outlive it.
  explicit Automaton(Post& post) : post_(post) {}

  [[nodiscard]] Number number_of(const Process& process) {
    const auto [place, is_new] = numbers_.try_emplace(process.key(), static_cast<Number>(states_.size()));
    if (!is_new) return place->second;
    if (states_.size() == kUnknown) throw std::length_error("a process of the model has too many states");
    State& state = states_.emplace_back(State{process, {}, {}, {}, {}, {}});
    for (const Letter& letter : process.tells()) {
      const std::size_t number = post_.number_of(letter);
      state.tells.push_back(number);
      if (number < Letters::kMost) state.tells_within.insert(number);
    }
    return place->second;
  }

  /// What becomes of it upon a letter, or something that it does, by number: the same must mean the same. `change` does
  /// it to a copy.
  template <class Change>
  [[nodiscard]] Number after_letter(Number from, std::size_t letter, const Change& change) {
    const Number to = after(from, letter, change, &State::after_letter);
    if (to == from && letter < Letters::kMost) states_[from].ignores.insert(letter);
    return to;
  }
  template <class Change>
  [[nodiscard]] Number after_deed(Number from, std::size_t deed, const Change& change) {
    return after(from, deed, change, &State::after_deed);
  }

  [[nodiscard]] const Process& operator[](Number number) const { return states_[number].process; }
  /// Letters by their numbers.
  [[nodiscard]] const std::vector<std::size_t>& tells(Number number) const { return states_[number].tells; }
  [[nodiscard]] const Letters& tells_within(Number number) const { return states_[number].tells_within; }
  /// Those that are known to change nothing.
  [[nodiscard]] const Letters& ignores(Number number) const { return states_[number].ignores; }

 private:
  static constexpr Number kUnknown = std::numeric_limits<Number>::max();
  struct State {
    Process process;
    std::vector<std::size_t> tells;
    Letters tells_within;
    Letters ignores;
    std::vector<Number> after_letter, after_deed;
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

  Post& post_;
  std::unordered_map<std::string, Number> numbers_;  // by key
  std::deque<State> states_;
};

}  // namespace hecaton::services::model
