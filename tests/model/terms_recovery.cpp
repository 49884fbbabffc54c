#include "tests/model/terms_recovery.hpp"

#include <array>
#include <cstddef>

namespace hecaton::services::model {
namespace {

using Action = Actors::Action;

constexpr std::size_t kMostRounds = 30;

bool leads(int i, const Processes& processes, const Actors& actors) {
  return actors.supervisors()[processes.supervisors[i]].leads();
}

std::string name(int index, const std::string& one) {
  return index < 0 ? "no " + one : one + " " + std::to_string(index);
}

}  // namespace

Recovery::Recovery(Actors& actors) : actors_(actors) {
  for (const int supervisor : {-1, 0, 1}) {
    for (const int planner : {-1, 0, 1}) cases_.push_back({{supervisor, planner}, {}});
  }
}

std::string Recovery::wrong(const Processes& processes) {
  for (Case& one : cases_) {
    const std::string wrong = failure_in(one, processes);
    if (wrong.empty()) continue;
    return wrong + ", with " + name(one.dead.supervisor, "supervisor") + " and " + name(one.dead.planner, "planner") +
           " dead";
  }
  return {};
}

// Many paths lead to few states, so all states of a path except the first are stored.
std::string Recovery::failure_in(Case& one, const Processes& processes) {
  std::vector<Processes> path;
  for (Processes last = processes;;) {
    const Processes next = round(one.dead, last);
    if (next == last) {
      std::string wrong = failure_at_rest(one.dead, last);
      if (!wrong.empty()) return wrong;
      break;
    }
    if (one.recovering.contains(next)) break;
    if (path.size() == kMostRounds) return "it does not reach a final state";
    path.push_back(next);
    last = next;
  }
  one.recovering.insert(path.begin(), path.end());
  return {};
}

std::string Recovery::failure_at_rest(const Dead& dead, const Processes& processes) const {
  const bool first = dead.supervisor != 0 && leads(0, processes, actors_);
  const bool second = dead.supervisor != 1 && leads(1, processes, actors_);
  if (first == second) return "not one supervisor leads";
  const ArmLease lease = actors_.supervisors()[processes.supervisors[first ? 0 : 1]].lease();
  const std::size_t in_charge = planner_index(lease.planner);
  if (in_charge == kNoPlanner || static_cast<int>(in_charge) == dead.planner) return "no living planner is in charge";
  const DriverProcess& driver = actors_.drivers()[processes.driver];
  if (!driver.violation().empty()) return driver.violation();
  return driver.follows(lease) ? std::string() : "the driver does not follow the planner in charge";
}

// Every process receives what all other processes sent in the previous round.
Processes Recovery::round(const Dead& dead, const Processes& before) {
  Processes after(before);
  for (const int i : {0, 1}) {
    if (i != dead.supervisor) supervise(i, dead, before, after);
  }
  for (const int j : {0, 1}) {
    if (j == dead.planner) continue;
    for (const std::size_t message : actors_.drivers().sends(before.driver)) {
      after.planners[j] = actors_.planner_receives(after.planners[j], message);
    }
    for (const std::size_t message : actors_.planners().sends(before.planners[j])) {
      after.driver = actors_.driver_receives(after.driver, message);
    }
  }
  return after;
}

// A supervisor that steps down, or detects that another one has led, decides no more in this round.
void Recovery::supervise(int i, const Dead& dead, const Processes& before, Processes& after) {
  Number& self = after.supervisors[i];
  const auto receive = [&](const std::vector<std::size_t>& messages) {
    for (const std::size_t message : messages) self = actors_.supervisor_receives(self, message);
  };
  const int other = 1 - i;
  const bool receives_leader = other != dead.supervisor && leads(other, before, actors_);
  if (receives_leader) receive(actors_.supervisors().sends(before.supervisors[other]));
  for (const int j : {0, 1}) {
    if (j != dead.planner) receive(actors_.planners().sends(before.planners[j]));
  }
  receive(actors_.drivers().sends(before.driver));
  if (!leads(i, before, actors_) && !receives_leader) self = actors_.supervisor_does(self, Action::kMissesLeader);
  constexpr std::array kGrants{Action::kGrants, Action::kReplacesP, Action::kReplacesQ};
  self = actors_.supervisor_does(self, kGrants.at(static_cast<std::size_t>(1 + dead.planner)));
  for (const std::size_t mode : actors_.supervisors().sends(before.supervisors[i])) {
    after.driver = actors_.driver_receives(after.driver, mode);
    for (const int j : {0, 1}) {
      if (j != dead.planner) after.planners[j] = actors_.planner_receives(after.planners[j], mode);
    }
  }
}

}  // namespace hecaton::services::model
