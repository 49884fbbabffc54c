#pragma once
/// What a supervisor keeps for its successor, and takes over from its predecessor: the term, people's orders and the
/// faults. On disk (CheckpointFile), on the bus, and through the leader (docs/design/0003 and 0008).

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
  /// What it works on, in one turn.
  struct Cell {
    FaultDetector& detector;
    SupervisorSubscriptions& subscriptions;
    CellPublisher& publisher;
    std::uint64_t term;          ///< our last
    bus::Clock::time_point now;  ///< when the turn began
  };

  /// `alone`: the cell has no other supervisor. Throws std::runtime_error with a sentence when the checkpoint cannot be
  /// used.
  Replicator(std::string node, const std::string& checkpoint_path, bool alone);

  /// Gives the detector the orders and faults of an earlier life. Before the first turn.
  void restore(FaultDetector& detector);

  /// A standby: publishes once more what an earlier life left unreplicated, hands its orders to the leader, and writes
  /// the leader's orders and faults into its own checkpoint. To be called before the heartbeat that acknowledges them.
  void follow(const Cell& cell);
  /// Takes over the orders and faults of the leader before, or of our own earlier life; adopts unreplicated ones.
  void begin_to_lead(const Cell& cell);
  /// We lead no more: what the next leader may not have is left to it.
  void stand_back(const Cell& cell);

  /// A person gave this order.
  void ordered(const msg::SupervisorRequest& request) { orders_.given(request.arms()); }
  /// This cell mode is about to be published. Writes the checkpoint before: a published order is never forgotten.
  void about_to_publish(const Cell& cell, const msg::CellMode& mode);
  /// The standby has received the cell mode of this number. Writes the checkpoint before the order is acknowledged: a
  /// next life would otherwise order once more what a person has resumed since.
  void standby_received(const Cell& cell, std::uint64_t mode);
  /// Writes the term, the orders and the faults by which we lead.
  void remember(const Cell& cell);

  /// As last written, or as an earlier life left it.
  [[nodiscard]] const Checkpoint& checkpoint() const { return file_.kept(); }
  /// The newest checkpoint could not be written: orders would be lost with this process.
  [[nodiscard]] bool persistence_failed() const { return file_.failed(); }
  /// The same as a cause: of a reply (CAUSE_NOT_PERSISTED) or a state; CAUSE_NONE while checkpoints are written.
  [[nodiscard]] msg::Cause persistence_cause(msg::CauseKind kind) const;

 private:
  void publish_left_faults(const Cell& cell);
  void hand_over_orders(const Cell& cell);
  void remember_leader(const Cell& cell);
  /// Tried again with every mode that is published, until there is room again. Raises and clears the fault.
  void write(Checkpoint checkpoint, FaultList& faults);

  /// What of the leader was written last.
  struct Written {
    std::uint64_t fault_news = 0;
    std::uint64_t mode = 0;
    bus::Clock::time_point at{};
  };

  std::string node_;
  bool alone_;
  CheckpointFile file_;
  UnreplicatedOrders orders_;
  UnreplicatedFaults faults_;
  /// The last term under which we led, in this life or an earlier one, or whose leader we remember. Of an equal one it
  /// is the other that knows better: the two supervisors never take each other's terms.
  std::uint64_t led_under_;
  bool leads_ = false;                       ///< began to, and has not stood back since
  bool faults_published_ = false;            ///< those that were left, in this life
  bus::Clock::time_point handed_over_at_{};  ///< orders to the leader, last
  Written written_;
};

}  // namespace hecaton::services
