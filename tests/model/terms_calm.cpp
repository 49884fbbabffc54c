#include "tests/model/terms_calm.hpp"

#include <array>
#include <cstddef>

namespace hecaton::services::model {
namespace {

using Deed = Actors::Deed;

constexpr std::size_t kMostRounds = 30;

bool leads(int i, const Processes& processes, const Actors& actors) {
  return actors.supervisors()[processes.supervisors[i]].leads();
}

std::string name(int index, const std::string& one) {
  return index < 0 ? "no " + one : one + " " + std::to_string(index);
}

}  // namespace

Calm::Calm(Actors& actors) : actors_(actors) {
  for (const int supervisor : {-1, 0, 1}) {
    for (const int planner : {-1, 0, 1}) cases_.push_back({{supervisor, planner}, {}});
  }
}

std::string Calm::wrong(const Processes& processes) {
  for (Case& one : cases_) {
    const std::string wrong = wrong_in(one, processes);
    if (wrong.empty()) continue;
    return wrong + ", with " + name(one.dead.supervisor, "supervisor") + " and " + name(one.dead.planner, "planner") +
           " dead";
  }
  return {};
}

// Many ways lead to few states, so all but the first of each way are remembered.
std::string Calm::wrong_in(Case& one, const Processes& processes) {
  std::vector<Processes> way;
  for (Processes last = processes;;) {
    const Processes next = round(one.dead, last);
    if (next == last) {
      std::string wrong = wrong_at_rest(one.dead, last);
      if (!wrong.empty()) return wrong;
      break;
    }
    if (one.well.contains(next)) break;
    if (way.size() == kMostRounds) return "it does not come to rest";
    way.push_back(next);
    last = next;
  }
  one.well.insert(way.begin(), way.end());
  return {};
}

std::string Calm::wrong_at_rest(const Dead& dead, const Processes& processes) const {
  const bool first = dead.supervisor != 0 && leads(0, processes, actors_);
  const bool second = dead.supervisor != 1 && leads(1, processes, actors_);
  if (first == second) return "not one supervisor leads";
  const ArmLease told = actors_.supervisors()[processes.supervisors[first ? 0 : 1]].mandate();
  const std::size_t in_charge = planner_index(told.planner);
  if (in_charge == kNobody || static_cast<int>(in_charge) == dead.planner) return "no living planner is in charge";
  const DriverProcess& driver = actors_.drivers()[processes.driver];
  if (!driver.violation().empty()) return driver.violation();
  return driver.follows(told) ? std::string() : "the driver does not follow the planner that the supervisor tells";
}

// Everybody hears what everybody else told in the round before.
Processes Calm::round(const Dead& dead, const Processes& before) {
  Processes after(before);
  for (const int i : {0, 1}) {
    if (i != dead.supervisor) supervise(i, dead, before, after);
  }
  for (const int j : {0, 1}) {
    if (j == dead.planner) continue;
    for (const std::size_t letter : actors_.drivers().tells(before.driver)) {
      after.planners[j] = actors_.planner_hears(after.planners[j], letter);
    }
    for (const std::size_t letter : actors_.planners().tells(before.planners[j])) {
      after.driver = actors_.driver_hears(after.driver, letter);
    }
  }
  return after;
}

// Who stands back, or finds out that another has led, decides no more in this round.
void Calm::supervise(int i, const Dead& dead, const Processes& before, Processes& after) {
  Number& self = after.supervisors[i];
  const auto hear = [&](const std::vector<std::size_t>& letters) {
    for (const std::size_t letter : letters) self = actors_.supervisor_hears(self, letter);
  };
  const int other = 1 - i;
  const bool hears_leader = other != dead.supervisor && leads(other, before, actors_);
  if (hears_leader) hear(actors_.supervisors().tells(before.supervisors[other]));
  for (const int j : {0, 1}) {
    if (j != dead.planner) hear(actors_.planners().tells(before.planners[j]));
  }
  hear(actors_.drivers().tells(before.driver));
  if (!leads(i, before, actors_) && !hears_leader) self = actors_.supervisor_does(self, Deed::kLosesPatience);
  constexpr std::array kGrants{Deed::kGrants, Deed::kReplacesP, Deed::kReplacesQ};
  self = actors_.supervisor_does(self, kGrants.at(static_cast<std::size_t>(1 + dead.planner)));
  for (const std::size_t mode : actors_.supervisors().tells(before.supervisors[i])) {
    after.driver = actors_.driver_hears(after.driver, mode);
    for (const int j : {0, 1}) {
      if (j != dead.planner) after.planners[j] = actors_.planner_hears(after.planners[j], mode);
    }
  }
}

}  // namespace hecaton::services::model
