#include "services/cli/goals.hpp"

#include <tuple>
#include <utility>

#include "services/cli/message_text.hpp"
#include "services/command_line/failure.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services::cli {

bool is_later(const msg::GoalStatus& a, const msg::GoalStatus& b) {
  // Stamps of one term come from one host's clock, also when the planner was restarted there and counts anew.
  return std::tuple(a.term(), a.stamp_ns(), a.sequence_number()) >
         std::tuple(b.term(), b.stamp_ns(), b.sequence_number());
}

Goals::Goals(Client& client)
    : client_(client), goals_(client.participant()), statuses_(client.participant(), &client.mailbox()) {}

msg::Goal Goals::draft(const std::string& arm) {
  msg::Goal goal;
  goal.arm(arm);
  goal.client(client_.name());
  goal.goal(client_.name() + "/" + std::to_string(++sequence_));
  return goal;
}

void Goals::send(const msg::Goal& goal) {
  msg::Goal stamped = goal;
  stamped.sequence_number(++sequence_);
  stamped.stamp_ns(stamp_now());
  if (const auto result = goals_.write(stamped); !result) {
    throw Failure(ExitCode::kUnreachable, "the goal could not be sent: " + result.reason);
  }
}

void Goals::cancel(const msg::Goal& goal) {
  msg::Goal withdrawn = goal;
  withdrawn.cancel(true);
  send(withdrawn);
}

std::vector<msg::GoalStatus> Goals::news() {
  std::vector<msg::GoalStatus> statuses;
  for (auto& sample : statuses_.take()) {
    if (!sample.disposed) statuses.push_back(std::move(sample.value));
  }
  return statuses;
}

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

}  // namespace hecaton::services::cli
