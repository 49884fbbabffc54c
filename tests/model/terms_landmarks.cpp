#include "tests/model/terms_landmarks.hpp"

namespace hecaton::services::model {
namespace {

using Kind = Step::Kind;
using Sentences = std::vector<std::string>;

bool told_before(const Cell& cell, const Actors& actors, const auto& condition) {
  bool told = false;
  cell.letters.for_each([&](std::size_t letter) { told = told || condition(actors.letter(letter)); });
  return told;
}

void of_grants(const std::string& name, const Cell& before, const ArmLease& granted, const Actors& actors,
               Sentences& sentences) {
  const auto another_has_it = [&](const Letter& letter) {
    return letter.kind == Letter::Kind::kMode && letter.granted == granted.term && letter.mandate() != granted;
  };
  if (told_before(before, actors, another_has_it))
    sentences.push_back(name + " grants a term that another planner has");
}

Sentences of_takeover(const Cell& before, const Step& step, const Cell& after, const Actors& actors) {
  const std::string name = "supervisor " + std::to_string(step.who);
  const SupervisorProcess& was = actors.supervisors()[before.processes.supervisors[step.who]];
  const SupervisorProcess& is = actors.supervisors()[after.processes.supervisors[step.who]];
  const bool stood_by = was.role() == Leadership::Role::kStandingBy;
  Sentences sentences{name + (stood_by ? " stood by and leads" : " listened and leads")};
  if ((before.returned & kSupervisorWithMemory << step.who) != 0) sentences.push_back(name + " returned and leads");
  if ((before.returned & kSupervisorWithoutMemory << step.who) != 0) {
    sentences.push_back(name + " returned without memory and leads");
  }
  if (is.cell_term() <= was.mandate().term) sentences.push_back(name + " leads under a term not above a mandate");
  of_grants(name, before, is.mandate(), actors, sentences);
  return sentences;
}

Sentences of_replacement(const Cell& before, const Step& step, const Cell& after, const Actors& actors) {
  const std::string name = "supervisor " + std::to_string(step.who);
  Sentences sentences{name + " replaces planner " + planner_name(step.what)};
  of_grants(name, before, actors.supervisors()[after.processes.supervisors[step.who]].mandate(), actors, sentences);
  return sentences;
}

Sentences of_hearing(const Cell& before, const Letter& letter, const Actors& actors) {
  if (letter.kind != Letter::Kind::kCommand) return {};
  const std::string planner = planner_name(letter.planner);
  const std::string& other = planner_name(1U - letter.planner);
  Sentences sentences;
  const auto followed_other = [&](const Letter& command) {
    return command.kind == Letter::Kind::kCommand && command.mandate().planner == other &&
           command.granted < letter.granted;
  };
  if (told_before(before, actors, followed_other))
    sentences.push_back("the driver follows " + planner + " after " + other);
  if ((before.returned & kPlannerAnew << letter.planner) != 0) {
    sentences.push_back("planner " + planner + " returned and is followed");
  }
  if ((before.returned & kDriverWithMemory) != 0) sentences.emplace_back("the driver returned and follows");
  if ((before.returned & kDriverWithoutMemory) != 0)
    sentences.emplace_back("the driver returned without memory and follows");
  return sentences;
}

Sentences of_driver_death(const Cell& before, const Actors& actors) {
  const ArmLease& mandate = actors.drivers()[before.processes.driver].mandate();
  const auto is_stale = [&](const Letter& letter) {
    return letter.kind == Letter::Kind::kCommand && letter.granted < mandate.term;
  };
  if (!told_before(before, actors, is_stale)) return {};
  return {"the driver returned and may hear a command that it must refuse"};
}

}  // namespace

std::vector<std::string> landmarks(const Cell& before, const Step& step, const Cell& after, const Actors& actors) {
  switch (step.kind) {
    case Kind::kTakesOver:
      return of_takeover(before, step, after, actors);
    case Kind::kReplaces:
      return of_replacement(before, step, after, actors);
    case Kind::kDriverHears:
      return of_hearing(before, actors.letter(step.what), actors);
    case Kind::kDriverDies:
      return of_driver_death(before, actors);
    case Kind::kComesBack:
      return {"supervisor " + std::to_string(step.who) + " was stopped, and finds out"};
    case Kind::kSupervisorHears:
    case Kind::kPlannerHears:
    case Kind::kSupervisorDies:
    case Kind::kPlannerDies:
    case Kind::kDriverHostDies:
      break;
  }
  return {};
}

}  // namespace hecaton::services::model
