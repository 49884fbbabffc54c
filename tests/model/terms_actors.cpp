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

Actors::Actors(const Rules& rules, std::uint64_t highest_term) : post_(highest_term) {
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

Number Actors::supervisor_does(Number supervisor, Deed deed) {
  return supervisors_.after_deed(supervisor, static_cast<std::size_t>(deed), [&](SupervisorProcess& process) {
    switch (deed) {
      case Deed::kLosesPatience:
        return process.lose_patience(later());
      case Deed::kComesBack:
        return process.come_back(later());
      case Deed::kGrants:
        return process.grant(-1);
      case Deed::kReplacesP:
        return process.grant(0);
      case Deed::kReplacesQ:
        return process.grant(1);
    }
  });
}

Number Actors::supervisor_hears(Number supervisor, std::size_t letter) {
  return supervisors_.after_letter(supervisor, letter,
                                   [&](SupervisorProcess& process) { process.hear(post_.letter(letter), later()); });
}

Number Actors::planner_hears(Number planner, std::size_t letter) {
  return planners_.after_letter(planner, letter, [&](PlannerProcess& process) { process.hear(post_.letter(letter)); });
}

Number Actors::driver_hears(Number driver, std::size_t letter) {
  return drivers_.after_letter(driver, letter, [&](DriverProcess& process) { process.hear(post_.letter(letter)); });
}

Number Actors::driver_restarts(Number driver) {
  return drivers_.after_deed(driver, 0, [](DriverProcess& process) { process.restart(); });
}

}  // namespace hecaton::services::model
