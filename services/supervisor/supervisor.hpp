#pragma once
/// The supervisor of a cell on the bus: hears everything, judges who is well, publishes the cell's mode and its faults,
/// answers people. Requests and deaths wake it at once; silence is judged every kTurn.

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <idl/supervisor.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/pulse.hpp"
#include "services/runtime/shutdown.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/ears.hpp"
#include "services/supervisor/fault_legacy.hpp"
#include "services/supervisor/kept_memory.hpp"
#include "services/supervisor/leadership.hpp"
#include "services/supervisor/order_legacy.hpp"
#include "services/supervisor/owed_replies.hpp"
#include "services/supervisor/picture.hpp"
#include "services/supervisor/succession.hpp"
#include "services/supervisor/takeover_patience.hpp"

namespace hecaton::services {

class Supervisor {
 public:
  static constexpr std::chrono::milliseconds kTurn{5};
  /// The mode is repeated this often, well within the deadline and the lease of its topic.
  static constexpr std::chrono::milliseconds kRepeat{25};

  /// Term, orders and faults survive in the options' memory. Throws std::runtime_error with a sentence.
  Supervisor(const config::CellFile& file, const ServiceOptions& options, ShutdownSignal& shutdown);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  /// Until the process is to end.
  void run();

 private:
  void turn(bus::Clock::time_point now);
  void come_back(bus::Clock::time_point now);
  /// Who has no standby is the only one that can tell that it stood still for less than an absence.
  void tell_stall(bus::Clock::time_point since, bus::Clock::time_point now);
  void tell_own_silence(const std::string& what, bus::Clock::time_point since, bus::Clock::time_point now);
  /// Logs how long it took, from the first word of anybody, until everybody was heard.
  void get_acquainted();
  /// What we granted while we led is not for who joins from now on, and our faults are only until somebody else tells
  /// them.
  void withdraw();
  /// While we stand by: tells again what an earlier life left to nobody, and forgets what the leader has adopted.
  void settle_legacy();
  /// While we stand by: orders once more from the leader what it may not have heard.
  void hand_over_orders();
  void begin_to_lead();
  /// While we lead: puts a planner that stands by in the place of one that is out. True when there was one.
  bool settle_succession();
  [[nodiscard]] PlannerSigns signs_of(const std::string& arm, const std::string& planner) const;
  /// How long the planner in charge may hang now.
  [[nodiscard]] Time patience_with(const std::string& arm) const;
  /// When a planner in charge will have been silent for too long, unless it is heard before.
  [[nodiscard]] bus::Clock::time_point takeover_due(bus::Clock::time_point now) const;
  void tell_predecessor(Time now);
  /// What was ordered before we led is obeyed once we do.
  void answer_requests();
  [[nodiscard]] bool answers() const;
  void answer(const msg::SupervisorRequest& request);
  void reply(const msg::SupervisorRequest& request, const std::string& refusal);
  /// Which of our cell modes the supervisor that stands by has heard; empty: nobody stands by.
  [[nodiscard]] std::optional<std::uint64_t> heard_by_standby() const;
  [[nodiscard]] std::string obey(const msg::SupervisorRequest& request);
  [[nodiscard]] std::vector<msg::LostArm> lost_arms(bus::Clock::time_point now) const;
  void publish_mode(bus::Clock::time_point now);
  void publish_faults();
  msg::Fault publish_fault(const FaultRecord& record, std::uint64_t term, const Clocks& clocks);
  /// What we lead by.
  void remember();
  /// What we would lead by, while we stand by: the leader's orders and faults, so that they outlive both of us as long
  /// as one memory is left.
  void remember_leader();
  void keep(Memory memory);
  void forget_strangers(bus::Clock::time_point now);
  void beat(bus::Clock::time_point now);

  const config::CellFile& file_;
  std::vector<PlacedNode> supervisors_;
  std::size_t place_;  ///< ours among them
  std::string node_;
  ShutdownSignal& shutdown_;
  bus::Clock::time_point began_;
  FaultDetector watch_;
  Picture picture_;
  KeptMemory memory_;
  std::uint64_t remembered_news_ = 0;       ///< of others' faults
  std::uint64_t remembered_mode_ = 0;       ///< of the leader's, as last looked at
  bus::Clock::time_point remembered_at_{};  ///< when that was
  Succession succession_;
  /// The last term under which we led, in this life or an earlier one, or whose leader we remember. Of an equal one it
  /// is the other who knows better: we never take each other's.
  std::uint64_t led_under_;
  std::map<std::string, bus::Clock::time_point> in_charge_since_;  ///< of the planner in charge, by arm
  std::map<std::string, TakeoverPatience> patience_;               ///< by arm that has a standby
  bus::Clock::time_point takeover_due_ = bus::Clock::time_point::max();
  std::optional<bus::Clock::time_point> absent_since_;  ///< nobody hears us, and we hear nobody
  std::optional<bus::Clock::time_point> first_word_;    ///< of anybody
  bus::Clock::time_point newest_match_{};               ///< of any reader, until acquainted
  bool acquainted_ = false;                             ///< has heard of everybody once
  bus::Clock::time_point turned_;                       ///< the last turn that was not in an absence
  msg::CellMode mode_;                                  ///< as last published
  bus::Clock::time_point mode_at_{};
  std::vector<msg::SupervisorRequest> early_;  ///< orders that came before we led
  OwedReplies<msg::SupervisorRequest> owed_;
  std::uint64_t fault_sequence_ = 0;
  OrderLegacy order_legacy_;
  bus::Clock::time_point handed_over_at_{};  ///< orders to the leader, last
  FaultLegacy legacy_;
  bool legacy_told_ = false;  ///< in this life
  bool leads_ = false;        ///< began to, and has withdrawn nothing since
  bus::Mailbox urgent_, quiet_;
  bus::Participant participant_;
  Ears ears_;
  Leadership leadership_;  ///< behind the ears: it listens from when there are any
  bus::Writer<msg::CellMode> modes_;
  bus::Writer<msg::Fault> faults_;
  bus::Writer<msg::SupervisorReply> replies_;
  bus::Writer<msg::SupervisorRequest> requests_;  ///< to who leads
  Pulse pulse_;
  LoopStatistics loop_;
};

}  // namespace hecaton::services
