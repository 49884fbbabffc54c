/// hecaton goal: gives one arm a goal, and waits for what becomes of it when asked to.

#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/message_text.hpp"
#include "services/cli/status_json.hpp"
#include "services/command_line/failure.hpp"
#include "services/command_line/quantities.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services::cli {
namespace {

using namespace std::chrono_literals;

/// A planner must have said whether it takes the goal: inverse kinematics included.
constexpr auto kAnswer = 5s;
/// How often to look why the arm does not get on.
constexpr auto kLook = 1s;
constexpr auto kLookLimit = 500ms;
/// Silence of the whole cell after which waiting makes no sense.
constexpr auto kGone = 5s;
/// The planner ends a goal at its time limit; this much later we do not count on it any more.
constexpr auto kOverdue = 2s;

struct Options {
  std::string arm;
  std::vector<double> joints;
  std::string named;
  std::vector<double> pose;
  bool wait = false;
  double time_limit = 0.0;  // [s]; 0: none
};

void fill(msg::Goal& goal, const Options& options) {
  goal.time_limit(options.time_limit);
  if (!options.joints.empty()) {
    goal.kind(msg::GoalKind::GOAL_JOINTS);
    goal.q(options.joints);
  } else if (!options.named.empty()) {
    goal.kind(msg::GoalKind::GOAL_NAMED);
    goal.named(options.named);
  } else {
    goal.kind(msg::GoalKind::GOAL_POSE);
    goal.X_WT(messages::to_message(pose_of(options.pose)));
  }
}

/// Follows one goal from sending to its end.
class Follower {
 public:
  Follower(client::Connection& cell, const Options& options) : cell_(cell), options_(options) {
    msg::Goal goal;
    goal.arm(options.arm);
    fill(goal, options);
    goal_ = cell.send(std::move(goal));
  }

  msg::GoalStatus run() {
    const auto sent = goal_->sent;
    last_answer_ = sent;
    while (!cell_.wait_until([this] { return take_news(); }, kLook)) {
      const auto now = client::Clock::now();
      if (!status_ && !warned_ && now > sent + kAnswer) warn();
      if (options_.time_limit > 0.0 && Seconds(now - sent) > Seconds(options_.time_limit) + kOverdue) {
        throw Failure(ExitCode::kTimeOut,
                      "arm '" + options_.arm + "' did not end its goal in time" + (told_.empty() ? "" : ": " + told_));
      }
      if (status_ || warned_) look(now);
    }
    return *status_;
  }

 private:
  /// True: nothing more is waited for.
  bool take_news() {
    const auto status = cell_.status_of(*goal_);
    if (!status) return false;
    const auto now = client::Clock::now();
    const bool first = !status_;
    if (first || client::is_later(*status, *status_)) last_answer_ = now;
    status_ = status;
    if (is_final(status->state()) || !options_.wait) return true;
    if (first || status->state() != told_state_ || now > told_at_ + kLook) {
      told_state_ = status->state();
      tell(goal_text(*status));
    }
    return false;
  }

  /// A goal reaches a planner that was cut off as soon as it is back, for as long as this client waits.
  void warn() {
    if (!options_.wait) {
      throw Failure(ExitCode::kTimeOut, "the planner of arm '" + options_.arm + "' has not answered the goal");
    }
    warned_ = true;
    tell("its planner has not answered yet");
  }

  void tell(const std::string& text) {
    if (text == told_) return;
    told_ = text;
    told_at_ = client::Clock::now();
    std::fprintf(stderr, "%s: %s\n", options_.arm.c_str(), text.c_str());
  }

  /// The supervisor knows why an arm stands that its planner would move: held, stopped, a fault.
  void look(client::Clock::time_point now) {
    if (const auto cell = cell_.poll_status(kLookLimit)) {
      last_answer_ = now;
      for (const msg::ArmStatus& arm : cell->arms()) {
        const msg::Cause& cause = arm.waiting_for();
        // Its planner has told it.
        const bool of_goal = status_ && (is_about_goal(cause.kind()) || cause.kind() == status_->cause().kind());
        if (arm.arm() == options_.arm && !of_goal && !is_none(cause)) tell(cause.text());
      }
    } else if (now > last_answer_ + kGone) {
      throw Failure(ExitCode::kUnreachable, "the cell no longer answers");
    }
  }

  client::Connection& cell_;
  const Options& options_;
  std::shared_ptr<client::GoalRecord> goal_;
  std::optional<msg::GoalStatus> status_;
  bool warned_ = false;  ///< that it is not answered
  std::string told_;
  msg::GoalState told_state_ = msg::GoalState::GOAL_ACCEPTED;
  client::Clock::time_point told_at_;
  client::Clock::time_point last_answer_;
};

ExitCode run(const Settings& settings, const Options& options) {
  const Connection cell = connect(settings);
  static_cast<void>(require_arm(cell->status(answer_limit(settings)), options.arm));
  const msg::GoalStatus status = Follower(*cell, options).run();
  const std::string after = options.wait && is_final(status.state()) && status.state() != msg::GoalState::GOAL_REJECTED
                                ? " after " + duration_text(status.elapsed())
                                : "";
  print(settings, to_json(status), options.arm + ": " + goal_text(status) + after + "\n");
  const bool open = !is_final(status.state());
  return open ? ExitCode::kDone : outcome_code(status);
}

}  // namespace

void add_goal(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("goal", "Gives an arm a goal; a later goal replaces an earlier one");
  auto options = std::make_shared<Options>();
  command->add_option("ARM", options->arm, "name of the arm")->required();
  CLI::Option_group* what = command->add_option_group("goal", "one of");
  add_numbers(*what, "--joints", options->joints, 0, "joint positions, base to tip [rad or m]");
  what->add_option("--named", options->named, "a pose that the cell file names, e.g. home")->type_name("POSE");
  add_pose(*what, "--pose", options->pose, "of the tool frame: x y z [m] roll pitch yaw [rad]");
  what->require_option(1);
  command->add_flag("--wait", options->wait,
                    "wait until the goal has ended; an arm that is blocked says why and goes on looking for a way");
  add_duration(*command, "--time-limit", options->time_limit, "after which the planner gives up (none)", 0.001,
               86400.0);
  command->footer("Exit code 0: accepted, or reached with --wait; 1: rejected, replaced or cancelled; 4: time limit.");
  command->callback([&session, options] {
    session.action = on_cell([&session, options] { return run(session.settings, *options); });
  });
}

}  // namespace hecaton::services::cli
