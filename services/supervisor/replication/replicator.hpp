#pragma once
/// Replication of a supervisor's term, orders and faults: to its checkpoint, through the bus, and by requests to the
/// leader (docs/explanation/0003-fault-detection.md, docs/explanation/0008-arm-leases.md).

#include <cstdint>
#include <string>

#include "services/supervisor/cell_publisher.hpp"
#include "services/supervisor/detection/fault_detector.hpp"
#include "services/supervisor/replication/checkpoint.hpp"
#include "services/supervisor/replication/unreplicated.hpp"
#include "services/supervisor/supervisor_subscriptions.hpp"

namespace hecaton::services {

class Replicator {
 public:
  /// What the replicator works on in one turn.
  struct Cell {
    FaultDetector& detector;
    SupervisorSubscriptions& subscriptions;
    CellPublisher& publisher;
    std::uint64_t term;          ///< this supervisor's last
    bus::Clock::time_point now;  ///< when the turn began
  };

  /// `alone`: the cell has no other supervisor. A checkpoint that cannot be used is a fault, see restore().
  Replicator(std::string node, const std::string& checkpoint_path, bool alone);

  /// Gives the detector the orders and faults of the checkpoint. Without a usable one the cell is held until a person
  /// resumes, because a stop may have been ordered. Then it runs at the slowest speed, and the fault
  /// CAUSE_CHECKPOINT_LOST tells so. Call it before the first turn.
  void restore(FaultDetector& detector);

  /// In each turn of a standby: publishes unreplicated faults again, requests unreplicated orders from the leader, and
  /// writes the leader's orders and faults to the own checkpoint. Call it before the heartbeat that acknowledges them.
  void follow_leader(const Cell& cell);
  /// Takes over the orders and faults of the previous leader, or of the own checkpoint, and adopts unreplicated ones.
  void become_leader(const Cell& cell);
  /// This supervisor no longer leads: keeps what the next leader may not have.
  void step_down(const Cell& cell);

  /// A person gave this order.
  void ordered(const msg::SupervisorRequest& request) { orders_.given(request.arms()); }
  /// The publisher is about to publish `mode`. Writes the checkpoint first, so that a published order is never lost.
  void before_publish(const Cell& cell, const msg::CellMode& mode);
  /// The standby has acknowledged the cell mode with this sequence number. Writes the checkpoint before the supervisor
  /// replies to the order. Otherwise a restarted process would give an order again that a person has resumed since.
  void standby_acknowledged(const Cell& cell, std::uint64_t mode);
  /// Writes the term, the orders and the faults of this leader to the checkpoint.
  void remember(const Cell& cell);

  /// As last written, or as the previous process left it.
  [[nodiscard]] const Checkpoint& checkpoint() const { return file_.stored(); }
  /// The greatest term that the previous process may have known; 0: there was none.
  [[nodiscard]] std::uint64_t remembered_term() const { return file_.lost() ? 1 : file_.stored().term; }
  /// The newest checkpoint could not be written: its orders would be lost with this process.
  [[nodiscard]] bool persistence_failed() const { return file_.failed(); }
  /// The same as a cause of this kind; CAUSE_NONE while checkpoints are written.
  [[nodiscard]] msg::Cause persistence_cause(msg::CauseKind kind) const;

 private:
  void republish_faults(const Cell& cell);
  void forward_orders(const Cell& cell);
  void remember_leader(const Cell& cell);
  void tell_lost(FaultDetector& detector) const;
  /// Raises or clears the fault persistence_failed. A failed write is tried again with every published mode.
  void write(Checkpoint checkpoint, FaultList& faults);

  /// What of the leader the checkpoint contains.
  struct Written {
    std::uint64_t fault_revision = 0;
    std::uint64_t mode = 0;  // sequence number
    bus::Clock::time_point at{};
  };

  std::string node_;
  bool alone_;
  CheckpointFile file_;
  UnreplicatedOrders orders_;
  UnreplicatedFaults faults_;
  /// The last term under which this supervisor led, also in an earlier process, or that of the leader in its
  /// checkpoint.
  std::uint64_t last_term_;
  bool leads_ = false;                     ///< became leader and has not stepped down since
  bool faults_published_ = false;          ///< the unreplicated ones, by this process
  bus::Clock::time_point forwarded_at_{};  ///< last request of orders from the leader
  Written written_;
};

}  // namespace hecaton::services
