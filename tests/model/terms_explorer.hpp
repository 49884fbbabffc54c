#pragma once
/// Explores every state that a model can get into, and judges each.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "tests/model/terms_calm.hpp"
#include "tests/model/terms_model.hpp"

namespace hecaton::services::model {

struct Finding {
  std::string wrong;                             ///< empty: nothing
  std::vector<std::string> story;                ///< that leads there
  std::size_t states = 0;                        ///< that were explored
  std::size_t combinations = 0;                  ///< of states of the processes: each was judged
  std::map<std::string, std::size_t> landmarks;  ///< how often each was passed
};

/// Of two states with the same processes only the one in which more was told and fewer died is explored: it can do
/// whatever the other can, and is judged alike. Those with the fewest deaths, and of them those in which most was told,
/// come first.
class Explorer {
 public:
  enum class Judges : std::uint8_t { kSafety, kSafetyAndCalm };

  Explorer(const Rules& rules, const Bounds& bounds, Judges judges)
      : model_(rules, bounds), calm_(model_.actors()), judges_(judges) {}

  [[nodiscard]] Finding explore();

 private:
  struct Found {
    Letters letters;
    std::uint8_t deaths;
    bool operator==(const Found&) const = default;
  };
  struct Told {
    std::uint32_t before;  ///< the state's number
    Step step;
  };

  [[nodiscard]] static bool outdoes(const Found& better, const Found& other);
  [[nodiscard]] bool is_outdone(const Cell& cell) const;
  void add(const Cell& cell, std::uint32_t before, const Step& step);
  [[nodiscard]] std::string wrong(const Cell& cell, bool is_new_combination);

  Model model_;
  Calm calm_;
  Judges judges_;
  std::unordered_map<Processes, std::vector<Found>, Processes::Hash> known_;
  std::map<std::pair<int, int>, std::vector<std::pair<Cell, std::uint32_t>>>
      frontier_;            // by deaths and −letters; each with its number
  std::vector<Told> told_;  // by number
  Finding finding_;
};

}  // namespace hecaton::services::model
