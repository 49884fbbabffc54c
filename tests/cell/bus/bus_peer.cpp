// A process that the tests of the bus kill, stop and observe:
//   bus_peer ROLE DOMAIN NAME LEASE_MS [unicast]
// Roles:
// - heartbeat: writes Heartbeat NAME every 10 ms and ArmState NAME every 5 ms.
// - process: writes ProcessEvents NAME/0 … NAME/29 once, then stays.
// - command: writes ArmCommand arm1 from NAME every 10 ms.
// - measure: joins, waits for 30 keys of ProcessEvent, prints how long that took [ms], leaves.
// - gather: reads ProcessEvents.
// - listen: prints "at N" at every hundredth ArmState, and "silent" when a deadline of 1 s is missed.
// Prints "ready" once its endpoints exist. Ends at the end of its stdin, so that it does not outlive its test.
#include <cstdio>
#include <cstdlib>
#include <string>

#include <idl/arm.h>
#include <idl/health.h>
#include <poll.h>
#include <unistd.h>

#include "services/bus/endpoint.hpp"

namespace {

using namespace hecaton;
using namespace std::chrono_literals;

/// False when stdin has ended.
bool pause_for(int milliseconds) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (::poll(&input, 1, milliseconds) == 0) return true;
  char byte = 0;
  return ::read(STDIN_FILENO, &byte, 1) > 0;
}

void print_ready() {
  std::puts("ready");
  std::fflush(stdout);
}

int heartbeat(bus::Participant& participant, const std::string& name) {
  bus::Writer<msg::Heartbeat> heartbeats(participant);
  bus::Writer<msg::ArmState> states(participant);
  msg::Heartbeat heartbeat;
  heartbeat.node(name);
  heartbeat.pid(::getpid());
  msg::ArmState state;
  state.arm(name);
  print_ready();
  for (std::uint64_t i = 0; pause_for(5); ++i) {
    state.sequence_number(i);
    heartbeat.sequence_number(i / 2);
    if (!states.write(state)) return 1;
    if (i % 2 == 0 && !heartbeats.write(heartbeat)) return 1;
  }
  return 0;
}

int process(bus::Participant& participant, const std::string& name) {
  bus::Writer<msg::ProcessEvent> events(participant);
  for (int i = 0; i < 30; ++i) {
    msg::ProcessEvent event;
    event.process(name + "/" + std::to_string(i));
    if (!events.write(event)) return 1;
  }
  print_ready();
  while (pause_for(-1)) {
  }
  return 0;
}

int command(bus::Participant& participant, const std::string& name) {
  bus::Writer<msg::ArmCommand> commands(participant);
  msg::ArmCommand command;
  command.arm("arm1");
  command.node(name);
  print_ready();
  for (std::uint64_t i = 0; pause_for(10); ++i) {
    command.sequence_number(i);
    if (!commands.write(command)) return 1;
  }
  return 0;
}

int gather(bus::Participant& participant) {
  const bus::Reader<msg::ProcessEvent> reader(participant);
  print_ready();
  while (pause_for(-1)) {
  }
  return 0;
}

int listen(bus::Participant& participant) {
  bus::ReaderOptions options;
  options.deadline = 1s;
  bus::Reader<msg::ArmState> states(participant, nullptr, options);
  print_ready();
  std::uint64_t printed = 0;
  while (pause_for(0)) {
    [[maybe_unused]] const bool arrived = states.wait_for_data(50ms);
    for (const auto& event : states.mailbox().take_events()) {
      if (event.kind == bus::EventKind::kDeadlineMissed) std::puts("silent");
    }
    for (const auto& sample : states.take()) {
      const auto hundred = sample.value.sequence_number() / 100;
      if (hundred > printed) std::printf("at %llu\n", 100ULL * hundred);
      printed = hundred;
    }
    std::fflush(stdout);
  }
  return 0;
}

int measure(bus::Participant& participant, bus::Clock::time_point start) {
  bus::Reader<msg::ProcessEvent> reader(participant);
  const auto until = bus::Clock::now() + 20s;
  while (reader.latest().size() < 30 && bus::Clock::now() < until) {
    [[maybe_unused]] const bool arrived = reader.wait_for_data(until - bus::Clock::now());
  }
  const std::chrono::duration<double, std::milli> taken = bus::Clock::now() - start;
  std::printf("%.1f\n", taken.count());
  return reader.latest().size() == 30 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  const std::string role = argv[1];
  const std::string name = argv[3];
  const auto start = bus::Clock::now();
  bus::ParticipantOptions options;
  options.interfaces = {"127.0.0.1"};
  options.lease = std::chrono::milliseconds(std::atoi(argv[4]));
  if (argc > 5) options.peers = {{"127.0.0.1"}};
  bus::Participant participant(std::atoi(argv[2]), name, options);
  if (role == "heartbeat") return heartbeat(participant, name);
  if (role == "process") return process(participant, name);
  if (role == "command") return command(participant, name);
  if (role == "gather") return gather(participant);
  if (role == "listen") return listen(participant);
  if (role == "measure") return measure(participant, start);
  return 2;
}
