#include "tests/model/terms_model.hpp"

#include <bitset>

namespace hecaton::services::model {
namespace {

using Deed = Actors::Deed;
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
  next.letters.insert(actors_.supervisors().tells_within(to));
  visit(next, step);
}

void Model::planner_becomes(Number to, const Cell& cell, const Step& step, const Visit& visit) const {
  if (to == cell.processes.planners[step.who]) return;
  Cell next(cell);
  next.processes.planners[step.who] = to;
  next.letters.insert(actors_.planners().tells_within(to));
  visit(next, step);
}

void Model::driver_becomes(Number to, const Cell& cell, const Step& step, const Visit& visit) const {
  if (to == cell.processes.driver) return;
  Cell next(cell);
  next.processes.driver = to;
  next.letters.insert(actors_.drivers().tells_within(to));
  visit(next, step);
}

void Model::for_each_successor(const Cell& cell, const Visit& visit) {
  for (std::uint8_t who = 0; who < 2; ++who) {
    hear(cell, who, visit);
    decide(cell, who, visit);
  }
  driver_hears(cell, visit);
  if (cell.deaths == bounds_.most_deaths) return;
  for (const Death death : bounds_.deaths) die(cell, death, visit);
}

void Model::hear(const Cell& cell, std::uint8_t who, const Visit& visit) {
  const Number supervisor = cell.processes.supervisors[who];
  Letters heard = cell.letters;
  heard.remove(actors_.supervisors().ignores(supervisor));
  heard.for_each([&](std::size_t letter) {
    const Step step{Kind::kSupervisorHears, who, small(letter)};
    supervisor_becomes(actors_.supervisor_hears(supervisor, letter), cell, step, visit);
  });
  const Number planner = cell.processes.planners[who];
  heard = cell.letters;
  heard.remove(actors_.planners().ignores(planner));
  heard.for_each([&](std::size_t letter) {
    const Step step{Kind::kPlannerHears, who, small(letter)};
    planner_becomes(actors_.planner_hears(planner, letter), cell, step, visit);
  });
}

void Model::driver_hears(const Cell& cell, const Visit& visit) {
  const Number driver = cell.processes.driver;
  Letters heard = cell.letters;
  heard.remove(actors_.drivers().ignores(driver));
  heard.for_each([&](std::size_t letter) {
    const Step step{Kind::kDriverHears, 0, small(letter)};
    driver_becomes(actors_.driver_hears(driver, letter), cell, step, visit);
  });
}

void Model::decide(const Cell& cell, std::uint8_t who, const Visit& visit) {
  const auto does = [&](Deed deed, Kind kind, std::uint8_t what) {
    const Number to = actors_.supervisor_does(cell.processes.supervisors[who], deed);
    supervisor_becomes(to, cell, {kind, who, what}, visit);
  };
  does(Deed::kLosesPatience, Kind::kTakesOver, 0);
  does(Deed::kComesBack, Kind::kComesBack, 0);
  does(Deed::kReplacesP, Kind::kReplaces, 0);
  does(Deed::kReplacesQ, Kind::kReplaces, 1);
}

void Model::die(const Cell& cell, Death death, const Visit& visit) {
  switch (death) {
    case Death::kSupervisor0:
      return supervisor_dies(cell, 0, visit);
    case Death::kSupervisor1:
      return supervisor_dies(cell, 1, visit);
    case Death::kPlanner:
      for (std::uint8_t who = 0; who < 2; ++who) {
        planner_becomes(actors_.new_ones().planners[who], with_one_more_dead(cell, kPlannerAnew << who),
                        {Kind::kPlannerDies, who, 0}, visit);
      }
      return;
    case Death::kDriver:
      return driver_becomes(actors_.driver_restarts(cell.processes.driver), with_one_more_dead(cell, kDriverWithMemory),
                            {Kind::kDriverDies, 0, 0}, visit);
    case Death::kDriverHost:
      return driver_becomes(actors_.new_ones().driver, with_one_more_dead(cell, kDriverWithoutMemory),
                            {Kind::kDriverHostDies, 0, 0}, visit);
  }
}

// On its disk is the cell term under which it led last or, when it stood by since, its leader's; an older one when the
// disk was full.
void Model::supervisor_dies(const Cell& cell, std::uint8_t who, const Visit& visit) {
  const std::uint64_t next_term = actors_.supervisors()[cell.processes.supervisors[who]].next_term();
  std::bitset<64> terms(1);
  cell.letters.for_each([&](std::size_t number) {
    const Letter& letter = actors_.letter(number);
    if (letter.kind == Letter::Kind::kMode && letter.term < next_term) terms.set(letter.term);
  });
  const Number forgetful = actors_.successor(who, 0);
  for (std::size_t term = 0; term <= bounds_.highest_term; ++term) {
    if (!terms[term]) continue;
    const Number successor = actors_.successor(who, term);
    const Returned returned = successor == forgetful ? kSupervisorWithoutMemory : kSupervisorWithMemory;
    supervisor_becomes(successor, with_one_more_dead(cell, returned << who), {Kind::kSupervisorDies, who, small(term)},
                       visit);
  }
}

std::string text(const Step& step, const Actors& actors) {
  const std::string supervisor = "supervisor " + std::to_string(step.who);
  switch (step.kind) {
    case Kind::kSupervisorHears:
      return supervisor + " hears " + text(actors.letter(step.what));
    case Kind::kPlannerHears:
      return "planner " + planner_name(step.who) + " hears " + text(actors.letter(step.what));
    case Kind::kDriverHears:
      return "driver hears " + text(actors.letter(step.what));
    case Kind::kTakesOver:
      return supervisor + " takes over";
    case Kind::kComesBack:
      return supervisor + " was stopped, and finds out";
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
