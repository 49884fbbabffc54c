/// hecaton wait: returns when one of the named outcomes has come for an arm.

#include <cstdio>
#include <memory>
#include <optional>
#include <set>

#include <CLI/CLI.hpp>

#include "services/cli/commands.hpp"
#include "services/cli/goals.hpp"
#include "services/cli/message_text.hpp"
#include "services/cli/status_json.hpp"
#include "services/command_line/choice_option.hpp"
#include "services/command_line/failure.hpp"
#include "services/command_line/quantities.hpp"
#include "services/runtime/told_faults.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kFault = "fault";
const std::vector<std::string> kOutcomes = {"reached",   "blocked",  "rejected", "cancelled",
                                            "timed_out", "replaced", kFault};

struct Options {
  std::string arm;
  std::vector<std::string> outcomes = {"reached"};
  double timeout = 30.0;  // [s]
};

/// What has come, for the exit code and for printing.
struct Outcome {
  ExitCode code;
  Json json;
  std::string text;
};

class Waiter {
 public:
  Waiter(Client& client, const Options& options, const msg::CellStatus& cell)
      : client_(client),
        options_(options),
        wanted_(options.outcomes.begin(), options.outcomes.end()),
        goals_(client),
        faults_(client.participant(), &client.mailbox()) {
    const msg::ArmStatus& arm = require_arm(cell, options.arm);
    if (arm.has_goal()) newest_ = arm.goal();
    subjects_ = {options.arm, arm.planner()};
    for (const msg::NodeStatus& node : cell.nodes()) {
      if (node.heartbeat().subject() == options.arm) subjects_.insert(node.heartbeat().node());
    }
    subjects_.erase("");
    for (const msg::Fault& fault : cell.faults()) note(fault);
  }

  std::optional<Outcome> run() {
    const auto until = bus::Clock::now() + seconds(options_.timeout);
    while (true) {
      for (const msg::GoalStatus& status : goals_.news()) {
        if (status.arm() != options_.arm) continue;
        // Old goal and new one may be told in either order: "replaced" only counts when it is waited for.
        if (status.state() == msg::GoalState::GOAL_REPLACED && wanted_.count("replaced") == 0) continue;
        if (!newest_ || is_later(status, *newest_)) newest_ = status;
      }
      for (const auto& sample : faults_.take()) {
        if (!sample.disposed && told_.hear(sample.value)) note(sample.value);
      }
      if (auto outcome = judge()) return outcome;
      const auto left = until - bus::Clock::now();
      if (left <= bus::Clock::duration::zero()) return std::nullopt;
      [[maybe_unused]] const bool woken = client_.mailbox().wait(left);
    }
  }

  [[nodiscard]] std::string now() const { return newest_ ? "its goal is " + goal_text(*newest_) : "it has no goal"; }

 private:
  void note(const msg::Fault& fault) {
    if (!fault.cleared() && subjects_.count(fault.cause().subject()) > 0) fault_ = fault;
    if (fault.cleared() && fault_ && fault_->id() == fault.id()) fault_.reset();
  }

  [[nodiscard]] std::optional<Outcome> judge() const {
    if (fault_ && wanted_.count(kFault) > 0) {
      return Outcome{ExitCode::kDone,
                     {{"arm", options_.arm}, {"outcome", kFault}, {"fault", to_json(*fault_)}},
                     "fault: " + fault_->cause().text()};
    }
    if (!newest_) return std::nullopt;
    const std::string state = text(newest_->state());
    const Json json{{"arm", options_.arm}, {"outcome", state}, {"goal", to_json(*newest_)}};
    if (wanted_.count(state) > 0) return Outcome{ExitCode::kDone, json, goal_text(*newest_)};
    if (!is_final(newest_->state()) || wanted_.count(kFault) > 0) return std::nullopt;
    return Outcome{ExitCode::kNegative, json, goal_text(*newest_)};
  }

  Client& client_;
  const Options& options_;
  std::set<std::string, std::less<>> wanted_;
  Goals goals_;
  bus::Reader<msg::Fault> faults_;
  ToldFaults told_;
  std::set<std::string, std::less<>> subjects_;  ///< the arm and the nodes that serve it
  std::optional<msg::GoalStatus> newest_;
  std::optional<msg::Fault> fault_;
};

ExitCode run(const Settings& settings, const Options& options) {
  Client client(settings);
  Waiter waiter(client, options, client.status());
  const auto outcome = waiter.run();
  if (!outcome) {
    throw Failure(ExitCode::kTimeOut, "arm '" + options.arm + "': none of " +
                                          CLI::detail::join(options.outcomes, ", ") + " within " +
                                          duration_text(options.timeout) + "; " + waiter.now());
  }
  print(settings, outcome->json, options.arm + ": " + outcome->text + "\n");
  return outcome->code;
}

}  // namespace

void add_wait(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("wait", "Waits until one of the named outcomes has come for an arm");
  auto options = std::make_shared<Options>();
  command->add_option("ARM", options->arm, "name of the arm")->required();
  add_choices(*command, "--for", options->outcomes, kOutcomes,
              "outcomes, separated by commas: whichever comes first (reached)");
  add_duration(*command, "--timeout", options->timeout, "how long to wait (30s)", 0.0, 86400.0);
  command->footer("Exit code 0: one of them came; 1: the goal ended otherwise; 4: time-out.");
  command->callback(
      [&session, options] { session.action = [&session, options] { return run(session.settings, *options); }; });
}

}  // namespace hecaton::services::cli
