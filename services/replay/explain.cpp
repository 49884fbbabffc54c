#include "services/replay/explain.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>
#include <utility>

#include "services/messages/names.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/standstill.hpp"

namespace hecaton::services::replay {
namespace {

using Sentences = std::vector<std::string>;

constexpr std::chrono::seconds kWindow{10};              // of longest_binding()
constexpr std::chrono::milliseconds kBetweenLooks{100};  // in it

std::string number_text(double value, const char* format = "%.2f") {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string milliseconds_text(double seconds) {
  return number_text(seconds * 1e3, seconds < 0.01 ? "%.1f" : "%.0f") + " ms";
}

std::string age_of(bus::Clock::duration age) {
  return milliseconds_text(std::chrono::duration<double>(age).count());
}

std::string millimetres_text(double metres) {
  return number_text(metres * 1e3, "%.0f") + " mm";
}

/// " [goal_unreachable]", " [path_blocked, post]": for programs.
std::string kind_of(const msg::Cause& cause) {
  const std::string subject = cause.subject().empty() ? "" : ", " + cause.subject();
  return " [" + std::string(cause_name(cause.kind())) + subject + "]";
}

/// A supervisor sends the mode every few milliseconds; one of its standbys takes over within this time.
constexpr std::chrono::seconds kSupervised{1};

void say_mode(const CellState& cell, const std::string& arm, bus::Clock::time_point now, Sentences& sentences) {
  const CellModeView& mode = cell.mode();
  if (!mode.heard()) {
    sentences.push_back("No cell mode was received yet.");
    return;
  }
  const msg::Cause why = mode.why(arm);
  std::string sentence = "The order for " + arm + " is " + text(mode.order(arm)) + ", by " + mode.mode().node() +
                         " in term " + std::to_string(mode.term());
  if (!is_none(why)) sentence += ": " + why.text();
  const auto age = now - mode.received();
  if (age >= kSupervised)
    sentence +=
        ". No supervisor was heard for " + number_text(std::chrono::duration<double>(age).count(), "%.1f") + " s";
  sentences.push_back(sentence + ".");
}

void say_motion(const CellState& cell, const std::string& arm, bus::Clock::time_point now, Sentences& sentences) {
  const auto* state = cell.state(arm);
  if (state == nullptr) {
    sentences.push_back("No state of " + arm + " was received yet.");
  } else {
    double fastest = 0.0;
    for (const double v : state->value.qd()) fastest = std::max(fastest, std::abs(v));
    std::string sentence = moves(state->value)
                               ? arm + " moves, its fastest joint at " + number_text(fastest, "%.3f") + " rad/s or m/s"
                               : arm + " stands";
    sentence += "; its drive is " + text(state->value.mode());
    if (!is_none(state->value.cause())) sentence += " (" + state->value.cause().text() + ")";
    sentences.push_back(sentence + ".");
  }
  const msg::Cause waiting = cell.waiting_for(arm, now);
  if (is_none(waiting)) return;
  sentences.push_back(arm + " waits for: " + waiting.text() + kind_of(waiting) + ".");
}

double security_distance(const CellState& cell, const std::string& arm) {
  for (const planner::PlannedArm& planned : cell.file().cell.arms) {
    if (planned.arm.name == arm) return planned.parameters.damper.security_distance;
  }
  return 0.0;
}

void say_goal(const CellState& cell, const std::string& arm, const LongestBinding& before, Sentences& sentences) {
  const auto* goal = cell.goal(arm);
  if (goal == nullptr) {
    sentences.push_back(arm + " has no goal.");
    return;
  }
  const msg::GoalStatus& status = goal->value;
  std::string sentence = "Goal " + status.goal() + " is " + text(status.state()) + ", " +
                         number_text(status.distance_to_goal()) + " rad or m to go, " +
                         number_text(status.elapsed(), "%.1f") + " s after " + status.node() + " accepted it";
  if (!is_none(status.cause())) sentence += ": " + status.cause().text() + kind_of(status.cause());
  sentences.push_back(sentence + ".");
  if (is_final(status.state())) return;
  if (status.has_binding()) {
    sentences.push_back(status.binding_own() + " and " + status.binding_other() + " bound its motion: they are " +
                        millimetres_text(status.binding_distance()) + " apart, and " +
                        millimetres_text(security_distance(cell, arm)) + " are the security distance.");
  } else {
    sentences.push_back("No pair of bodies bounds its motion.");
  }
  if (status.blocked_duration() > 0.0) {
    sentences.push_back(arm + " last moved freely to its goal " + number_text(status.blocked_duration(), "%.1f") +
                        " s ago.");
  }
  if (before.bound > 0.0) {
    sentences.push_back("In the last " + number_text(before.window, "%.1f") + " s " + before.own + " and " +
                        before.other + " bound its motion longer than any other pair: for " +
                        number_text(before.bound, "%.1f") + " s.");
    sentences.push_back("It was nearest to its goal " + number_text(before.nearest_ago, "%.1f") + " s ago, with " +
                        number_text(before.nearest) + " rad or m to go; then " + before.nearest_own + " and " +
                        before.nearest_other + " bound its motion.");
  }
  if (!status.recovery_action().empty()) sentences.push_back("Its planner " + status.recovery_action() + ".");
}

void say_inputs(const CellState& cell, const std::string& arm, bus::Clock::time_point now, Sentences& sentences) {
  std::string ages;
  for (const planner::PlannedArm& planned : cell.file().cell.arms) {
    const auto* state = cell.state(planned.arm.name);
    ages +=
        (ages.empty() ? "" : ", ") + planned.arm.name + " " + (state == nullptr ? "never" : age_of(state->age(now)));
  }
  const auto* obstacles = cell.obstacle_states();
  sentences.push_back("Ages of the states at the recorder: " + ages + ", obstacles " +
                      (obstacles == nullptr ? "never" : age_of(obstacles->age(now))) + ".");
  const std::string planner = cell.planner_of(arm);
  if (const auto* heartbeat = cell.heartbeat(planner)) {
    const msg::Heartbeat& health = heartbeat->value;
    std::string sentence = planner + " is " + text(health.state());
    if (!is_none(health.cause())) sentence += " (" + health.cause().text() + ")";
    if (!health.oldest_input().empty()) {
      const double age = health.oldest_input_age();
      sentence += "; its oldest input is " + health.oldest_input() + ", " +
                  (age < 0.0 ? "which it has never received" : milliseconds_text(age));
    }
    sentences.push_back(sentence + ", as it said " + age_of(heartbeat->age(now)) + " before.");
  } else {
    sentences.push_back("No heartbeat of " + planner + " was received yet.");
  }
  if (const auto* state = cell.state(arm)) {
    sentences.push_back(state->value.command_sequence_number() == 0
                            ? "The driver of " + arm + " has not accepted a command yet."
                            : "The driver of " + arm + " has accepted its last command " +
                                  milliseconds_text(std::max(0.0, state->value.command_age())) +
                                  " before its last state.");
  }
}

void say_faults(const CellState& cell, Sentences& sentences) {
  for (const auto& [id, fault] : cell.faults().all()) {
    if (fault.cleared()) continue;
    sentences.push_back("Fault " + id + " is open: " + fault.cause().text() + kind_of(fault.cause()) + ".");
  }
}

}  // namespace

LongestBinding longest_binding(RecordedCell& cell, const std::string& arm, bus::Clock::time_point at) {
  cell.move_to(at);
  const auto* present = cell.state().goal(arm);
  if (present == nullptr || is_final(present->value.state())) return {};
  const std::string goal = present->value.goal();
  const auto elapsed =
      std::chrono::duration_cast<bus::Clock::duration>(std::chrono::duration<double>(present->value.elapsed()));
  const auto begin = std::max(at - std::min<bus::Clock::duration>(kWindow, elapsed), cell.index().begin);
  std::map<std::pair<std::string, std::string>, int> looks;
  LongestBinding longest{.window = std::chrono::duration<double>(at - begin).count()};
  for (auto time = begin; time < at; time += kBetweenLooks) {
    cell.move_to(time);
    const auto* then = cell.state().goal(arm);
    if (then == nullptr || then->value.goal() != goal || !then->value.has_binding()) continue;
    const bool first = looks.empty();
    ++looks[{then->value.binding_own(), then->value.binding_other()}];
    if (!first && then->value.distance_to_goal() >= longest.nearest) continue;
    longest.nearest = then->value.distance_to_goal();
    longest.nearest_ago = std::chrono::duration<double>(at - time).count();
    longest.nearest_own = then->value.binding_own();
    longest.nearest_other = then->value.binding_other();
  }
  cell.move_to(at);
  const auto most =
      std::max_element(looks.begin(), looks.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most == looks.end()) return longest;
  longest.bound = std::min(most->second * std::chrono::duration<double>(kBetweenLooks).count(), longest.window);
  std::tie(longest.own, longest.other) = most->first;
  return longest;
}

std::vector<std::string> explain(const CellState& cell, const std::string& arm, bus::Clock::time_point now,
                                 const LongestBinding& before) {
  Sentences sentences;
  say_mode(cell, arm, now, sentences);
  say_motion(cell, arm, now, sentences);
  say_goal(cell, arm, before, sentences);
  say_inputs(cell, arm, now, sentences);
  say_faults(cell, sentences);
  return sentences;
}

}  // namespace hecaton::services::replay
