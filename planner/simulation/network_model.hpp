#pragma once
/// What the network does to states on their way: delay, jitter, loss. Deterministic for a seed.

#include <algorithm>
#include <vector>

#include "planner/local/random.hpp"

namespace hecaton::planner {

struct NetworkParameters {
  double age = 0.0;     ///< mean delay of a state [s], ≥ 0
  double jitter = 0.0;  ///< the delay is uniform in age ± jitter [s], ≤ age; so a sample may overtake another
  double loss = 0.0;    ///< share of the samples that are lost, [0, 1)
  double burst = 0.0;   ///< mean number of samples lost in a row, ≥ max(1, loss/(1 − loss)); 0: independent losses

  /// Every sample arrives at once.
  [[nodiscard]] bool ideal() const { return age <= 0.0 && jitter <= 0.0 && loss <= 0.0; }
};

/// Decides which samples are lost. With bursts a chain of two states [Gilbert60]: all is lost in the bad one, which
/// ends with probability 1/burst a sample and begins so often that the share of lost samples is as told.
class LossModel {
 public:
  explicit LossModel(const NetworkParameters& parameters);
  [[nodiscard]] bool lost(Random& random);

 private:
  double after_arrival_;  ///< probability of a loss
  double after_loss_;
  bool losing_ = false;
};

/// Carries one sender's states to one receiver.
template <class State>
class StateChannel {
 public:
  StateChannel(const NetworkParameters& parameters, std::uint64_t seed)
      : parameters_(parameters), loss_(parameters), random_(seed) {}

  /// A sample that is true at `now` [s].
  void send(double now, const State& state) {
    const double delay = std::max(0.0, parameters_.age + random_.uniform(-1.0, 1.0) * parameters_.jitter);
    if (!loss_.lost(random_)) under_way_.push_back({now, now + delay, state});
  }

  /// Takes what has arrived by `now`; whether there is anything newer among it. A late sample never replaces a newer
  /// one, as sequence numbers ensure on the wire.
  bool receive(double now) {
    bool is_newer = false;
    std::erase_if(under_way_, [&](const Sample& sample) {
      const bool arrived = sample.arrives <= now + 1e-9;
      if (arrived && (!known_ || sample.sent > newest_.sent)) {
        newest_ = sample;
        known_ = is_newer = true;
      }
      return arrived;
    });
    return is_newer;
  }

  /// Whether any sample has arrived yet.
  [[nodiscard]] bool known() const { return known_; }
  /// The newest sample that has arrived.
  [[nodiscard]] const State& newest() const { return newest_.state; }
  /// Its age at `now` [s].
  [[nodiscard]] double age(double now) const { return now - newest_.sent; }

 private:
  struct Sample {
    double sent = 0.0;
    double arrives = 0.0;
    State state{};
  };
  NetworkParameters parameters_;
  LossModel loss_;
  Random random_;
  std::vector<Sample> under_way_;
  Sample newest_;
  bool known_ = false;
};

}  // namespace hecaton::planner
