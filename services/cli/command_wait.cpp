/// hecaton wait: returns at the first of the named outcomes of an arm.

#include <cstdio>
#include <memory>
#include <optional>
#include <set>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/status_output.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kFault = "fault";
const std::vector<std::string> kOutcomes = {"reached",   "blocked",  "rejected", "cancelled",
                                            "timed_out", "replaced", kFault};

struct WaitOptions {
  std::string arm;
  std::vector<std::string> outcomes = {"reached"};
  double timeout = 30.0;  // [s]
};

struct Outcome {
  ExitCode code;
  Json json;
  std::string text;
};

class Waiter {
 public:
  Waiter(client::Connection& cell, const WaitOptions& options, const msg::CellStatus& status)
      : cell_(cell), options_(options), wanted_(options.outcomes.begin(), options.outcomes.end()) {
    const msg::ArmStatus& arm = require_arm(status, options.arm);
    subjects_ = {options.arm, arm.planner()};
    for (const msg::NodeStatus& node : status.nodes()) {
      if (node.heartbeat().subject() == options.arm) subjects_.insert(node.heartbeat().node());
    }
    subjects_.erase("");
  }

  std::optional<Outcome> run() {
    std::optional<Outcome> outcome;
    static_cast<void>(cell_.wait_until(
        [&] {
          update();
          return (outcome = judge()).has_value();
        },
        Seconds(options_.timeout)));
    return outcome;
  }

  [[nodiscard]] std::string present() const {
    return newest_ ? "its goal is " + goal_text(*newest_) : "it has no goal";
  }

 private:
  void update() {
    if (const auto status = cell_.newest_goal(options_.arm)) {
      const bool later_goal = newest_ && newest_->goal() != status->goal() && !is_final(newest_->state());
      if (later_goal) replaced_ = newest_;
      if (replaced_) replaced_->state(msg::GoalState::GOAL_REPLACED);
      newest_ = status;
    }
    fault_.reset();
    for (const msg::Fault& fault : cell_.faults()) {
      if (!fault.cleared() && subjects_.count(fault.cause().subject()) > 0) fault_ = fault;
    }
  }

  [[nodiscard]] std::optional<Outcome> judge() const {
    if (fault_ && wanted_.count(kFault) > 0) {
      return Outcome{ExitCode::kDone,
                     {{"arm", options_.arm}, {"outcome", kFault}, {"fault", to_json(*fault_)}},
                     "fault: " + fault_->cause().text()};
    }
    const auto& goal = replaced_ && wanted_.count("replaced") > 0 ? replaced_ : newest_;
    if (!goal) return std::nullopt;
    const std::string state = text(goal->state());
    const Json json{{"arm", options_.arm}, {"outcome", state}, {"goal", to_json(*goal)}};
    if (wanted_.count(state) > 0) return Outcome{ExitCode::kDone, json, goal_text(*goal)};
    if (!is_final(goal->state()) || wanted_.count(kFault) > 0) return std::nullopt;
    return Outcome{ExitCode::kNegative, json, goal_text(*goal)};
  }

  client::Connection& cell_;
  const WaitOptions& options_;
  std::set<std::string, std::less<>> wanted_;
  std::set<std::string, std::less<>> subjects_;  ///< the arm and the nodes that serve it
  std::optional<msg::GoalStatus> newest_;
  std::optional<msg::GoalStatus> replaced_;  ///< a goal that a later goal has replaced during the wait
  std::optional<msg::Fault> fault_;
};

ExitCode run_wait(const Settings& settings, const WaitOptions& options) {
  const Connection cell = connect(settings);
  Waiter waiter(*cell, options, cell->status(answer_limit(settings)));
  const auto outcome = waiter.run();
  if (!outcome) {
    throw Failure(ExitCode::kTimeOut, "arm '" + options.arm + "': none of " +
                                          CLI::detail::join(options.outcomes, ", ") + " within " +
                                          duration_text(options.timeout) + "; " + waiter.present());
  }
  print(settings, outcome->json, options.arm + ": " + outcome->text + "\n");
  return outcome->code;
}

}  // namespace

void add_wait(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("wait", "Waits for the first of the named outcomes of an arm");
  auto options = std::make_shared<WaitOptions>();
  command->add_option("ARM", options->arm, "name of the arm")->required();
  add_choices(*command, "--for", options->outcomes, kOutcomes, "outcomes, separated by commas (reached)");
  add_duration(*command, "--timeout", options->timeout, "time limit (30s)", 0.0, 86400.0);
  command->footer("Exit code 0: one of the outcomes; 1: the goal ended otherwise; 4: time-out.");
  command->callback([&session, options] {
    session.action = on_cell([&session, options] { return run_wait(session.settings, *options); });
  });
}

}  // namespace hecaton::services::cli
