#pragma once
/// What reaches a planner of what arms and world publish, and what it knows from that.

#include <memory>
#include <span>
#include <vector>

#include "planner/local/observation.hpp"
#include "planner/simulation/network_model.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::planner {

/// What all arms and the world publish at one instant, said once for all who hear it.
struct CellInstant {
  std::vector<ArmObservation> arms;
  std::vector<world::ObstacleState> obstacles;
};

/// One planner's news.
class DelayedObservations {
 public:
  /// `self`: the planner's own arm, of which it needs no news. `seeds` gives each sender's channel its own.
  DelayedObservations(const NetworkParameters& network, int self, int arms, int obstacles, Random& seeds);

  /// Everybody publishes `instant`, true at `now` [s], and what is due by then arrives.
  void hear(double now, std::shared_ptr<const CellInstant> instant);

  /// With the ages that the planner can tell, from the senders' spacing and its own clock. The own arm's means nothing.
  [[nodiscard]] std::span<const ArmObservation> arms() const { return ideal_ ? instant_->arms : arms_; }
  [[nodiscard]] std::span<const world::ObstacleState> obstacles() const {
    return ideal_ ? instant_->obstacles : obstacles_;
  }
  /// Whether the world was ever heard of.
  [[nodiscard]] bool knows_obstacles() const { return ideal_ ? instant_ != nullptr : world_.known(); }

 private:
  using Channel = StateChannel<std::shared_ptr<const CellInstant>>;

  bool ideal_;                                  ///< all arrives at once: what was said is what is known
  std::shared_ptr<const CellInstant> instant_;  ///< the last, if ideal

  int self_;
  std::vector<Channel> senders_;  ///< one per arm
  Channel world_;
  std::vector<ArmObservation> arms_;
  std::vector<world::ObstacleState> obstacles_;
};

}  // namespace hecaton::planner
