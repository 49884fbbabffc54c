#include "services/supervisor/messages.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <utility>

#include "services/runtime/node_name.hpp"
#include "services/supervisor/detection/fault_detector.hpp"

namespace hecaton::services {
namespace {

std::string cause_of(const FaultRecord& record) {
  return cause_of_subject(record.kind, record.subject);
}

/// The inverse of fault_message(): times are related to our clock by the wall clock, durations are the teller's.
std::optional<FaultRecord> fault_record(const msg::Fault& fault, const Clocks& clocks) {
  FaultRecord record;
  if (!is_fault(fault.cause().kind()) ||
      std::sscanf(fault.id().c_str(), "f%" SCNu64 "-%" SCNu64, &record.life, &record.number) != 2) {
    return std::nullopt;
  }
  record.kind = fault.cause().kind();
  record.severity = std::min(fault.severity(), msg::Severity::SEVERITY_CRITICAL);
  record.subject = fault.cause().subject();
  record.seen = fault.cause().text();
  record.since = clocks.now - std::chrono::milliseconds(clocks.now_unix_ms - fault.since_unix_ms());
  if (fault.detection_latency_bound() >= 0.0) {
    record.detected_within = std::chrono::round<Time>(std::chrono::duration<double>(fault.detection_latency_bound()));
  }
  if (fault.cleared()) record.cleared = record.since + Time(fault.cleared_ns() - fault.since_ns());
  return record;
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
  return requests;
}

std::string fault_id(const FaultRecord& record) {
  return "f" + std::to_string(record.life) + "-" + std::to_string(record.number);
}

std::optional<ToldRecord> told_record(const msg::Fault& fault, const Clocks& clocks) {
  auto record = fault_record(fault, clocks);
  if (!record) return std::nullopt;
  std::string cause = cause_of(*record);
  return ToldRecord{std::move(cause), *std::move(record)};
}

msg::Fault fault_message(const FaultRecord& record, const Clocks& clocks) {
  msg::Fault message;
  message.id(fault_id(record));
  message.severity(record.severity);
  message.cause(make_cause(record.kind, record.subject, record.seen));
  message.since_ns(record.since.count());
  message.since_unix_ms(clocks.now_unix_ms -
                        std::chrono::duration_cast<std::chrono::milliseconds>(clocks.now - record.since).count());
  const auto bound = record.detected_within;
  message.detection_latency_bound(bound ? std::chrono::duration<double>(*bound).count() : -1.0);
  message.cleared(record.cleared.has_value());
  message.cleared_ns(record.cleared.value_or(Time(0)).count());
  return message;
}

FaultHistory faults_in(const std::map<std::string, msg::Fault>& told, std::uint64_t term, const Clocks& clocks) {
  FaultHistory history;
  for (const auto& [id, fault] : told) {
    auto record = fault_record(fault, clocks);
    if (!record) continue;
    if (!record->cleared && fault.term() < term) record->cleared = clocks.now;
    if (record->cleared) {
      history.over.push_back(*record);
    } else {
      history.open[cause_of(*record)] = *record;
    }
  }
  std::sort(history.over.begin(), history.over.end(),
            [](const FaultRecord& a, const FaultRecord& b) { return a.cleared > b.cleared; });
  if (history.over.size() > FaultList::kRemembered) history.over.resize(FaultList::kRemembered);
  return history;
}

}  // namespace hecaton::services
