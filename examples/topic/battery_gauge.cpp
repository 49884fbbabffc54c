// Publishes the charge of an arm's battery once a second, until SIGTERM. A real gauge measures it.
//
// usage: example_battery_gauge CELL.yaml ARM CHARGE

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "examples/topic/battery_topic.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/shutdown.hpp"

int main(int argc, char** argv) {
  using namespace std::chrono_literals;
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s CELL.yaml ARM CHARGE\n", argv[0]);
    return 2;
  }
  try {
    hecaton::bus::Mailbox mailbox;
    hecaton::services::ShutdownSignal shutdown;
    shutdown.wake(&mailbox);
    const auto file = hecaton::config::load_cell_file(argv[1]);
    auto participant = hecaton::services::make_participant(file, {}, hecaton::services::Role::kOperator,
                                                           std::string("battery_gauge/") + argv[2]);
    hecaton::bus::Writer<example::BatteryState> writer(participant);
    example::BatteryState state;
    state.arm(argv[2]);
    state.charge(std::strtod(argv[3], nullptr));
    while (!shutdown.requested()) {
      if (const auto result = writer.write(state); !result) std::fprintf(stderr, "%s\n", result.reason.c_str());
      (void)mailbox.wait(1s);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
