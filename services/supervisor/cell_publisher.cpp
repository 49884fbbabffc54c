#include "services/supervisor/cell_publisher.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"
#include "services/supervisor/messages.hpp"

namespace hecaton::services {
namespace {

/// True when both say the same, whenever they were written.
bool same_decision(msg::CellMode a, const msg::CellMode& b) {
  a.sequence_number(b.sequence_number());
  a.stamp_ns(b.stamp_ns());
  a.node(b.node());
  return a == b;
}

}  // namespace

CellPublisher::CellPublisher(bus::Participant& participant, std::string node)
    : modes_(participant),
      faults_(participant),
      replies_(participant),
      requests_(participant),
      node_(std::move(node)) {}

void CellPublisher::begin_to_lead(std::uint64_t term) {
  constexpr auto kStrongest = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
  modes_.set_strength(static_cast<int>(std::min(term, kStrongest)));
}

std::optional<msg::CellMode> CellPublisher::next(msg::CellMode mode, bus::Clock::time_point now) const {
  if (same_decision(mode, mode_) && now - mode_at_ < kRepeat) return std::nullopt;
  mode.sequence_number(mode_.sequence_number() + 1);
  return mode;
}

void CellPublisher::publish(msg::CellMode mode, bus::Clock::time_point now) {
  const bool changed = !same_decision(mode, mode_);
  mode.stamp_ns(stamp_now());
  mode_ = std::move(mode);
  mode_at_ = now;
  static_cast<void>(modes_.write(mode_));
  if (changed) log_info("cell mode", {{"mode", mode_name(mode_.mode())}, {"reason", causes_text(mode_)}});
}

msg::Fault CellPublisher::publish(const FaultRecord& record, std::uint64_t term) {
  msg::Fault fault = fault_message(record, read_clocks());
  fault.term(term);
  fault.sequence_number(++fault_sequence_);
  fault.stamp_ns(stamp_now());
  static_cast<void>(faults_.write(fault));
  return fault;
}

void CellPublisher::request(const Orders& orders) {
  // The bus has logged a refusal.
  for (const msg::SupervisorRequest& request : requests_for(orders, node_)) {
    static_cast<void>(requests_.write(request));
  }
}

}  // namespace hecaton::services
