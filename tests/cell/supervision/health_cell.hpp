#pragma once
/// A cell of real processes, started by the real agent on a free domain of the loopback interface, and a client of its
/// supervisor. No process is left after the test: the agent is a child that is killed with it, and so are its services.

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <idl/goal.h>
#include <idl/supervisor.h>

#include "services/agent/child_process.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/orders.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton::services::testing {

using namespace std::chrono_literals;

/// Long enough for a loaded machine under a sanitizer. No test that passes waits as long.
constexpr auto kPatience = 60s;

class HealthCell {
 public:
  /// `cell`: a file beside this one.
  explicit HealthCell(const std::vector<std::string>& agent_options = {}, const std::string& cell = "health_cell.yaml");

  using Condition = std::function<bool(const msg::CellStatus&)>;

  /// The supervisor's reply, or nothing when it did not answer within kPatience.
  std::optional<msg::SupervisorReply> call(msg::RequestKind kind, const std::vector<std::string>& arms = {});
  /// The same for an order of a speed override.
  std::optional<msg::SupervisorReply> order_speed(double speed, const std::vector<std::string>& arms = {});
  // The await functions throw std::runtime_error after kPatience.
  /// Requests the status until it satisfies `condition`.
  msg::CellStatus await(const std::string& what, const Condition& condition);
  /// Until every node is alive, every process is known, no fault is open and the cell is on run.
  msg::CellStatus await_healthy();
  /// Until the arm left runs: also in a cell of which other hosts are missing.
  msg::CellStatus await_left_running();
  /// Until a cell mode satisfies `condition`.
  msg::CellMode await_mode(const std::string& what, const std::function<bool(const msg::CellMode&)>& condition);
  /// Until a published fault satisfies `condition`.
  msg::Fault await_fault(const std::string& what, const std::function<bool(const msg::Fault&)>& condition);
  /// Until the peers have dropped the participant of `node`.
  void await_dropped(const std::string& node);
  /// The world's reply to an edit.
  msg::WorldEditReply edit(msg::WorldEditRequest request);
  /// Another agent of the same cell.
  [[nodiscard]] ChildCommand agent_command(const std::vector<std::string>& options) const;
  /// How the agent ended; empty after kPatience.
  std::optional<ChildEnd> await_end();

  /// Until the status of a goal satisfies `condition`.
  msg::GoalStatus await_goal(const std::string& goal, const std::function<bool(const msg::GoalStatus&)>& condition);
  /// The next state of the arm that arrives.
  msg::ArmState next_state(const std::string& arm);

  void send_goal(const std::string& arm, const std::string& goal, const std::string& named);
  /// With the names of arm and goal; the client's name and number are set here.
  void send(msg::Goal goal);
  [[nodiscard]] ChildProcess& agent() { return agent_; }
  [[nodiscard]] const config::CellFile& file() const { return file_; }
  [[nodiscard]] int domain() const { return domain_.number(); }
  [[nodiscard]] bus::Participant& participant() { return participant_; }
  [[nodiscard]] bus::Mailbox& mailbox() { return mailbox_; }

 private:
  std::optional<msg::SupervisorReply> call(msg::SupervisorRequest request);
  /// Agents are killed with the cell. Their checkpoints must not stay for the next cell in the same domain.
  struct OwnRun {
    ~OwnRun();
    const config::CellFile& file;
    int domain;
  };

  config::CellFile file_;
  test::FreeDomain domain_;
  OwnRun run_;
  ChildProcess agent_;
  ServiceOptions options_;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  bus::Writer<msg::SupervisorRequest> requests_;
  bus::Reader<msg::SupervisorReply> replies_;
  bus::Reader<msg::CellMode> modes_;
  bus::Reader<msg::Fault> faults_;
  bus::Writer<msg::Goal> goals_;
  bus::Reader<msg::GoalStatus> goal_statuses_;
  bus::Writer<msg::WorldEditRequest> edits_;
  bus::Reader<msg::WorldEditReply> edit_replies_;
  bus::Reader<msg::ArmState> states_;
  std::vector<msg::Fault> published_;
  std::uint64_t request_ = 0;
};

/// The status of one arm, the newest event of one process; fails the test when there is none.
msg::ArmStatus arm_of(const msg::CellStatus& status, const std::string& arm);
std::optional<msg::ProcessEvent> process_of(const msg::CellStatus& status, const std::string& name);
bool contains(const std::vector<std::string>& names, const std::string& name);
/// The process that is this node; 0 and a failed test when there is none.
int pid_of_node(const msg::CellStatus& status, const std::string& node);
/// Open faults of a kind and subject.
int open_faults(const msg::CellStatus& status, const std::string& kind, const std::string& subject);
/// All processes of a cell.
class CellProcesses {
 public:
  explicit CellProcesses(const msg::CellStatus& status);
  ~CellProcesses();
  CellProcesses(const CellProcesses&) = delete;
  CellProcesses& operator=(const CellProcesses&) = delete;
  [[nodiscard]] std::size_t count() const { return descriptors_.size(); }
  /// True when all have ended within kPatience.
  [[nodiscard]] bool await_all_ended() const;

 private:
  std::vector<int> descriptors_;  // pidfds
};

/// The whole status as text, for failed tests.
std::string text_of(const msg::CellStatus& status);

}  // namespace hecaton::services::testing
