#pragma once
/// Everything that a supervisor writes to the bus, beside its heartbeat: cell modes, faults, replies, and requests to
/// the leader.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <idl/supervisor.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/orders.hpp"
#include "services/supervisor/fault_list.hpp"

namespace hecaton::services {

class CellPublisher {
 public:
  /// The mode is repeated this often, well within the deadline and the lease of its topic.
  static constexpr std::chrono::milliseconds kRepeat{25};

  /// `node`: ours. The participant must outlive it.
  CellPublisher(bus::Participant& participant, std::string node);

  /// Any endpoint of ours.
  [[nodiscard]] bus::EndpointId id() const { return modes_.id(); }
  /// We lead under this term: of two leaders' modes readers take that of the higher one.
  void begin_to_lead(std::uint64_t term);
  /// Late joiners receive no mode of ours any more: they have not received what was granted since.
  void withdraw_mode() { modes_.forget(); }

  /// Completes `mode` by its number, and returns it when it is to be published now: it differs from the last one, or
  /// kRepeat is over.
  [[nodiscard]] std::optional<msg::CellMode> next(msg::CellMode mode, bus::Clock::time_point now) const;
  void publish(msg::CellMode mode, bus::Clock::time_point now);
  /// As last published.
  [[nodiscard]] const msg::CellMode& mode() const { return mode_; }
  /// The mode that a supervisor tells which does not lead yet; it is not published.
  void prepare(msg::CellMode mode) { mode_ = std::move(mode); }

  msg::Fault publish(const FaultRecord& record, std::uint64_t term);
  /// Late joiners receive no faults of ours any more.
  void withdraw_faults() { faults_.forget(); }

  void reply(const msg::SupervisorReply& reply) { static_cast<void>(replies_.write(reply)); }  // the bus logs a refusal
  /// Asks the leader for these orders.
  void request(const Orders& orders);

 private:
  bus::Writer<msg::CellMode> modes_;
  bus::Writer<msg::Fault> faults_;
  bus::Writer<msg::SupervisorReply> replies_;
  bus::Writer<msg::SupervisorRequest> requests_;
  std::string node_;
  msg::CellMode mode_;  ///< as last published
  bus::Clock::time_point mode_at_{};
  std::uint64_t fault_sequence_ = 0;
};

}  // namespace hecaton::services
