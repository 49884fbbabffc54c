#pragma once
/// What the supervisor orders, as one arm's planner or driver understands it.

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

/// The newest cell mode of the highest term. Stays what it was while the supervisor is silent.
///
/// People's orders hold for kDoubt after another supervisor has begun to lead, also where it does not know of them: who
/// had them, on the other side of a partition or started again by now, hands them over within that time.
class CellModeView {
 public:
  static constexpr std::chrono::seconds kDoubt{2};

  /// `received`: when it arrived. False when it was ignored because its term is older than one already seen.
  bool apply(const msg::CellMode& mode, bus::Clock::time_point received = {});
  /// The order may have changed unheard: it is unknown until the next cell mode. Terms stay what they were.
  void forget_order() { heard_ = false; }

  [[nodiscard]] bool heard() const { return heard_; }
  [[nodiscard]] std::uint64_t term() const { return term_; }  ///< 0 before any was heard
  [[nodiscard]] const msg::CellMode& mode() const { return mode_; }
  /// Which planner commands the arm. An arm without a standby is not listed: its planner commands under the cell's
  /// term.
  [[nodiscard]] ArmLease lease(std::string_view arm) const;
  /// When the last one that counted arrived.
  [[nodiscard]] bus::Clock::time_point received() const { return received_; }
  /// What is known of the arm if it was lost, else null. Valid until the next cell mode.
  [[nodiscard]] const msg::LostArm* lost(std::string_view arm) const;
  /// The stricter of the cell's order and the arm's own; MODE_HOLD while the order is unknown.
  [[nodiscard]] msg::Mode order(std::string_view arm) const;
  /// Why the order is not MODE_RUN; CAUSE_NONE when it is, CAUSE_MODE_UNKNOWN while the order is unknown.
  [[nodiscard]] msg::Cause why(std::string_view arm) const;

 private:
  bool heard_ = false;
  std::uint64_t term_ = 0;
  msg::CellMode mode_;
  bus::Clock::time_point received_;
  std::optional<msg::CellMode> former_;  // the last of the leader before, while its orders hold
  bus::Clock::time_point changed_;       // when the leader did
};

/// A CellModeView that is fed from the bus, and forgets the order while its participant is away.
class CellModeListener {
 public:
  /// The participant must outlive it.
  explicit CellModeListener(bus::Participant& participant, bus::Mailbox* mailbox = nullptr);
  ~CellModeListener();

  /// Takes what has arrived; true when the order or the term changed. Never blocks.
  bool update();
  [[nodiscard]] const CellModeView& view() const;
  [[nodiscard]] CellModeView& view();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
