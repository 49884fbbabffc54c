#include "tests/model/terms_letters.hpp"

#include <algorithm>
#include <stdexcept>

namespace hecaton::services::model {
namespace {

const std::array<std::string, 3> kPlanners{"p", "q", ""};

}  // namespace

const std::string& planner_name(std::size_t index) {
  return kPlanners.at(index);
}

std::uint8_t planner_index(const std::string& name) {
  const auto found = std::find(kPlanners.begin(), kPlanners.end(), name);
  if (found == kPlanners.end()) throw std::out_of_range("the model has no planner " + name);
  return static_cast<std::uint8_t>(found - kPlanners.begin());
}

Letter letter_about(Letter::Kind kind, const ArmLease& mandate) {
  return {kind, 0, 0, static_cast<std::uint8_t>(mandate.term), planner_index(mandate.planner)};
}

std::string text(const Letter& letter) {
  const std::string mandate = planner_name(letter.planner) + ":" + std::to_string(letter.granted);
  switch (letter.kind) {
    case Letter::Kind::kMode:
      return "mode " + std::to_string(letter.term) + " of supervisor " + std::to_string(letter.sender) + " granting " +
             mandate;
    case Letter::Kind::kCommand:
      return "command " + mandate;
    case Letter::Kind::kState:
      return "state with " + mandate;
    case Letter::Kind::kBeat:
      return "beat of term " + std::to_string(letter.term);
    case Letter::Kind::kHeld:
      break;
  }
  return "beat with " + mandate;
}

std::size_t Post::number_of(const Letter& letter) {
  const auto known = numbers_.find(letter);
  if (known != numbers_.end()) return known->second;
  const bool within = std::max(letter.term, letter.granted) <= highest_term_;
  std::vector<Letter>& letters = within ? within_ : beyond_;
  if (within && letters.size() == Letters::kMost) throw std::length_error("the model has too many letters");
  const std::size_t number = letters.size() + (within ? 0 : Letters::kMost);
  letters.push_back(letter);
  numbers_.emplace(letter, number);
  return number;
}

const Letter& Post::letter(std::size_t number) const {
  return number < Letters::kMost ? within_.at(number) : beyond_.at(number - Letters::kMost);
}

}  // namespace hecaton::services::model
