/// hecaton hold, resume, stop: allow or forbid motion of the cell or of some arms.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/status_output.hpp"
#include "services/command_line/program.hpp"
#include "services/runtime/orders.hpp"

namespace hecaton::services::cli {
namespace {

/// Resuming the cell does not resume arms that were stopped by name, or are held for a fault of their device.
void print_unresumed(const msg::CellMode& mode) {
  std::string stopped;
  std::string failed;
  for (const msg::ArmOrder& order : mode.arms()) {
    if (is_for_device(order.cause(), order.arm())) {
      failed += " " + order.arm();
    } else if (order.mode() == msg::Mode::MODE_STOP) {
      stopped += " " + order.arm();
    }
  }
  const auto print_to_stderr = [](const char* what, const std::string& names) {
    if (names.empty()) return;
    std::fprintf(stderr, "%s:%s; resume them with 'hecaton resume%s'\n", what, names.c_str(), names.c_str());
  };
  print_to_stderr("arms stopped by name stay stopped", stopped);
  print_to_stderr("arms with a fault of their device stay held", failed);
}

/// The supervisor lets the arm run, but its driver says that an order or a missing cell mode holds it.
bool is_still_held(const msg::ArmStatus& arm) {
  if (arm.mode() != msg::Mode::MODE_RUN || arm.state_age() < 0.0) return false;
  switch (arm.state().cause().kind()) {
    case msg::CauseKind::CAUSE_MODE_UNKNOWN:
    case msg::CauseKind::CAUSE_HOLD_ORDERED:
    case msg::CauseKind::CAUSE_STOP_ORDERED:
    case msg::CauseKind::CAUSE_HELD_BY_FAULT:
      return true;
    default:
      return false;
  }
}

/// The status once the drivers of all resumed arms report that no order holds them, or after kReleaseLimit.
msg::CellStatus await_release(const Settings& settings, const std::vector<std::string>& arms) {
  constexpr std::chrono::seconds kReleaseLimit{1};
  constexpr std::chrono::milliseconds kBetween{20};
  const Connection cell = connect(settings);
  const auto until = std::chrono::steady_clock::now() + kReleaseLimit;
  while (true) {
    msg::CellStatus status = cell->status(answer_limit(settings));
    const bool held = std::any_of(status.arms().begin(), status.arms().end(),
                                  [&](const msg::ArmStatus& arm) { return concerns(arms, arm) && is_still_held(arm); });
    if (!held || std::chrono::steady_clock::now() >= until) return status;
    std::this_thread::sleep_for(kBetween);
  }
}

/// What an arm does now: "west: waits for a goal; the last was reached".
std::string arm_text(const msg::ArmStatus& arm) {
  const std::string why = waiting_text(arm);
  if (why.empty()) return arm.arm() + ": moves";
  const bool idle = arm.waiting_for().kind() == msg::CauseKind::CAUSE_NO_GOAL;
  return arm.arm() + (idle ? ": waits for " : ": stands: ") + why;
}

/// Prints the cell mode and what the resumed arms do. An arm that its driver still holds is a failure.
void print_resumed(const Settings& settings, const msg::CellStatus& status, const std::vector<std::string>& arms) {
  Json json = to_json(status.mode());
  std::string table = mode_text(status, Palette::for_stream(stdout));
  std::string held;
  json["arms"] = Json::array();
  for (const msg::ArmStatus& arm : status.arms()) {
    if (!concerns(arms, arm)) continue;
    json["arms"].push_back({{"name", arm.arm()}, {"waiting_for", to_json(arm.waiting_for())}});
    table += arm_text(arm) + "\n";
    if (is_still_held(arm)) held += (held.empty() ? "" : "; ") + arm.arm() + ": " + arm.state().cause().text();
  }
  print(settings, json, table);
  if (held.empty()) return;
  throw Failure(ExitCode::kNegative,
                "the supervisor has accepted the order, but the drivers still hold these arms: " + held);
}

/// An order without a reply fails: it may not have been obeyed.
msg::SupervisorReply order(const Settings& settings, msg::RequestKind kind, const std::vector<std::string>& arms) {
  try {
    const Connection cell = connect(settings);
    require_arms(cell->status(answer_limit(settings)), arms);
    return cell->order(kind, arms, answer_limit(settings));
  } catch (const Unreachable& unreachable) {
    throw Failure(ExitCode::kUnreachable, "the order was not obeyed, and arms may still move: looked for " +
                                              unreachable.reason().looked_for + ", but " +
                                              failure_of(unreachable).what());
  }
}

ExitCode run_mode(const Settings& settings, msg::RequestKind kind, const std::vector<std::string>& arms) {
  const msg::SupervisorReply reply = order(settings, kind, arms);
  if (!reply.done()) throw Failure(ExitCode::kNegative, reply.cause().text());
  if (!is_none(reply.cause())) std::fprintf(stderr, "done, but %s\n", reply.cause().text().c_str());
  if (kind != msg::RequestKind::REQUEST_RESUME) {
    print(settings, to_json(reply.status().mode()), mode_text(reply.status(), Palette::for_stream(stdout)));
    return ExitCode::kDone;
  }
  if (arms.empty()) print_unresumed(reply.status().mode());
  print_resumed(settings, await_release(settings, arms), arms);
  return ExitCode::kDone;
}

void add_mode(CLI::App& app, Session& session, const char* name, const char* description, msg::RequestKind kind) {
  CLI::App* command = app.add_subcommand(name, description);
  auto arms = std::make_shared<std::vector<std::string>>();
  command->add_option("ARM", *arms, "names of arms (the whole cell)");
  command->footer("No safety function: only the emergency stop of the robots protects people.");
  command->callback([&session, arms, kind] {
    session.action = on_cell([&session, arms, kind] { return run_mode(session.settings, kind, *arms); });
  });
}

}  // namespace

void add_mode_commands(CLI::App& app, Session& session) {
  add_mode(app, session, "hold", "Brakes the cell or some arms; goals are kept until resume",
           msg::RequestKind::REQUEST_HOLD);
  add_mode(app, session, "resume",
           "Lets the cell or some arms move again; arms that were stopped by name or by their device must be named",
           msg::RequestKind::REQUEST_RESUME);
  add_mode(app, session, "stop", "Brakes the cell or some arms and latches it until resume",
           msg::RequestKind::REQUEST_STOP);
}

}  // namespace hecaton::services::cli
