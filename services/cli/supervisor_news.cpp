#include "services/cli/supervisor_news.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "services/runtime/node_name.hpp"

namespace hecaton::services::cli {
namespace {

bool is_supervisor(const std::string& node) {
  return node == supervisor_node() || node.starts_with(standby_node(supervisor_node(), {}));
}

std::string called(const std::string& node) {
  return node.empty() || node == supervisor_node() ? "the supervisor" : node;
}

/// Of the process that answers; 0 where it has not heard its own heartbeat yet.
std::int32_t pid_of(const msg::CellStatus& status) {
  const auto& nodes = status.nodes();
  const auto own = std::find_if(nodes.begin(), nodes.end(), [&](const msg::NodeStatus& node) {
    return node.heartbeat().node() == status.supervisor();
  });
  return own == nodes.end() ? 0 : own->heartbeat().pid();
}

}  // namespace

std::string SupervisorStory::process(const msg::ProcessEvent& event, bus::Clock::time_point now) {
  const bool died = event.kind() == msg::ProcessEventKind::PROCESS_EXITED && !event.wanted();
  if (!died || leader_.empty() || !is_supervisor(event.node())) return {};
  if (event.node() == standby_) standby_.clear();
  const bool led = event.node() == leader_ && (pid_ == 0 || pid_ == event.pid());
  // Of who does not lead the leader tells it, as a fault: if there is one.
  if (!led && !died_) return {};
  if (led) died_ = Death{event.pid(), now};
  return called(event.node()) + " died (process " + std::to_string(event.pid()) +
         (event.signal_number() != 0 ? ", signal " + std::to_string(event.signal_number())
                                     : ", exit code " + std::to_string(event.exit_code())) +
         "): arms go on, " +
         (standby_.empty() ? "faults and orders wait for its successor" : called(standby_) + " takes over");
}

std::string SupervisorStory::answer(const msg::CellStatus* status, bus::Clock::time_point now) {
  if (status == nullptr) {
    if (died_ || std::exchange(silent_, true)) return {};
    return called(leader_) + " does not answer: arms go on, faults and orders wait for it" +
           (standby_.empty() ? "" : " or " + called(standby_));
  }
  if (is_of_dead(*status, now)) return {};
  const std::string before = std::exchange(leader_, status->supervisor());
  const std::int32_t pid = pid_of(*status);
  const bool another = !before.empty() && leader_ != before;
  const bool died = std::exchange(died_, std::nullopt).has_value();
  // Its death may be told later than its successor answers.
  const bool successor = !another && (died || (pid_ != 0 && pid != 0 && pid != pid_));
  if (pid != 0 || another || successor) pid_ = pid;
  standby_ = status->standby();
  const bool was_silent = std::exchange(silent_, false);
  if (another) return called(leader_) + " leads, in place of " + called(before);
  if (successor) return called(leader_) + " is back: a successor took its place";
  return was_silent ? called(leader_) + " answers again" : "";
}

// It may have answered before it died. Its successor is another process, or was not up for longer than it is dead.
bool SupervisorStory::is_of_dead(const msg::CellStatus& status, bus::Clock::time_point now) const {
  if (!died_ || status.supervisor() != leader_) return false;
  const std::int32_t pid = pid_of(status);
  const bool may_be = pid == 0 || pid == died_->pid;
  return may_be && status.uptime() > std::chrono::duration<double>(now - died_->at).count();
}

std::vector<std::string> SupervisorNews::listen(const msg::CellStatus* status) {
  std::vector<std::string> lines;
  const auto tell = [&](std::string line) {
    if (!line.empty()) lines.push_back(std::move(line));
  };
  for (const auto& sample : processes_.take()) {
    if (!sample.disposed) tell(story_.process(sample.value, sample.received));
  }
  tell(story_.answer(status, bus::Clock::now()));
  return lines;
}

}  // namespace hecaton::services::cli
