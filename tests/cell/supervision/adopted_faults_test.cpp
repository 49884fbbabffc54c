// A supervisor adopts the faults that another leader published. The test acts as the other leader.

#include <algorithm>
#include <chrono>
#include <csignal>

#include <gtest/gtest.h>

#include "services/supervisor/cell_publisher.hpp"
#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::services::testing {
namespace {

const msg::Fault* find_fault(const msg::CellStatus& status, const std::string& id) {
  const auto found = std::find_if(status.faults().begin(), status.faults().end(),
                                  [&](const msg::Fault& fault) { return fault.id() == id; });
  return found == status.faults().end() ? nullptr : &*found;
}

TEST(AdoptedFaults, SurviveTheSupervisorThatAdoptedThem) {
  HealthCell cell({"--host", "alpha"}, "standby_cell.yaml");
  const auto before = cell.await_left_running();
  msg::Fault published;
  published.id("f1-7");
  published.term(1);
  published.sequence_number(1);
  published.severity(msg::Severity::SEVERITY_ERROR);
  published.cause(
      make_cause(msg::CauseKind::CAUSE_NODE_SILENT, "planner/left", "planner/left: no heartbeat on the other side"));
  published.since_unix_ms(read_clocks().now_unix_ms - 5000);
  bus::ParticipantOptions options;
  options.interfaces = {"127.0.0.1"};
  options.partition = cell.file().cell.name;
  bus::Participant other_leader(cell.domain(), "supervisor@beta", options);
  bus::Writer<msg::Fault> another(other_leader);
  ASSERT_TRUE(another.write(published));
  const auto is_over = [&](const msg::CellStatus& status) {
    const msg::Fault* kept = find_fault(status, published.id());
    return kept && kept->cleared() && kept->cause() == published.cause();
  };
  cell.await("the other leader's fault, cleared because its cause has ended", is_over);
  cell.await_left_running();

  ASSERT_TRUE(test::signal_process(pid_of_node(before, "supervisor"), SIGKILL));
  cell.await("the same fault from the next supervisor", [&](const msg::CellStatus& status) {
    return status.mode().term() > before.mode().term() && is_over(status);
  });
}

TEST(AdoptedFaults, StayPublishedAfterTheirSupervisorStepsDown) {
  HealthCell cell({"--host", "alpha"}, "standby_cell.yaml");
  const int pid = pid_of_node(cell.await_left_running(), "planner/left");
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  const msg::Fault fault = cell.await_fault("a cleared fault", [](const msg::Fault& reported) {
    return reported.cause().kind() == msg::CauseKind::CAUSE_PROCESS_DIED &&
           reported.cause().subject() == "planner/left" && reported.cleared();
  });

  bus::Reader<msg::Heartbeat> heartbeats(cell.participant(), &cell.mailbox());
  bus::Writer<msg::CellMode> leader(cell.participant());
  msg::CellMode mode;
  mode.term(fault.term() + 1001);  // of the supervisor on beta: odd
  mode.node("supervisor@elsewhere");
  const auto lead_until = [&](const auto& condition) {
    for (const auto until = bus::Clock::now() + kPatience; bus::Clock::now() < until;) {
      mode.sequence_number(mode.sequence_number() + 1);
      EXPECT_TRUE(leader.write(mode));
      if (condition()) return true;
      static_cast<void>(cell.mailbox().wait(20ms));
      static_cast<void>(cell.mailbox().take_events());
    }
    return false;
  };
  ASSERT_TRUE(lead_until([&] {
    const auto taken = heartbeats.take();
    return std::any_of(taken.begin(), taken.end(), [](const auto& sample) {
      return !sample.disposed && sample.value.node() == "supervisor" &&
             sample.value.state() == msg::NodeState::NODE_STANDBY;
    });
  })) << "the supervisor does not step down";
  bus::Reader<msg::Fault> newcomer(cell.participant(), &cell.mailbox());
  EXPECT_TRUE(lead_until([&] {
    const auto taken = newcomer.take();
    return std::any_of(taken.begin(), taken.end(), [&](const auto& sample) {
      return !sample.disposed && sample.value.id() == fault.id() && sample.value.cleared();
    });
  })) << "its fault is no longer published";
  cell.await("the fault, when the supervisor leads again", [&](const msg::CellStatus& status) {
    return status.mode().term() > mode.term() && find_fault(status, fault.id()) != nullptr;
  });
}

}  // namespace
}  // namespace hecaton::services::testing
