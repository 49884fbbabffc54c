#include "services/planner/tick_publisher.hpp"

#include <utility>

namespace hecaton::services {

TickPublisher::TickPublisher(bus::Participant& participant, const std::string& arm, int self, const std::string& node)
    : writer_(participant), ticks_(arm, self, node) {}

TickPublisher::Period TickPublisher::begin(Clock::time_point now, bool in_charge) {
  const int readers = writer_.matched();
  const bool joined = readers > std::exchange(readers_, readers);
  begun_ = readers > 0 && in_charge;
  if (!begun_) {
    unbroken_ = false;
    return {};
  }
  if (!unbroken_) ticks_.interrupt();
  Period period{&ticks_, joined || !unbroken_ || now >= snapshot_at_};
  if (period.snapshot) {
    snapshot_at_ =
        now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(TickWriter::kSnapshotPeriod));
  }
  return period;
}

// The bus logs a failed write.
void TickPublisher::publish() {
  if (begun_) unbroken_ = static_cast<bool>(writer_.write(ticks_.message()));
}

}  // namespace hecaton::services
