#include "services/supervisor/cell_publisher.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <limits>

#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"
#include "services/supervisor/clipped_text.hpp"

namespace hecaton::services {
namespace {

/// True when both say the same; sequence number, stamp and node do not count.
bool same_decision(msg::CellMode a, const msg::CellMode& b) {
  a.sequence_number(b.sequence_number());
  a.stamp_ns(b.stamp_ns());
  a.node(b.node());
  return a == b;
}

}  // namespace

Clocks read_clocks() {
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  return {bus::Clock::now().time_since_epoch(), std::chrono::duration_cast<std::chrono::milliseconds>(wall).count()};
}

msg::CellMode mode_message(const CellModeState& mode, const PlannerFailover& failover, const std::string& node) {
  msg::CellMode message = mode.decide();
  message.node(node);
  for (const ArmPlanners& arm : failover.arms()) {
    const ArmLease lease = failover.lease(arm.arm);
    if (lease.term > 0) message.leases().push_back(lease_message(arm.arm, lease));
  }
  return message;
}

msg::Fault fault_message(const FaultRecord& record, const Clocks& clocks) {
  msg::Fault message;
  message.id(fault_id(record));
  message.severity(record.severity);
  message.cause(make_cause(record.kind, record.subject, record.description));
  message.since_ns(record.since.count());
  message.since_unix_ms(clocks.now_unix_ms -
                        std::chrono::duration_cast<std::chrono::milliseconds>(clocks.now - record.since).count());
  const auto bound = record.detection_latency_bound;
  message.detection_latency_bound(bound ? std::chrono::duration<double>(*bound).count() : -1.0);
  message.cleared(record.cleared_at.has_value());
  message.cleared_ns(record.cleared_at.value_or(Time(0)).count());
  return message;
}

std::optional<KeyedFaultRecord> fault_record_of(const msg::Fault& fault, const Clocks& clocks) {
  FaultRecord record;
  if (!is_fault(fault.cause().kind()) ||
      std::sscanf(fault.id().c_str(), "f%" SCNu64 "-%" SCNu64, &record.opening_term, &record.number) != 2) {
    return std::nullopt;
  }
  record.kind = fault.cause().kind();
  record.severity = std::min(fault.severity(), msg::Severity::SEVERITY_CRITICAL);
  record.subject = fault.cause().subject();
  record.description = clipped(fault.cause().text());
  // The wall clocks relate the instants of two hosts; durations are those of the publisher.
  record.since = clocks.now - std::chrono::milliseconds(clocks.now_unix_ms - fault.since_unix_ms());
  const double bound = fault.detection_latency_bound();
  if (bound >= 0.0) record.detection_latency_bound = std::chrono::round<Time>(std::chrono::duration<double>(bound));
  if (fault.cleared()) record.cleared_at = record.since + Time(fault.cleared_ns() - fault.since_ns());
  std::string key = fault_key(record.kind, record.subject);
  return KeyedFaultRecord{std::move(key), std::move(record)};
}

FaultHistory fault_history_of(const std::map<std::string, msg::Fault>& published, std::uint64_t term,
                              const Clocks& clocks) {
  FaultHistory history;
  for (const auto& [id, fault] : published) {
    auto keyed = fault_record_of(fault, clocks);
    if (!keyed) continue;
    FaultRecord& record = keyed->record;
    if (!record.cleared_at && fault.term() < term) record.cleared_at = clocks.now;
    if (record.cleared_at) {
      history.cleared.push_back(record);
    } else {
      history.open[keyed->key] = record;
    }
  }
  std::sort(history.cleared.begin(), history.cleared.end(),
            [](const FaultRecord& a, const FaultRecord& b) { return a.cleared_at > b.cleared_at; });
  if (history.cleared.size() > FaultList::kClearedKept) history.cleared.resize(FaultList::kClearedKept);
  return history;
}

std::vector<msg::SupervisorRequest> requests_for(const Orders& orders, const std::string& client) {
  std::vector<msg::SupervisorRequest> requests;
  for (const auto& [mode, kind] : {std::pair{msg::Mode::MODE_HOLD, msg::RequestKind::REQUEST_HOLD},
                                   std::pair{msg::Mode::MODE_STOP, msg::RequestKind::REQUEST_STOP}}) {
    msg::SupervisorRequest request;
    request.client(client);
    request.kind(kind);
    if (orders.cell == mode) requests.push_back(request);
    for (const auto& [arm, order] : orders.arms) {
      if (order == mode) request.arms().push_back(arm);
    }
    if (!request.arms().empty()) requests.push_back(request);
  }
  const auto slow_down = [&](std::vector<std::string> arms, double speed) {
    msg::SupervisorRequest request;
    request.client(client);
    request.kind(msg::RequestKind::REQUEST_SLOWER);
    request.arms(std::move(arms));
    request.speed(speed);
    requests.push_back(std::move(request));
  };
  if (orders.speed < kFullSpeed) slow_down({}, orders.speed);
  for (const auto& [arm, speed] : orders.speeds) slow_down({arm}, speed);
  return requests;
}

CellPublisher::CellPublisher(bus::Participant& participant, std::string node)
    : modes_(participant),
      faults_(participant),
      replies_(participant),
      requests_(participant),
      node_(std::move(node)) {}

std::optional<msg::CellMode> CellPublisher::next(msg::CellMode mode, bus::Clock::time_point now) const {
  const auto period = repeats_at_once_ > 0 ? kBetweenThem : kRepeat;
  if (same_decision(mode, mode_) && now - mode_at_ < period) return std::nullopt;
  mode.sequence_number(mode_.sequence_number() + 1);
  return mode;
}

void CellPublisher::publish(msg::CellMode mode, bus::Clock::time_point now) {
  const bool changed = !same_decision(mode, mode_);
  mode.stamp_ns(stamp_now());
  mode_ = std::move(mode);
  mode_at_ = now;
  repeats_at_once_ = changed ? kRepeatsAtOnce : std::max(repeats_at_once_ - 1, 0);
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
  for (const msg::SupervisorRequest& request : requests_for(orders, node_)) {
    static_cast<void>(requests_.write(request));
  }
}

}  // namespace hecaton::services
