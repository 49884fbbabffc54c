#pragma once
/// Which manoeuvre to try: each candidate is played forward on the own arm and its neighbours, and the one that brings
/// all of them to their goals soonest wins. The search may be interrupted after any number of ticks, so that it fits
/// into what a control period leaves over; the same question has the same answer on every machine.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "planner/rollout/rollout_simulation.hpp"

namespace hecaton::planner {

/// What the planner knows when it asks.
struct RolloutQuestion {
  std::vector<RolloutArm> arms;                 ///< of the whole cell
  std::vector<world::ObstacleState> obstacles;  ///< of the whole cell
  std::vector<Eigen::Vector3d> accelerations;   ///< of those [m/s²], or empty: they go on as they do
  double horizon = 2.0;                         ///< [s]
  int candidates = 8;                           ///< besides going on
  std::uint64_t seed = 0;                       ///< of the candidates
  /// Whether something runs the arm down, rather than how it arrives: when going on keeps clear of everything, that is
  /// the answer, without looking at anything else.
  bool lookahead = false;
};

struct RolloutAnswer {
  Manoeuvre manoeuvre;
  double cost = 0.0;  ///< expected time until all played arms are at their goals, summed over them, and what
                      ///< the danger is worth that they get into [s]
  double cost_of_continuing = 0.0;  ///< the same without a manoeuvre [s]
  bool arrives = false;             ///< the own arm reaches its goal within the horizon
};

class RolloutSearch {
 public:
  /// `arms` and `parameters`: of the whole cell. `self`: index of the own arm.
  RolloutSearch(std::vector<Arm> arms, std::vector<LocalParameters> parameters, int self);

  /// What arms carry lengthens their reach, so that others may become neighbours. Gives up an open question.
  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// The arms that are played, as indices in the cell, ascending: the own one and all that may come within dᵢ of it.
  [[nodiscard]] const std::vector<int>& simulated_arms() const { return simulated_arms_; }

  void begin(RolloutQuestion question);
  /// Plays on until the answer is known or about `ticks` ticks of single arms are spent. The answer is given once.
  std::optional<RolloutAnswer> advance(int ticks);
  [[nodiscard]] bool busy() const { return candidate_ <= question_.candidates; }
  /// Ticks of single arms that were played, by all questions so far.
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }

 private:
  void start_candidate();
  [[nodiscard]] bool finished() const;
  [[nodiscard]] double danger(int arm) const;
  [[nodiscard]] double dangers() const;
  [[nodiscard]] double cost() const;
  [[nodiscard]] Manoeuvre draw(int candidate);
  [[nodiscard]] Manoeuvre draw_escape(int candidate);
  [[nodiscard]] JointVector somewhere(double reach);

  std::vector<Arm> arms_;
  std::vector<LocalParameters> parameters_;
  int self_;
  std::vector<int> simulated_arms_;
  int own_ = 0;               ///< index of the own arm among those
  RolloutSimulation cell_;    ///< of those
  RolloutQuestion question_;  ///< as asked, but only with their states
  int candidate_ = 1;         ///< being played; above `candidates`: idle
  Random random_;
  Manoeuvre manoeuvre_;  ///< of the candidate being played
  RolloutAnswer best_;
  std::uint64_t ticks_ = 0;
};

}  // namespace hecaton::planner
