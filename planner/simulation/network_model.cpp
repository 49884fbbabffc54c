#include "planner/simulation/network_model.hpp"

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

}  // namespace hecaton::planner
