#include "planner/simulation/network_model.hpp"

#include <algorithm>

namespace hecaton::planner {

StateChannel::StateChannel(const NetworkParameters& parameters, std::uint64_t seed)
    : parameters_(parameters), random_(seed) {}

void StateChannel::send(double now, const ArmObservation& state) {
  const double delay = std::max(0.0, parameters_.age + random_.uniform(-1.0, 1.0) * parameters_.jitter);
  const bool lost = random_.uniform() < parameters_.loss;
  if (lost) return;
  under_way_.push_back({now, now + delay, state});
}

ArmObservation StateChannel::receive(double now) {
  // A late sample never replaces a newer one, as sequence numbers ensure on the wire.
  std::erase_if(under_way_, [&](const Sample& sample) {
    const bool arrived = sample.arrives <= now + 1e-9;
    if (arrived && (!newest_.state.known || sample.sent > newest_.sent)) newest_ = sample;
    return arrived;
  });
  ArmObservation observation = newest_.state;
  observation.age = observation.known ? now - newest_.sent : 0.0;
  return observation;
}

}  // namespace hecaton::planner
