#include "tests/cell/supervision/health_cell.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "services/runtime/join.hpp"
#include "services/runtime/run_folder.hpp"

namespace hecaton::services::testing {
namespace {

std::string path_of(const std::string& cell) {
  return std::string(HECATON_SOURCE_DIR) + "/tests/cell/supervision/" + cell;
}

ServiceOptions client_options(int domain) {
  ServiceOptions options;
  options.domain = domain;
  return options;
}

/// Ends the test.
[[noreturn]] void give_up(const std::string& what) {
  throw std::runtime_error(what);
}

/// Waits for a reader of the request, writes it, and waits for the reply with its client and request_id. Empty after
/// the time-out.
template <class Request, class Reply>
std::optional<Reply> request_reply(bus::Writer<Request>& requests, bus::Reader<Reply>& replies, const Request& request,
                                   bus::Clock::duration timeout) {
  const auto until = bus::Clock::now() + timeout;
  if (!requests.wait_matched(1, timeout) || !requests.write(request)) return std::nullopt;
  while (true) {
    for (auto& sample : replies.take()) {
      if (sample.value.client() == request.client() && sample.value.request_id() == request.request_id()) {
        return std::move(sample.value);
      }
    }
    const auto now = bus::Clock::now();
    if (now >= until) return std::nullopt;
    // Another reader may share the mailbox, so only the clock tells a time-out.
    [[maybe_unused]] const bool arrived = replies.wait_for_data(until - now);
  }
}

}  // namespace

HealthCell::HealthCell(const std::vector<std::string>& agent_options, const std::string& cell)
    : file_(config::load_cell_file(path_of(cell))),
      run_{file_, domain_.number()},
      agent_(agent_command(agent_options)),
      options_(client_options(domain_.number())),
      participant_(make_participant(file_, options_, Role::kOperator, "test", &mailbox_)),
      requests_(participant_),
      replies_(participant_, &mailbox_),
      modes_(participant_, &mailbox_),
      faults_(participant_, &mailbox_),
      goals_(participant_),
      goal_statuses_(participant_, &mailbox_),
      edits_(participant_),
      edit_replies_(participant_, &mailbox_),
      states_(participant_, &mailbox_) {}

HealthCell::OwnRun::~OwnRun() {
  for (const config::Host& host : file.hosts) remove_run({file.cell.name, domain, host.name});
}

msg::CellStatus HealthCell::await_left_running() {
  return await("the arm left that runs", [](const msg::CellStatus& status) {
    const auto is_it = [](const msg::ArmStatus& arm) {
      return arm.arm() == "left" && arm.mode() == msg::Mode::MODE_RUN &&
             arm.state().mode() == msg::ArmMode::ARM_RUNNING;
    };
    return std::any_of(status.arms().begin(), status.arms().end(), is_it);
  });
}

ChildCommand HealthCell::agent_command(const std::vector<std::string>& options) const {
  ChildCommand command{
      std::string(HECATON_BIN_DIR) + "/hecaton-agent", {file_.path, "--domain", std::to_string(domain())}, {}};
  command.arguments.insert(command.arguments.end(), options.begin(), options.end());
  return command;
}

std::optional<msg::SupervisorReply> HealthCell::call(msg::RequestKind kind, const std::vector<std::string>& arms) {
  msg::SupervisorRequest request;
  request.kind(kind);
  request.arms(arms);
  return call(std::move(request));
}

std::optional<msg::SupervisorReply> HealthCell::order_speed(double speed, const std::vector<std::string>& arms) {
  msg::SupervisorRequest request;
  request.kind(msg::RequestKind::REQUEST_SPEED);
  request.arms(arms);
  request.speed(speed);
  return call(std::move(request));
}

std::optional<msg::SupervisorReply> HealthCell::call(msg::SupervisorRequest request) {
  const auto until = bus::Clock::now() + kPatience;
  request.client("test-" + std::to_string(getpid()));
  // Repeated if the supervisor died before its reply.
  while (bus::Clock::now() < until) {
    request.request_id(++request_);
    auto reply = request_reply(requests_, replies_, request, 500ms);
    if (reply) return reply;
  }
  return std::nullopt;
}

msg::CellStatus HealthCell::await(const std::string& what, const Condition& condition) {
  const auto until = bus::Clock::now() + kPatience;
  msg::CellStatus status;
  do {
    const auto reply = call(msg::RequestKind::REQUEST_STATUS);
    if (!reply) break;
    status = reply->status();
    if (condition(status)) return status;
    static_cast<void>(modes_.wait_for_data(50ms));
  } while (bus::Clock::now() < until);
  give_up("never seen: " + what + "\nlast status:\n" + text_of(status));
}

msg::CellStatus HealthCell::await_healthy() {
  return await("a healthy cell", [](const msg::CellStatus& status) {
    const auto& nodes = status.nodes();
    const auto& faults = status.faults();
    // World, supervisor, agent, and of each of the two arms a driver and a planner.
    const auto& hosts = status.hosts();
    return nodes.size() == 7 && hosts.size() == 1 && hosts[0].processes().size() == 6 &&
           std::all_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.alive(); }) &&
           std::all_of(faults.begin(), faults.end(), [](const auto& fault) { return fault.cleared(); }) &&
           status.mode().mode() == msg::Mode::MODE_RUN && arms_on(status.mode(), msg::Mode::MODE_HOLD).empty();
  });
}

msg::CellMode HealthCell::await_mode(const std::string& what,
                                     const std::function<bool(const msg::CellMode&)>& condition) {
  const auto until = bus::Clock::now() + kPatience;
  msg::CellMode last;
  while (bus::Clock::now() < until) {
    for (const auto& sample : modes_.take()) {
      if (sample.disposed) continue;
      last = sample.value;
      if (condition(last)) return last;
    }
    static_cast<void>(modes_.wait_for_data(1s));
  }
  give_up("no such mode: " + what + "; last: " + std::to_string(static_cast<int>(last.mode())) + ' ' +
          causes_text(last));
}

msg::Fault HealthCell::await_fault(const std::string& what, const std::function<bool(const msg::Fault&)>& condition) {
  const auto until = bus::Clock::now() + kPatience;
  while (bus::Clock::now() < until) {
    for (const auto& sample : faults_.take()) {
      if (!sample.disposed) published_.push_back(sample.value);
    }
    const auto found = std::find_if(published_.begin(), published_.end(), condition);
    if (found != published_.end()) return *found;
    static_cast<void>(faults_.wait_for_data(1s));
  }
  give_up("no such fault was published: " + what);
}

void HealthCell::await_dropped(const std::string& node) {
  const auto until = bus::Clock::now() + kPatience;
  while (bus::Clock::now() < until) {
    for (const bus::Event& event : mailbox_.take_events()) {
      if (event.kind == bus::EventKind::kParticipantLost && event.key == node) return;
    }
    static_cast<void>(mailbox_.wait(1s));
  }
  give_up(node + " was never dropped");
}

msg::WorldEditReply HealthCell::edit(msg::WorldEditRequest request) {
  request.client("test-" + std::to_string(getpid()));
  request.request_id(++request_);
  const auto reply = request_reply(edits_, edit_replies_, request, kPatience);
  EXPECT_TRUE(reply);
  return reply.value_or(msg::WorldEditReply());
}

msg::GoalStatus HealthCell::await_goal(const std::string& goal,
                                       const std::function<bool(const msg::GoalStatus&)>& condition) {
  const auto until = bus::Clock::now() + kPatience;
  msg::GoalStatus last;
  while (bus::Clock::now() < until) {
    for (const auto& sample : goal_statuses_.take()) {
      if (sample.disposed || sample.value.goal() != goal) continue;
      last = sample.value;
      if (condition(last)) return last;
    }
    static_cast<void>(goal_statuses_.wait_for_data(1s));
  }
  give_up("no such news of goal " + goal + "; last: " + std::to_string(static_cast<int>(last.state())) + ' ' +
          last.cause().text());
}

msg::ArmState HealthCell::next_state(const std::string& arm) {
  static_cast<void>(states_.take());
  const auto until = bus::Clock::now() + kPatience;
  while (bus::Clock::now() < until) {
    for (const auto& sample : states_.take()) {
      if (!sample.disposed && sample.value.arm() == arm) return sample.value;
    }
    static_cast<void>(states_.wait_for_data(1s));
  }
  give_up("nothing is heard of arm " + arm);
}

std::optional<ChildEnd> HealthCell::await_end() {
  pollfd ended{agent_.fd(), POLLIN, 0};
  poll(&ended, 1, static_cast<int>(std::chrono::milliseconds(kPatience).count()));
  return agent_.poll_end();
}

void HealthCell::send_goal(const std::string& arm, const std::string& goal, const std::string& named) {
  msg::Goal message;
  message.arm(arm);
  message.goal(goal);
  message.kind(msg::GoalKind::GOAL_NAMED);
  message.named(named);
  send(std::move(message));
}

void HealthCell::send(msg::Goal message) {
  message.client("test");
  message.sequence_number(++request_);
  const auto written = goals_.write(message);
  EXPECT_TRUE(written) << written.reason;
}

msg::ArmStatus arm_of(const msg::CellStatus& status, const std::string& name) {
  for (const msg::ArmStatus& arm : status.arms()) {
    if (arm.arm() == name) return arm;
  }
  give_up("no arm " + name);
}

std::optional<msg::ProcessEvent> process_of(const msg::CellStatus& status, const std::string& name) {
  for (const msg::HostStatus& host : status.hosts()) {
    for (const msg::ProcessEvent& process : host.processes()) {
      if (process.name() == name) return process;
    }
  }
  return std::nullopt;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

int pid_of_node(const msg::CellStatus& status, const std::string& node) {
  for (const msg::HostStatus& host : status.hosts()) {
    for (const msg::ProcessEvent& process : host.processes()) {
      if (process.node() == node) return process.pid();
    }
  }
  ADD_FAILURE() << "no process is " << node;
  return 0;
}

int open_faults(const msg::CellStatus& status, const std::string& kind, const std::string& subject) {
  return static_cast<int>(std::count_if(status.faults().begin(), status.faults().end(), [&](const msg::Fault& fault) {
    return !fault.cleared() && cause_name(fault.cause().kind()) == kind && fault.cause().subject() == subject;
  }));
}

CellProcesses::CellProcesses(const msg::CellStatus& status) {
  for (const msg::HostStatus& host : status.hosts()) {
    for (const msg::ProcessEvent& process : host.processes()) {
      const auto descriptor = static_cast<int>(syscall(SYS_pidfd_open, process.pid(), 0));
      EXPECT_GE(descriptor, 0) << process.name();
      descriptors_.push_back(descriptor);
    }
  }
}

CellProcesses::~CellProcesses() {
  for (const int descriptor : descriptors_) close(descriptor);
}

bool CellProcesses::await_all_ended() const {
  const auto until = bus::Clock::now() + kPatience;
  return std::all_of(descriptors_.begin(), descriptors_.end(), [&](int descriptor) {
    pollfd ended{descriptor, POLLIN, 0};
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - bus::Clock::now());
    return poll(&ended, 1, static_cast<int>(std::max(left, 0ms).count())) == 1;
  });
}

std::string text_of(const msg::CellStatus& status) {
  std::ostringstream text;
  text << "mode " << static_cast<int>(status.mode().mode()) << " term " << status.mode().term() << ' '
       << causes_text(status.mode()) << '\n';
  for (const auto& arm : status.arms()) text << arm.arm() << " waits for: " << arm.waiting_for().text() << '\n';
  for (const auto& node : status.nodes()) {
    text << node.heartbeat().node() << (node.alive() ? " alive " : " not alive ") << node.age() << " s\n";
  }
  for (const auto& fault : status.faults()) {
    text << fault.id() << ' ' << cause_name(fault.cause().kind()) << ' ' << fault.cause().text()
         << (fault.cleared() ? " cleared" : " open") << '\n';
  }
  return text.str();
}

}  // namespace hecaton::services::testing
