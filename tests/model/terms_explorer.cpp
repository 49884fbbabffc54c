#include "tests/model/terms_explorer.hpp"

#include <algorithm>

#include "tests/model/terms_landmarks.hpp"

namespace hecaton::services::model {

bool Explorer::outdoes(const Found& better, const Found& other) {
  return better.deaths <= other.deaths && better.letters.contains(other.letters);
}

// A better one was found since.
bool Explorer::is_outdone(const Cell& cell) const {
  const std::vector<Found>& found = known_.at(cell.processes);
  return std::find(found.begin(), found.end(), Found{cell.letters, cell.deaths}) == found.end();
}

Finding Explorer::explore() {
  add(model_.start(), 0, {});
  while (finding_.wrong.empty() && !frontier_.empty()) {
    const auto first = frontier_.begin();
    const Cell cell = first->second.back().first;
    const std::uint32_t number = first->second.back().second;
    first->second.pop_back();
    if (first->second.empty()) frontier_.erase(first);
    if (is_outdone(cell)) continue;
    model_.for_each_successor(cell, [&](const Cell& next, const Step& step) {
      if (!finding_.wrong.empty()) return;
      for (const std::string& passed : landmarks(cell, step, next, model_.actors())) ++finding_.landmarks[passed];
      add(next, number, step);
    });
  }
  finding_.combinations = known_.size();
  return std::move(finding_);
}

void Explorer::add(const Cell& cell, std::uint32_t before, const Step& step) {
  std::vector<Found>& found = known_[cell.processes];
  finding_.wrong = wrong(cell, found.empty());
  if (!finding_.wrong.empty()) {
    if (told_.empty()) return;  // the start
    finding_.story = {text(step, model_.actors())};
    for (std::uint32_t state = before; state > 0; state = told_[state].before) {
      finding_.story.push_back(text(told_[state].step, model_.actors()));
    }
    std::reverse(finding_.story.begin(), finding_.story.end());
    return;
  }
  const Found news{cell.letters, cell.deaths};
  if (std::any_of(found.begin(), found.end(), [&](const Found& one) { return outdoes(one, news); })) return;
  std::erase_if(found, [&](const Found& one) { return outdoes(news, one); });
  found.push_back(news);
  ++finding_.states;
  frontier_[{cell.deaths, -cell.letters.count()}].emplace_back(cell, static_cast<std::uint32_t>(told_.size()));
  told_.push_back({before, step});
}

// What becomes of a cell in which nothing fails any more depends on its processes alone.
std::string Explorer::wrong(const Cell& cell, bool is_new_combination) {
  const std::string& violation = model_.violation(cell);
  const bool is_judged = judges_ == Judges::kSafetyAndCalm && is_new_combination;
  return violation.empty() && is_judged ? calm_.wrong(cell.processes) : violation;
}

}  // namespace hecaton::services::model
