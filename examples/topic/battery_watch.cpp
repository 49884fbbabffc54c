// Prints the charge of each arm's battery. Ends with 1 when a charge is below LEAST.
//
// usage: example_battery_watch CELL.yaml LEAST

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "examples/topic/battery_topic.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/shutdown.hpp"

namespace {

/// Prints what is missing: a silent gauge, or one that has ended.
void print_losses(hecaton::bus::Mailbox& mailbox) {
  using hecaton::bus::EventKind;
  for (const auto& event : mailbox.take_events()) {
    if (event.key.empty()) continue;
    if (event.kind == EventKind::kDeadlineMissed || event.kind == EventKind::kPeerLost) {
      std::printf("%s: no gauge\n", event.key.c_str());
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s CELL.yaml LEAST\n", argv[0]);
    return 2;
  }
  try {
    hecaton::bus::Mailbox mailbox;
    hecaton::services::ShutdownSignal shutdown;
    shutdown.wake(&mailbox);
    const double least = std::strtod(argv[2], nullptr);
    const auto file = hecaton::config::load_cell_file(argv[1]);
    auto participant = hecaton::services::make_participant(file, {}, hecaton::services::Role::kViewer, "battery_watch");
    hecaton::bus::Reader<example::BatteryState> reader(participant, &mailbox);
    while (!shutdown.requested()) {
      print_losses(mailbox);
      for (const auto& sample : reader.take()) {
        if (sample.disposed) continue;
        std::printf("%s: %.0f %%\n", sample.key.c_str(), 100.0 * sample.value.charge());
        if (sample.value.charge() < least) return 1;
      }
      std::fflush(stdout);
      (void)mailbox.wait(std::chrono::hours(1));
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
