#pragma once
/// What a supervisor writes to the bus beside its heartbeat, and the conversion of modes, orders and faults to and from
/// messages.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/supervisor.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/orders.hpp"
#include "services/runtime/stall_compensated_clock.hpp"
#include "services/supervisor/cell_mode.hpp"
#include "services/supervisor/failover/planner_failover.hpp"
#include "services/supervisor/fault_list.hpp"

namespace hecaton::services {

/// One instant on two clocks. It relates the steady clock, which the detector uses, to the wall clock.
struct Clocks {
  Time now{0};                   ///< steady clock, since its epoch
  std::int64_t now_unix_ms = 0;  ///< wall clock [ms]
};
[[nodiscard]] Clocks read_clocks();

/// The caller sets term, sequence number and stamp of the messages.
[[nodiscard]] msg::CellMode mode_message(const CellModeState& mode, const PlannerFailover& failover,
                                         const std::string& node);
[[nodiscard]] msg::Fault fault_message(const FaultRecord& record, const Clocks& clocks);

/// The inverse of fault_message() for a fault of another supervisor, with times on this host's steady clock. Empty when
/// the message is malformed.
[[nodiscard]] std::optional<KeyedFaultRecord> fault_record_of(const msg::Fault& fault, const Clocks& clocks);
/// Faults that other leaders published, by id, with times on this host's steady clock. Malformed messages are left out.
/// `term`: of the last leader. It published all its faults under this term; an open fault of an older term counts as
/// cleared now.
[[nodiscard]] FaultHistory fault_history_of(const std::map<std::string, msg::Fault>& published, std::uint64_t term,
                                            const Clocks& clocks);

/// Requests that order what `orders` contains. The caller sets the request ids.
[[nodiscard]] std::vector<msg::SupervisorRequest> requests_for(const Orders& orders, const std::string& client);

/// Writers of one supervisor. The bus logs refused writes. One thread.
class CellPublisher {
 public:
  /// Period at which an unchanged mode is repeated, well within the deadline and the lease of its topic. Repetition
  /// replaces acknowledgements, which cost two more datagrams for each reader.
  static constexpr std::chrono::milliseconds kRepeat{25};
  /// A changed mode is repeated so often at once, a turn of the supervisor apart: of 10 % lost datagrams, one change in
  /// 10,000 is later than kRepeat.
  static constexpr int kRepeatsAtOnce = 3;
  static constexpr std::chrono::milliseconds kBetweenThem{4};  ///< less than a turn

  /// `node`: of this supervisor. `participant` must outlive the publisher. Throws as bus::Writer does.
  CellPublisher(bus::Participant& participant, std::string node);

  /// Any endpoint of this supervisor.
  [[nodiscard]] bus::EndpointId id() const { return modes_.id(); }

  /// Returns `mode` with its sequence number if it is to be published now: it differs from the last one, or a
  /// repetition is due.
  [[nodiscard]] std::optional<msg::CellMode> next(msg::CellMode mode, bus::Clock::time_point now) const;
  void publish(msg::CellMode mode, bus::Clock::time_point now);
  /// The mode that was published last, or prepared.
  [[nodiscard]] const msg::CellMode& mode() const { return mode_; }
  /// Sets mode() without publishing it, for replies of a supervisor that does not lead yet.
  void prepare(msg::CellMode mode) { mode_ = std::move(mode); }

  msg::Fault publish(const FaultRecord& record, std::uint64_t term);
  /// Late joiners no longer receive faults of this supervisor.
  void withdraw_faults() { faults_.clear_history(); }

  void reply(const msg::SupervisorReply& reply) { static_cast<void>(replies_.write(reply)); }
  /// Requests these orders from the leader.
  void request(const Orders& orders);

 private:
  bus::Writer<msg::CellMode> modes_;
  bus::Writer<msg::Fault> faults_;
  bus::Writer<msg::SupervisorReply> replies_;
  bus::Writer<msg::SupervisorRequest> requests_;
  std::string node_;
  msg::CellMode mode_;
  bus::Clock::time_point mode_at_{};  // when it was published
  int repeats_at_once_ = 0;           // still due
  std::uint64_t fault_sequence_ = 0;
};

}  // namespace hecaton::services
