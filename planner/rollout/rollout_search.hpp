#pragma once
/// Which manoeuvre to try: each candidate is played forward on the whole cell, and the one that brings all arms to
/// their goals soonest wins. The search may be interrupted after any number of ticks, so that it fits into what a
/// control period leaves over; the same question has the same answer on every machine.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "planner/rollout/played_cell.hpp"

namespace hecaton::planner {

/// What the planner knows when it asks.
struct RolloutQuestion {
  std::vector<PlayedArm> arms;
  std::vector<world::ObstacleState> obstacles;
  double horizon = 2.0;    ///< [s]
  int candidates = 8;      ///< besides going on
  std::uint64_t seed = 0;  ///< of the candidates
};

struct RolloutAnswer {
  Manoeuvre manoeuvre;
  double cost = 0.0;              ///< expected time until all arms are at their goals, summed over the arms [s]
  double cost_of_going_on = 0.0;  ///< the same without a manoeuvre [s]
  bool arrives = false;           ///< the own arm reaches its goal within the horizon
};

class RolloutSearch {
 public:
  /// `self`: index of the own arm.
  RolloutSearch(const std::vector<Arm>& arms, std::vector<LocalParameters> parameters, int self);

  void set_obstacles(std::span<const world::Obstacle> obstacles);

  void begin(RolloutQuestion question);
  /// Plays on until the answer is known or about `ticks` ticks of single arms are spent. The answer is given once.
  std::optional<RolloutAnswer> advance(int ticks);
  [[nodiscard]] bool busy() const { return candidate_ <= question_.candidates; }

 private:
  void start_candidate();
  [[nodiscard]] bool finished() const;
  [[nodiscard]] double cost() const;
  [[nodiscard]] Manoeuvre draw(int candidate);

  PlayedCell cell_;
  int self_;
  RolloutQuestion question_;
  int candidate_ = 1;  ///< being played; above `candidates`: idle
  Random random_;
  Manoeuvre manoeuvre_;  ///< of the candidate being played
  RolloutAnswer best_;
};

}  // namespace hecaton::planner
