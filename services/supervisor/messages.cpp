#include "services/supervisor/messages.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <utility>

#include "services/runtime/node_name.hpp"
#include "services/supervisor/detection/fault_detector.hpp"

namespace hecaton::services {
namespace {

MoveMode move_mode(msg::Mode mode) {
  switch (mode) {
    case msg::Mode::MODE_HOLD:
      return MoveMode::kHold;
    case msg::Mode::MODE_STOP:
      return MoveMode::kStop;
    case msg::Mode::MODE_RUN:
      break;
  }
  return MoveMode::kRun;
}

msg::Severity severity_of(FaultSeverity severity) {
  switch (severity) {
    case FaultSeverity::kInfo:
      return msg::Severity::SEVERITY_INFO;
    case FaultSeverity::kWarning:
      return msg::Severity::SEVERITY_WARNING;
    case FaultSeverity::kError:
      return msg::Severity::SEVERITY_ERROR;
    case FaultSeverity::kCritical:
      break;
  }
  return msg::Severity::SEVERITY_CRITICAL;
}

std::string cause_of(const FaultRecord& record) {
  return cause_of_subject(record.kind, record.subject);
}

FaultSeverity fault_severity(msg::Severity severity) {
  switch (severity) {
    case msg::Severity::SEVERITY_INFO:
      return FaultSeverity::kInfo;
    case msg::Severity::SEVERITY_WARNING:
      return FaultSeverity::kWarning;
    case msg::Severity::SEVERITY_ERROR:
      return FaultSeverity::kError;
    case msg::Severity::SEVERITY_CRITICAL:
      break;
  }
  return FaultSeverity::kCritical;
}

/// The inverse of fault_message(): times are related to our clock by the wall clock, durations are the teller's.
std::optional<FaultRecord> fault_record(const msg::Fault& fault, const Clocks& clocks) {
  FaultRecord record;
  const auto kind = fault_kind(fault.kind());
  if (!kind || std::sscanf(fault.id().c_str(), "f%" SCNu64 "-%" SCNu64, &record.life, &record.number) != 2) {
    return std::nullopt;
  }
  record.kind = *kind;
  record.severity = fault_severity(fault.severity());
  record.subject = fault.subject();
  record.seen = fault.seen();
  record.since = clocks.now - std::chrono::milliseconds(clocks.now_unix_ms - fault.since_unix_ms());
  if (fault.detected_within() >= 0.0) {
    record.detected_within = std::chrono::round<Time>(std::chrono::duration<double>(fault.detected_within()));
  }
  if (fault.cleared()) record.cleared = record.since + Time(fault.cleared_ns() - fault.since_ns());
  return record;
}

}  // namespace

Clocks read_clocks() {
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  return {bus::Clock::now().time_since_epoch(), std::chrono::duration_cast<std::chrono::milliseconds>(wall).count()};
}

msg::Mode mode_of(MoveMode mode) {
  switch (mode) {
    case MoveMode::kHold:
      return msg::Mode::MODE_HOLD;
    case MoveMode::kStop:
      return msg::Mode::MODE_STOP;
    case MoveMode::kRun:
      break;
  }
  return msg::Mode::MODE_RUN;
}

msg::CellMode mode_message(const CellModeState& mode, const Succession& succession, const std::string& node) {
  const ModeDecision decision = mode.decide();
  msg::CellMode message;
  message.node(node);
  message.mode(mode_of(decision.cell));
  message.held_arms(decision.held_arms);
  message.stopped_arms(decision.stopped_arms);
  message.reason(decision.reason);
  message.ordered(mode_of(mode.orders().cell));
  for (const auto& [arm, order] : mode.orders().arms) {
    if (order == MoveMode::kHold) message.arms_ordered_to_hold().push_back(arm);
  }
  for (const ArmPlanners& arm : succession.arms()) {
    const Mandate mandate = succession.mandate_of(arm.arm);
    if (mandate.term == 0) continue;
    msg::Grant& grant = message.grants().emplace_back();
    grant.arm(arm.arm);
    grant.planner(mandate.planner);
    grant.term(mandate.term);
  }
  return message;
}

Orders orders_in(const msg::CellMode& mode) {
  Orders orders;
  orders.cell = move_mode(mode.ordered());
  for (const std::string& arm : mode.arms_ordered_to_hold()) orders.arms[arm] = MoveMode::kHold;
  for (const std::string& arm : mode.stopped_arms()) orders.arms[arm] = MoveMode::kStop;
  return orders;
}

std::vector<msg::SupervisorRequest> requests_for(const Orders& orders, const std::string& client) {
  std::vector<msg::SupervisorRequest> requests;
  for (const auto& [mode, kind] : {std::pair{MoveMode::kHold, msg::RequestKind::REQUEST_HOLD},
                                   std::pair{MoveMode::kStop, msg::RequestKind::REQUEST_STOP}}) {
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
  message.severity(severity_of(record.severity));
  message.kind(std::string(fault_kind_name(record.kind)));
  message.subject(record.subject);
  message.seen(record.seen);
  message.since_ns(record.since.count());
  message.since_unix_ms(clocks.now_unix_ms -
                        std::chrono::duration_cast<std::chrono::milliseconds>(clocks.now - record.since).count());
  message.detected_within(record.detected_within ? std::chrono::duration<double>(*record.detected_within).count()
                                                 : -1.0);
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
