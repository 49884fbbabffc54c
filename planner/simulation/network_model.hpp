#pragma once
/// What the network does to states on their way: delay, jitter, loss. Deterministic for a seed.

#include <deque>
#include <vector>

#include "planner/local/observation.hpp"
#include "planner/local/random.hpp"

namespace hecaton::planner {

struct NetworkParameters {
  double age = 0.0;     ///< mean delay of a state [s], ≥ 0
  double jitter = 0.0;  ///< the delay is uniform in age ± jitter [s], ≤ age
  double loss = 0.0;    ///< probability that a sample is lost, [0, 1)
};

/// Carries one arm's states to one receiver.
class StateChannel {
 public:
  StateChannel(const NetworkParameters& parameters, std::uint64_t seed);

  /// `state` is true at `now` [s].
  void send(double now, const ArmObservation& state);
  /// The newest sample that has arrived by `now`, with its age; `known` false before the first.
  [[nodiscard]] ArmObservation receive(double now);

 private:
  struct Sample {
    double sent;
    double arrives;
    ArmObservation state;
  };
  NetworkParameters parameters_;
  Random random_;
  std::deque<Sample> under_way_;
  Sample newest_{};
};

}  // namespace hecaton::planner
