#include "services/cli/task_rounds.hpp"

#include <algorithm>
#include <utility>

#include "services/cli/cell_access.hpp"
#include "services/cli/status_output.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services::cli {
namespace {

using namespace std::chrono_literals;

constexpr auto kShowPeriod = 200ms;
/// For the planner to end a goal after its time limit.
constexpr auto kOverdueLimit = 3s;
/// When all open goals are blocked for this long, the round ends; simulate has the same limit.
constexpr auto kStallTimeout = 10s;

std::string outcome_of(msg::GoalState state) {
  switch (state) {
    case msg::GoalState::GOAL_REACHED:
      return "reached";
    case msg::GoalState::GOAL_TIMED_OUT:
      return "timed_out";
    default:
      return "blocked";
  }
}

/// Of a task that was not reached.
std::string reason_of(const Task& task) {
  if (!task.status) return "its planner has not answered";
  const std::string reason = reason_text(*task.status);
  return reason.empty() ? "still on its way at the time limit" : reason;
}

}  // namespace

TaskRounds::TaskRounds(RunningCell& cell, const Options& options, Callbacks callbacks)
    : cell_(cell),
      options_(options),
      callbacks_(std::move(callbacks)),
      generator_(cell.file().cell),
      random_(options.seed) {
  tally_.seed = options.seed;
  tally_.asked = options.tasks;
  for (const planner::PlannedArm& planned : cell.file().cell.arms) {
    ArmReport arm;
    arm.name = planned.arm.name;
    tally_.arms.push_back(std::move(arm));
  }
}

void TaskRounds::run() {
  while (tally_.tasks < options_.tasks && !cell_.interrupted()) {
    if (!start_round()) return;
    const auto limit = client::deadline_of(Seconds(cell_.file().cell.tasks.time_limit) + kOverdueLimit);
    auto show_at = client::Clock::now();
    while (!round_is_over() && !cell_.interrupted()) {
      update();
      const auto now = client::Clock::now();
      cancel_when_stalled(now);
      if (now > limit) {
        for (Task& task : round_) end(task, "timed_out");
      }
      if (now >= show_at) {
        static_cast<void>(cell_.poll());
        callbacks_.show();
        show_at = now + kShowPeriod;
      }
      const auto changed = [this] {
        update();
        return round_is_over() || cell_.interrupted();
      };
      static_cast<void>(cell_.connection().wait_until(changed, show_at - client::Clock::now()));
    }
    static_cast<void>(cell_.poll());
    if (round_is_over()) callbacks_.tell(round_text());
  }
}

bool TaskRounds::start_round() {
  const auto drawn = generator_.draw_conflicting_goals(random_, measured());
  if (!drawn) {
    tally_.not_drawn = options_.tasks - tally_.tasks;
    tally_.findings.push_back({config::Severity::kError, cell_.file().path + ": tasks: " + generator_.shortage()});
    return false;
  }
  ++rounds_;
  round_.clear();
  stalled_since_.reset();
  for (std::size_t i = 0; i < drawn->size(); ++i) {
    Task task;
    msg::Goal goal;
    goal.arm(tally_.arms[i].name);
    goal.kind(msg::GoalKind::GOAL_JOINTS);
    goal.q(messages::to_message((*drawn)[i]));
    goal.time_limit(cell_.file().cell.tasks.time_limit);
    task.goal = cell_.connection().send(std::move(goal));
    task.counted = given_ < options_.tasks;
    if (task.counted) ++given_;
    round_.push_back(std::move(task));
  }
  return true;
}

planner::CellConfiguration TaskRounds::measured() const {
  planner::CellConfiguration q;
  for (const ArmReport& arm : tally_.arms) {
    const msg::ArmStatus& status = require_arm(cell_.status(), arm.name);
    const auto joints = messages::joints_from_message(status.state().q(), "state of " + arm.name);
    if (!joints) throw Failure(ExitCode::kNegative, joints.error);
    q.push_back(*joints);
  }
  return q;
}

void TaskRounds::update() {
  for (Task& task : round_) {
    task.status = cell_.connection().status_of(*task.goal);
    if (task.status && is_final(task.status->state())) end(task, outcome_of(task.status->state()));
  }
}

void TaskRounds::cancel_when_stalled(client::Clock::time_point now) {
  const bool stalled = std::all_of(round_.begin(), round_.end(), [](const Task& task) {
    return task.ended || (task.status && task.status->state() == msg::GoalState::GOAL_BLOCKED);
  });
  if (!stalled) {
    stalled_since_.reset();
    return;
  }
  if (!stalled_since_) stalled_since_ = now;
  if (now < *stalled_since_ + kStallTimeout) return;
  for (Task& task : round_) {
    if (!task.ended) cell_.connection().cancel(*task.goal);
    end(task, "blocked");
  }
}

void TaskRounds::end(Task& task, const std::string& outcome) {
  if (task.ended) return;
  task.ended = true;
  task.outcome = outcome;
  if (!task.counted) return;
  const auto arm = std::find_if(tally_.arms.begin(), tally_.arms.end(),
                                [&](const ArmReport& known) { return known.name == task.goal->goal.arm(); });
  ++tally_.tasks;
  ++arm->tasks;
  if (outcome == "reached") {
    ++tally_.reached;
    ++arm->reached;
    tally_.times.push_back(task.status->elapsed());
    return;
  }
  int& total = outcome == "blocked" ? tally_.blocked : tally_.timed_out;
  int& of_arm = outcome == "blocked" ? arm->blocked : arm->timed_out;
  ++total;
  ++of_arm;
  tally_.missed.push_back({rounds_, task.goal->goal.arm(), outcome, task.goal->goal.q(), reason_of(task)});
}

bool TaskRounds::round_is_over() const {
  return std::all_of(round_.begin(), round_.end(), [](const Task& task) { return task.ended; });
}

std::string TaskRounds::round_text() const {
  std::string text = "round " + std::to_string(rounds_) + ":";
  for (const Task& task : round_) {
    text += " " + task.goal->goal.arm() + " " + (task.outcome == "timed_out" ? "timed out" : task.outcome);
    if (task.status) text += " in " + duration_text(task.status->elapsed());
    if (task.outcome == "blocked" && task.status) text += " (" + goal_text(*task.status) + ")";
    text += ",";
  }
  text.back() = ';';
  text += " " + std::to_string(tally_.reached) + " of " + std::to_string(options_.tasks) + " tasks reached";
  if (cell_.status().has_contact_report()) text += ", " + contact_text(cell_.status().contact_report(), Palette(false));
  return text;
}

}  // namespace hecaton::services::cli
