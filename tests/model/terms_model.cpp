#include "tests/model/terms_model.hpp"

#include <bitset>

namespace hecaton::services::model {
namespace {

using Action = Actors::Action;
using Kind = Step::Kind;

std::uint8_t small(std::size_t number) {
  return static_cast<std::uint8_t>(number);
}

Cell with_one_more_dead(const Cell& cell, int returned) {
  Cell next(cell);
  ++next.deaths;
  next.returned |= static_cast<std::uint8_t>(returned);
  return next;
}

}  // namespace

Cell Model::start() const {
  Cell cell;
  cell.processes = actors_.new_ones();
  return cell;
}

const std::string& Model::violation(const Cell& cell) const {
  return actors_.drivers()[cell.processes.driver].violation();
}

void Model::supervisor_becomes(Number to, const Cell& cell, const Step& step, const Visit& visit) const {
  const bool too_high = actors_.supervisors()[to].highest() > bounds_.highest_term;
  if (to == cell.processes.supervisors[step.who] || too_high) return;
  Cell next(cell);
  next.processes.supervisors[step.who] = to;
  next.messages.insert(actors_.supervisors().sends_within(to));
  visit(next, step);
}

void Model::planner_becomes(Number to, const Cell& cell, const Step& step, const Visit& visit) const {
  if (to == cell.processes.planners[step.who]) return;
  Cell next(cell);
  next.processes.planners[step.who] = to;
  next.messages.insert(actors_.planners().sends_within(to));
  visit(next, step);
}

void Model::driver_becomes(Number to, const Cell& cell, const Step& step, const Visit& visit) const {
  if (to == cell.processes.driver) return;
  Cell next(cell);
  next.processes.driver = to;
  next.messages.insert(actors_.drivers().sends_within(to));
  visit(next, step);
}

void Model::for_each_successor(const Cell& cell, const Visit& visit) {
  for (std::uint8_t who = 0; who < 2; ++who) {
    receive(cell, who, visit);
    decide(cell, who, visit);
  }
  driver_receives(cell, visit);
  if (cell.deaths == bounds_.most_deaths) return;
  for (const Death death : bounds_.deaths) die(cell, death, visit);
}

void Model::receive(const Cell& cell, std::uint8_t who, const Visit& visit) {
  const Number supervisor = cell.processes.supervisors[who];
  MessageSet received = cell.messages;
  received.remove(actors_.supervisors().ignores(supervisor));
  received.for_each([&](std::size_t message) {
    const Step step{Kind::kSupervisorReceives, who, small(message)};
    supervisor_becomes(actors_.supervisor_receives(supervisor, message), cell, step, visit);
  });
  const Number planner = cell.processes.planners[who];
  received = cell.messages;
  received.remove(actors_.planners().ignores(planner));
  received.for_each([&](std::size_t message) {
    const Step step{Kind::kPlannerReceives, who, small(message)};
    planner_becomes(actors_.planner_receives(planner, message), cell, step, visit);
  });
}

void Model::driver_receives(const Cell& cell, const Visit& visit) {
  const Number driver = cell.processes.driver;
  MessageSet received = cell.messages;
  received.remove(actors_.drivers().ignores(driver));
  received.for_each([&](std::size_t message) {
    const Step step{Kind::kDriverReceives, 0, small(message)};
    driver_becomes(actors_.driver_receives(driver, message), cell, step, visit);
  });
}

void Model::decide(const Cell& cell, std::uint8_t who, const Visit& visit) {
  const auto does = [&](Action action, Kind kind, std::uint8_t what) {
    const Number to = actors_.supervisor_does(cell.processes.supervisors[who], action);
    supervisor_becomes(to, cell, {kind, who, what}, visit);
  };
  does(Action::kMissesLeader, Kind::kBecomesLeader, 0);
  does(Action::kDetectsAbsence, Kind::kDetectsAbsence, 0);
  does(Action::kReplacesP, Kind::kReplaces, 0);
  does(Action::kReplacesQ, Kind::kReplaces, 1);
}

void Model::die(const Cell& cell, Death death, const Visit& visit) {
  switch (death) {
    case Death::kSupervisor0:
      return supervisor_dies(cell, 0, visit);
    case Death::kSupervisor1:
      return supervisor_dies(cell, 1, visit);
    case Death::kPlanner:
      for (std::uint8_t who = 0; who < 2; ++who) {
        planner_becomes(actors_.new_ones().planners[who], with_one_more_dead(cell, kPlannerReturned << who),
                        {Kind::kPlannerDies, who, 0}, visit);
      }
      return;
    case Death::kDriver:
      return driver_becomes(actors_.driver_restarts(cell.processes.driver),
                            with_one_more_dead(cell, kDriverWithCheckpoint), {Kind::kDriverDies, 0, 0}, visit);
    case Death::kDriverHost:
      return driver_becomes(actors_.new_ones().driver, with_one_more_dead(cell, kDriverWithoutCheckpoint),
                            {Kind::kDriverHostDies, 0, 0}, visit);
  }
}

// Its checkpoint has the cell term under which it led last or, if it stood by since, that of its leader; an older one
// if the disk was full.
void Model::supervisor_dies(const Cell& cell, std::uint8_t who, const Visit& visit) {
  const std::uint64_t next_term = actors_.supervisors()[cell.processes.supervisors[who]].next_term();
  std::bitset<64> terms(1);
  cell.messages.for_each([&](std::size_t number) {
    const Message& message = actors_.message(number);
    if (message.kind == Message::Kind::kMode && message.term < next_term) terms.set(message.term);
  });
  const Number without_checkpoint = actors_.successor(who, 0);
  for (std::size_t term = 0; term <= bounds_.highest_term; ++term) {
    if (!terms[term]) continue;
    const Number successor = actors_.successor(who, term);
    const Returned returned =
        successor == without_checkpoint ? kSupervisorWithoutCheckpoint : kSupervisorWithCheckpoint;
    supervisor_becomes(successor, with_one_more_dead(cell, returned << who), {Kind::kSupervisorDies, who, small(term)},
                       visit);
  }
}

std::string text(const Step& step, const Actors& actors) {
  const std::string supervisor = "supervisor " + std::to_string(step.who);
  switch (step.kind) {
    case Kind::kSupervisorReceives:
      return supervisor + " receives " + text(actors.message(step.what));
    case Kind::kPlannerReceives:
      return "planner " + planner_name(step.who) + " receives " + text(actors.message(step.what));
    case Kind::kDriverReceives:
      return "driver receives " + text(actors.message(step.what));
    case Kind::kBecomesLeader:
      return supervisor + " becomes leader";
    case Kind::kDetectsAbsence:
      return supervisor + " detects that it was stopped";
    case Kind::kReplaces:
      return supervisor + " replaces planner " + planner_name(step.what);
    case Kind::kSupervisorDies:
      return supervisor + " dies and returns with term " + std::to_string(step.what);
    case Kind::kPlannerDies:
      return "planner " + planner_name(step.who) + " dies and returns";
    case Kind::kDriverDies:
      return "driver dies and returns";
    case Kind::kDriverHostDies:
      break;
  }
  return "driver's host is lost";
}

}  // namespace hecaton::services::model
