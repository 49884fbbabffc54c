#pragma once
/// Explores every reachable state of a model and checks each.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "tests/model/terms_model.hpp"
#include "tests/model/terms_recovery.hpp"

namespace hecaton::services::model {

struct Finding {
  std::string wrong;                            ///< a sentence; empty: nothing
  std::vector<std::string> trace;               ///< steps that lead there
  std::size_t states = 0;                       ///< that were explored
  std::size_t combinations = 0;                 ///< of states of the processes: each was checked
  std::map<std::string, std::size_t> coverage;  ///< how often each notable step was taken
};

/// Of two states with the same processes only the one with more messages and fewer deaths is explored: it can do
/// whatever the other can, and the check of both gives the same. States with the fewest deaths come first, and of them
/// those with the most messages.
class Explorer {
 public:
  enum class Checks : std::uint8_t { kSafety, kSafetyAndRecovery };

  Explorer(const Rules& rules, const Bounds& bounds, Checks checks)
      : model_(rules, bounds), recovery_(model_.actors()), checks_(checks) {}

  [[nodiscard]] Finding explore();

 private:
  struct Found {
    MessageSet messages;
    std::uint8_t deaths;
    bool operator==(const Found&) const = default;
  };
  struct Visited {
    std::uint32_t before;  ///< the state's number
    Step step;
  };

  [[nodiscard]] static bool dominates(const Found& better, const Found& other);
  [[nodiscard]] bool is_dominated(const Cell& cell) const;
  void add(const Cell& cell, std::uint32_t before, const Step& step);
  [[nodiscard]] std::string wrong(const Cell& cell, bool is_new_combination);

  Model model_;
  Recovery recovery_;
  Checks checks_;
  std::unordered_map<Processes, std::vector<Found>, Processes::Hash> known_;
  std::map<std::pair<int, int>, std::vector<std::pair<Cell, std::uint32_t>>>
      frontier_;                // by deaths and −messages; each with its number
  std::vector<Visited> trace_;  // by number
  Finding finding_;
};

}  // namespace hecaton::services::model
