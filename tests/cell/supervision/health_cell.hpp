#pragma once
/// A whole cell, brought up by the real agent as the real processes, on a free domain of the loopback interface; and a
/// client that talks to its supervisor. Whatever becomes of the test, nothing is left: the agent is a child that is
/// killed with us, and its services with it.

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <idl/goal.h>
#include <idl/supervisor.h>

#include "services/agent/child_process.hpp"
#include "services/bus/ask.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/orders.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton::services::testing {

using namespace std::chrono_literals;

/// Long enough for a loaded machine under a sanitizer; no test waits so long when all is well.
constexpr auto kPatience = 60s;

class HealthCell {
 public:
  /// `cell`: a file beside this one.
  explicit HealthCell(const std::vector<std::string>& agent_options = {}, const std::string& cell = "health_cell.yaml");

  using Condition = std::function<bool(const msg::CellStatus&)>;

  /// The supervisor's reply, or nothing when it did not answer within kPatience.
  std::optional<msg::SupervisorReply> ask(msg::RequestKind kind, const std::vector<std::string>& arms = {});
  // What is awaited and never comes ends the test by an exception.
  /// Asks for the status again and again until it is as wanted.
  msg::CellStatus await(const std::string& what, const Condition& condition);
  /// Until every node is alive, every process is known, no fault is open and the cell is on run.
  msg::CellStatus await_healthy();
  /// Until a mode on the bus is as wanted.
  msg::CellMode await_mode(const std::string& what, const std::function<bool(const msg::CellMode&)>& condition);
  /// Until the fault topic has told one as wanted.
  msg::Fault await_fault(const std::string& what, const std::function<bool(const msg::Fault&)>& condition);
  /// Until the others' lease of `node`'s participant is over.
  void await_dropped(const std::string& node);
  /// The world's reply to an edit.
  msg::WorldEditReply edit(msg::WorldEditRequest request);
  /// Another agent of the same cell.
  [[nodiscard]] ChildCommand agent_command(const std::vector<std::string>& options) const;
  /// How the agent ended.
  std::optional<ChildEnd> await_end();

  /// The newest word on a goal.
  msg::GoalStatus await_goal(const std::string& goal, const std::function<bool(const msg::GoalStatus&)>& condition);
  /// The next state of the arm that arrives.
  msg::ArmState next_state(const std::string& arm);

  void send_goal(const std::string& arm, const std::string& goal, const std::string& named);
  [[nodiscard]] ChildProcess& agent() { return agent_; }
  [[nodiscard]] const config::CellFile& file() const { return file_; }
  [[nodiscard]] int domain() const { return domain_.number(); }
  [[nodiscard]] bus::Participant& participant() { return participant_; }
  [[nodiscard]] bus::Mailbox& mailbox() { return mailbox_; }

 private:
  /// A cell's agents are killed with it: what they remembered must not be found by the next cell in its domain.
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
  bus::Reader<msg::GoalStatus> goal_news_;
  bus::Writer<msg::WorldEditRequest> edits_;
  bus::Reader<msg::WorldEditReply> edit_replies_;
  bus::Reader<msg::ArmState> states_;
  std::vector<msg::Fault> told_;
  std::uint64_t request_ = 0;
};

/// The status of one arm, of one process's newest event; fails the test when it is not there.
msg::ArmStatus arm_of(const msg::CellStatus& status, const std::string& arm);
std::optional<msg::ProcessEvent> process_of(const msg::CellStatus& status, const std::string& name);
bool contains(const std::vector<std::string>& names, const std::string& name);
/// The process that is this node; 0 and a failed test when there is none.
int pid_of_node(const msg::CellStatus& status, const std::string& node);
/// Open faults of a kind and subject.
int open_faults(const msg::CellStatus& status, const std::string& kind, const std::string& subject);
/// All processes that the cell has, by their pid; each is readable when it has ended.
class Witnesses {
 public:
  explicit Witnesses(const msg::CellStatus& status);
  ~Witnesses();
  Witnesses(const Witnesses&) = delete;
  Witnesses& operator=(const Witnesses&) = delete;
  [[nodiscard]] std::size_t count() const { return descriptors_.size(); }
  /// True when all have ended within kPatience.
  [[nodiscard]] bool await_all_ended() const;

 private:
  std::vector<int> descriptors_;
};

/// Everything there is to know of a status, for failed tests.
std::string text_of(const msg::CellStatus& status);

}  // namespace hecaton::services::testing
