/// hecaton goal: gives one arm a goal and, with --wait or --watch, waits for its end.

#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/status_output.hpp"
#include "services/cli/tool_goal_options.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services::cli {
namespace {

using namespace std::chrono_literals;

constexpr auto kAcceptLimit = 5s;    // for the planner to accept or reject the goal, with inverse kinematics
constexpr auto kPollPeriod = 1s;     // of the supervisor, for the reason why the arm waits
constexpr auto kPollLimit = 500ms;   // for one reply
constexpr auto kSilenceLimit = 5s;   // of the whole cell
constexpr auto kOverdueAnswer = 2s;  // for the planner to end a goal after its time limit

struct GoalOptions {
  std::string arm;
  std::vector<double> joints;
  std::string named;
  ToolGoalOptions tool;
  bool wait = false;
  bool watch = false;       ///< wait, and print each status
  double time_limit = 0.0;  // [s]; 0: none
};

void fill(msg::Goal& goal, const GoalOptions& options) {
  goal.time_limit(options.time_limit);
  if (!options.joints.empty()) {
    goal.kind(msg::GoalKind::GOAL_JOINTS);
    goal.q(options.joints);
  } else if (!options.named.empty()) {
    goal.kind(msg::GoalKind::GOAL_NAMED);
    goal.named(options.named);
  } else {
    goal.kind(msg::GoalKind::GOAL_POSE);
    goal.tool(messages::to_message(tool_goal_of(options.tool).value()));
  }
}

/// `more`: behind the text of a table. A status of --watch is a document: a line of JSON.
void print_status(const Settings& settings, const GoalOptions& options, const msg::GoalStatus& status,
                  const std::string& more = "") {
  if (options.watch && settings.format() == OutputFormat::kJson) {
    std::printf("%s\n", to_json(status).dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
    std::fflush(stdout);
  } else {
    if (options.watch && settings.format() == OutputFormat::kYaml) std::printf("---\n");
    print(settings, to_json(status), options.arm + ": " + goal_text(status) + more + "\n");
  }
}

/// Sends one goal and follows it to its end.
class GoalFollower {
 public:
  GoalFollower(client::Connection& cell, const Settings& settings, const GoalOptions& options)
      : cell_(cell), settings_(settings), options_(options) {
    msg::Goal goal;
    goal.arm(options.arm);
    fill(goal, options);
    goal_ = cell.send(std::move(goal));
  }

  msg::GoalStatus run() {
    const auto sent = goal_->sent;
    last_answer_ = sent;
    while (!cell_.wait_until([this] { return update(); }, kPollPeriod)) {
      const auto now = client::Clock::now();
      if (!status_ && !warned_ && now > sent + kAcceptLimit) warn();
      if (options_.time_limit > 0.0 && Seconds(now - sent) > Seconds(options_.time_limit) + kOverdueAnswer) {
        throw Failure(ExitCode::kTimeOut, "arm '" + options_.arm + "' did not end its goal within its time limit" +
                                              (printed_.empty() ? "" : ": " + printed_));
      }
      if (status_ || warned_) poll(now);
    }
    return *status_;
  }

 private:
  /// True: the wait is over.
  bool update() {
    const auto status = cell_.status_of(*goal_);
    if (!status) return false;
    const auto now = client::Clock::now();
    const bool first = !status_;
    const bool later = first || client::is_later(*status, *status_);
    if (later) last_answer_ = now;
    status_ = status;
    if (is_final(status->state()) || !options_.wait) return true;
    if (options_.watch) {
      if (later) print_status(settings_, options_, *status);
      return false;
    }
    if (first || status->state() != printed_state_ || now > printed_at_ + kPollPeriod) {
      printed_state_ = status->state();
      print_change(goal_text(*status));
    }
    return false;
  }

  /// While this client waits, the goal also reaches a planner that becomes reachable later.
  void warn() {
    if (!options_.wait) {
      throw Failure(ExitCode::kTimeOut, "the planner of arm '" + options_.arm + "' has not answered the goal within " +
                                            duration_text(Seconds(kAcceptLimit).count()));
    }
    warned_ = true;
    print_change("its planner has not answered yet");
  }

  void print_change(const std::string& text) {
    if (text == printed_) return;
    printed_ = text;
    printed_at_ = client::Clock::now();
    std::fprintf(stderr, "%s: %s\n", options_.arm.c_str(), text.c_str());
  }

  /// The supervisor knows why an arm stands although its planner would move it: held, stopped, or a fault.
  void poll(client::Clock::time_point now) {
    if (const auto cell = cell_.poll_status(kPollLimit)) {
      last_answer_ = now;
      for (const msg::ArmStatus& arm : cell->arms()) {
        const msg::Cause& cause = arm.waiting_for();
        // The goal's own status has printed this cause.
        const bool of_goal = status_ && (is_about_goal(cause.kind()) || cause.kind() == status_->cause().kind());
        if (arm.arm() == options_.arm && !of_goal && !is_none(cause)) print_change(cause.text());
      }
    } else if (now > last_answer_ + kSilenceLimit) {
      throw Failure(ExitCode::kUnreachable,
                    "the cell has not answered for " + duration_text(Seconds(kSilenceLimit).count()));
    }
  }

  client::Connection& cell_;
  const Settings& settings_;
  const GoalOptions& options_;
  std::shared_ptr<client::GoalRecord> goal_;
  std::optional<msg::GoalStatus> status_;
  bool warned_ = false;  ///< that no planner has answered
  std::string printed_;  ///< last
  msg::GoalState printed_state_ = msg::GoalState::GOAL_ACCEPTED;
  client::Clock::time_point printed_at_;
  client::Clock::time_point last_answer_;
};

/// For a final status.
ExitCode outcome_code(const msg::GoalStatus& status) {
  switch (status.state()) {
    case msg::GoalState::GOAL_REACHED:
      return ExitCode::kDone;
    case msg::GoalState::GOAL_TIMED_OUT:
      return ExitCode::kTimeOut;
    default:
      return ExitCode::kNegative;
  }
}

ExitCode run_goal(const Settings& settings, const GoalOptions& options) {
  const Connection cell = connect(settings);
  static_cast<void>(require_arm(cell->status(answer_limit(settings)), options.arm));
  const msg::GoalStatus status = GoalFollower(*cell, settings, options).run();
  if (!status.note().empty()) std::fprintf(stderr, "note: %s\n", status.note().c_str());
  if (status.cause().kind() == msg::CauseKind::CAUSE_GOAL_ORIENTATION) {
    std::fprintf(stderr,
                 "give an orientation that the arm can take, a free axis (--free), a wider --tolerance, or --position "
                 "for any orientation\n");
  }
  const std::string after = options.wait && is_final(status.state()) && status.state() != msg::GoalState::GOAL_REJECTED
                                ? " after " + duration_text(status.elapsed())
                                : "";
  print_status(settings, options, status, after);
  const bool open = !is_final(status.state());
  return open ? ExitCode::kDone : outcome_code(status);
}

}  // namespace

void add_goal(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("goal", "Gives an arm a goal; a later goal replaces an earlier one");
  auto options = std::make_shared<GoalOptions>();
  command->add_option("ARM", options->arm, "name of the arm")->required();
  CLI::Option_group* what = command->add_option_group("goal", "one of");
  add_numbers(*what, "--joints", options->joints, 0, "joint positions, base to tip [rad or m]");
  what->add_option("--named", options->named, "a named pose of the cell file, e.g. home")->type_name("POSE");
  add_tool_goal_options(*command, *what, options->tool);
  what->require_option(1);
  command->add_flag("--wait", options->wait,
                    "wait until the goal has ended, and print why the arm is blocked meanwhile");
  command->add_flag("-w,--watch", options->watch, "as --wait, and print each status, ten a second; JSON: one a line");
  add_duration(*command, "--time-limit", options->time_limit, "after which the planner ends the goal (none)", 0.001,
               86400.0);
  command->callback([&session, options, command] {
    check_tool_goal_options(*command);
    options->wait = options->wait || options->watch;
    session.action = on_cell([&session, options] { return run_goal(session.settings, *options); });
  });
  command->footer(
      "A pose is reached when the measured tool is within the tolerance of its position and orientation. An arm that\n"
      "cannot take the orientation, such as most with fewer than six joints, rejects the goal and names the nearest "
      "one.\n"
      "Exit code 0: accepted, or reached with --wait; 1: rejected, replaced or cancelled; 4: time limit.");
}

}  // namespace hecaton::services::cli
