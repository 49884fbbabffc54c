#include "planner/simulation/network_model.hpp"

#include <utility>

namespace hecaton::planner {

// Stationary share of the bad state: p/(p + 1/burst) = loss  ⇒  p = loss/(burst (1 − loss)).
LossModel::LossModel(const NetworkParameters& parameters)
    : after_arrival_(parameters.loss), after_loss_(parameters.loss) {
  if (parameters.burst <= 0.0) return;
  after_arrival_ = parameters.loss / (parameters.burst * (1.0 - parameters.loss));
  after_loss_ = 1.0 - 1.0 / parameters.burst;
}

bool LossModel::lost(Random& random) {
  losing_ = random.uniform() < (losing_ ? after_loss_ : after_arrival_);
  return losing_;
}

DelayedObservations::DelayedObservations(const NetworkParameters& network, int self, int arms, int obstacles,
                                         Random& seeds)
    : ideal_(network.ideal()), self_(self), senders_(), world_(network, 0), arms_(arms), obstacles_(obstacles) {
  for (int from = 0; from < arms; ++from) senders_.emplace_back(network, seeds.next());
  world_ = Channel(network, seeds.next());
}

void DelayedObservations::update(double now, std::shared_ptr<const CellInstant> instant) {
  if (ideal_) {
    instant_ = std::move(instant);
    return;
  }
  for (int from = 0; from < static_cast<int>(arms_.size()); ++from) {
    if (from == self_) continue;
    Channel& channel = senders_[from];
    channel.send(now, instant);
    if (channel.receive(now)) arms_[from] = channel.newest()->arms[from];
    if (channel.known()) arms_[from].age = channel.age(now);
  }
  world_.send(now, instant);
  if (world_.receive(now)) obstacles_ = world_.newest()->obstacles;
  for (world::ObstacleState& obstacle : obstacles_) obstacle.age = world_.known() ? world_.age(now) : 0.0;
}

}  // namespace hecaton::planner
