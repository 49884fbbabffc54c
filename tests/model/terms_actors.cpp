#include "tests/model/terms_actors.hpp"

#include <chrono>

namespace hecaton::services::model {

std::size_t Processes::Hash::operator()(const Processes& processes) const {
  std::uint64_t hash = processes.driver;
  for (const auto& two : {processes.supervisors, processes.planners}) {
    for (const Number number : two) {
      hash = (hash ^ number) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 29U;
    }
  }
  return hash;
}

Actors::Actors(const Rules& rules, std::uint64_t highest_term) : table_(highest_term) {
  for (const int i : {0, 1}) {
    new_.supervisors[i] = supervisors_.number_of(SupervisorProcess(rules, i));
    new_.planners[i] = planners_.number_of(PlannerProcess(rules, i));
    for (std::uint64_t term = 0; term <= highest_term; ++term) {
      successors_[i].push_back(supervisors_.number_of(SupervisorProcess::successor(rules, i, term)));
    }
  }
  new_.driver = drivers_.number_of(DriverProcess(rules));
}

SupervisorProcess::Time Actors::later() {
  return now_ += std::chrono::seconds(1);
}

Number Actors::supervisor_does(Number supervisor, Action action) {
  return supervisors_.after_action(supervisor, static_cast<std::size_t>(action), [&](SupervisorProcess& process) {
    switch (action) {
      case Action::kMissesLeader:
        return process.miss_leader(later());
      case Action::kDetectsAbsence:
        return process.detect_absence(later());
      case Action::kGrants:
        return process.grant(-1);
      case Action::kReplacesP:
        return process.grant(0);
      case Action::kReplacesQ:
        return process.grant(1);
    }
  });
}

Number Actors::supervisor_receives(Number supervisor, std::size_t message) {
  return supervisors_.after_message(
      supervisor, message, [&](SupervisorProcess& process) { process.receive(table_.message(message), later()); });
}

Number Actors::planner_receives(Number planner, std::size_t message) {
  return planners_.after_message(planner, message,
                                 [&](PlannerProcess& process) { process.receive(table_.message(message)); });
}

Number Actors::driver_receives(Number driver, std::size_t message) {
  return drivers_.after_message(driver, message,
                                [&](DriverProcess& process) { process.receive(table_.message(message)); });
}

Number Actors::driver_restarts(Number driver) {
  return drivers_.after_action(driver, 0, [](DriverProcess& process) { process.restart(); });
}

}  // namespace hecaton::services::model
