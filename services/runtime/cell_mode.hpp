#pragma once
/// The supervisor's cell mode, as a planner, a driver or the world evaluates it.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <idl/health.h>

#include "services/bus/participant.hpp"
#include "services/runtime/arm_lease.hpp"
#include "services/runtime/cause.hpp"

namespace hecaton::services {

[[nodiscard]] msg::ModeNumber number_of(const msg::CellMode& mode);

/// The newest cell mode of the highest term. It stays in force while the supervisor is silent.
///
/// After a change of leader the former leader's operator orders stay in force for kOrderHandover unless the new leader
/// knows them. Within that time the former leader, restarted or on the other side of a partition, hands them over.
class CellModeView {
 public:
  static constexpr std::chrono::seconds kOrderHandover{2};

  /// A term belongs to the participant that has published it within this time: another one is ignored meanwhile. It is
  /// eight periods of the supervisor, and shorter than the start of its successor.
  static constexpr std::chrono::milliseconds kHold{200};

  /// `received`: arrival on this process's clock. `writer`: the endpoint that published the mode. Returns false when
  /// the mode is ignored: its term is older than a known one, or belongs to another participant.
  bool apply(const msg::CellMode& mode, bus::Clock::time_point received = {}, const bus::EndpointId& writer = {});
  /// For a process that may have missed a change: the order is unknown until the next cell mode. The term stays.
  void forget_order() { heard_ = false; }

  [[nodiscard]] bool heard() const { return heard_; }
  [[nodiscard]] std::uint64_t term() const { return term_; }  ///< 0 before the first cell mode
  [[nodiscard]] const msg::CellMode& mode() const { return mode_; }
  /// The arm's lease. An arm without a standby planner has none in the cell mode: its planner commands under the cell's
  /// term.
  [[nodiscard]] ArmLease lease(std::string_view arm) const;
  /// Arrival of the newest cell mode that was not ignored.
  [[nodiscard]] bus::Clock::time_point received() const { return received_; }
  /// The last known state of a lost arm; null for other arms. Valid until the next cell mode.
  [[nodiscard]] const msg::LostArm* lost(std::string_view arm) const;
  /// The stricter of the cell's order and the arm's own; MODE_HOLD while the order is unknown.
  [[nodiscard]] msg::Mode order(std::string_view arm) const;
  /// The arm's speed override: the lower of the cell's and its own. It remains while the order is unknown.
  /// kSlowestSpeed before the first cell mode.
  [[nodiscard]] double speed(std::string_view arm) const;
  /// Why the order is not MODE_RUN; CAUSE_NONE when it is, CAUSE_MODE_UNKNOWN while the order is unknown.
  [[nodiscard]] msg::Cause why(std::string_view arm) const;

 private:
  bool heard_ = false;
  std::uint64_t term_ = 0;
  msg::CellMode mode_;
  bus::Clock::time_point received_;
  bus::EndpointId writer_;
  std::optional<msg::CellMode> former_;  ///< of the former leader, while its orders are in force
  bus::Clock::time_point changed_;       ///< when the leader changed
};

/// A CellModeView fed from the bus. It forgets the order while the participant recovers from a stall. For one thread.
class CellModeListener {
 public:
  /// The participant must outlive it.
  explicit CellModeListener(bus::Participant& participant, bus::Mailbox* mailbox = nullptr);
  ~CellModeListener();

  /// Takes the cell modes that have arrived; true when one was applied. Never blocks.
  bool update();
  [[nodiscard]] const CellModeView& view() const;
  [[nodiscard]] CellModeView& view();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
