#pragma once
/// A simulated network: delay, jitter and loss of states, and what a planner knows from those that arrive.
/// Deterministic for a seed.

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "planner/local/observation.hpp"
#include "planner/local/random.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::planner {

struct NetworkParameters {
  double age = 0.0;     ///< mean delay of a state [s], ≥ 0
  double jitter = 0.0;  ///< the delay is uniform in age ± jitter [s], ≤ age; a sample may overtake another
  double loss = 0.0;    ///< share of samples lost, [0, 1)
  double burst = 0.0;   ///< mean number of samples lost in a row, ≥ max(1, loss/(1 − loss)); 0: independent losses

  /// True: each sample arrives at once.
  [[nodiscard]] bool ideal() const { return age <= 0.0 && jitter <= 0.0 && loss <= 0.0; }
};

/// Decides which samples are lost. With bursts, a Markov chain of two states [Gilbert60]: in the bad state all samples
/// are lost. It ends with probability 1/burst per sample, and begins such that the mean loss is `loss`.
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

  /// Sends a state sampled at `now` [s].
  void send(double now, const State& state) {
    const double delay = std::max(0.0, parameters_.age + random_.uniform(-1.0, 1.0) * parameters_.jitter);
    if (!loss_.lost(random_)) in_flight_.push_back({now, now + delay, state});
  }

  /// Takes the samples that have arrived by `now` [s]. Returns true if newest() changed. A late sample does not replace
  /// a newer one, as with sequence numbers on the wire.
  bool receive(double now) {
    bool is_newer = false;
    std::erase_if(in_flight_, [&](const Sample& sample) {
      const bool arrived = sample.arrives <= now + 1e-9;
      if (arrived && (!known_ || sample.sent > newest_.sent)) {
        newest_ = sample;
        known_ = is_newer = true;
      }
      return arrived;
    });
    return is_newer;
  }

  /// True once a sample has arrived.
  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] const State& newest() const { return newest_.state; }
  /// Age of newest() at `now` [s].
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
  std::vector<Sample> in_flight_;
  Sample newest_;
  bool known_ = false;
};

/// The states that all arms and the world publish at one instant; shared by all receivers.
struct CellInstant {
  std::vector<ArmObservation> arms;
  std::vector<world::ObstacleState> obstacles;
};

/// What one planner knows of the other arms and of the obstacles.
class DelayedObservations {
 public:
  /// `self`: index of the own arm, which needs no channel. `seeds`: each channel draws one seed.
  DelayedObservations(const NetworkParameters& network, int self, int arms, int obstacles, Random& seeds);

  /// Sends `instant`, sampled at `now` [s], on all channels, and takes what has arrived by then.
  void update(double now, std::shared_ptr<const CellInstant> instant);

  /// The newest states, with their ages. The own arm's entry is not valid.
  [[nodiscard]] std::span<const ArmObservation> arms() const { return ideal_ ? instant_->arms : arms_; }
  [[nodiscard]] std::span<const world::ObstacleState> obstacles() const {
    return ideal_ ? instant_->obstacles : obstacles_;
  }
  /// True once a state of the world has arrived.
  [[nodiscard]] bool knows_obstacles() const { return ideal_ ? instant_ != nullptr : world_.known(); }

 private:
  using Channel = StateChannel<std::shared_ptr<const CellInstant>>;

  bool ideal_;                                  ///< the last instant is what the planner knows
  std::shared_ptr<const CellInstant> instant_;  ///< the last one, if ideal
  int self_;
  std::vector<Channel> senders_;  ///< one per arm
  Channel world_;
  std::vector<ArmObservation> arms_;
  std::vector<world::ObstacleState> obstacles_;
};

}  // namespace hecaton::planner
