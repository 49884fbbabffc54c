#pragma once
/// Selection of a manoeuvre by rollouts of the own arm and its neighbours (docs/explanation/0004-rollouts.md).

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "planner/rollout/rollout_simulation.hpp"

namespace hecaton::planner {

/// The state of the cell, and what to search.
struct RolloutQuestion {
  std::vector<RolloutArm> arms;                 ///< of the whole cell
  std::vector<world::ObstacleState> obstacles;  ///< of the whole cell
  std::vector<Eigen::Vector3d> accelerations;   ///< of the obstacles [m/s²]; empty: zero
  double horizon = 2.0;                         ///< [s]
  int candidates = 8;                           ///< besides kContinue
  std::uint64_t seed = 0;                       ///< of the candidates
  /// True: look for approaching obstacles instead of a way to the goal. If kContinue keeps all margins, it is the
  /// answer without further rollouts.
  bool lookahead = false;
};

struct RolloutAnswer {
  Manoeuvre manoeuvre;
  double cost = 0.0;  ///< sum of the expected arrival times of the simulated arms plus the cost of lost margins [s]
  double cost_of_continuing = 0.0;  ///< cost of kContinue [s]
  bool arrives = false;             ///< the own arm reaches its goal within the horizon
  /// The own arm in that rollout: at the question, then every kRolloutPathStep or later [rad | m]. At most
  /// kMostRolloutPoints. Only for people: no set-point depends on it.
  std::vector<JointVector> path = {};
};

inline constexpr double kRolloutPathStep = 0.1;  ///< [s]
inline constexpr std::size_t kMostRolloutPoints = 64;

/// Simulates each candidate; the least cost wins. The search can be interrupted after any number of ticks, so that it
/// fits into the idle time of control periods. The answer does not depend on interruptions or the machine. Not
/// thread-safe.
class RolloutSearch {
 public:
  /// `arms` and `parameters`: of the whole cell. `self`: index of the own arm.
  RolloutSearch(std::vector<Arm> arms, std::vector<LocalParameters> parameters, int self);

  /// Replaces the obstacles, and the neighbours, because carried objects change the reach of arms. Drops an open
  /// question.
  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// Indices of the simulated arms, ascending: the own arm and all that can come within dᵢ of it.
  [[nodiscard]] const std::vector<int>& simulated_arms() const { return simulated_arms_; }

  void begin(RolloutQuestion question);
  /// Simulates until the answer is known or about `ticks` ticks of single arms are spent. Returns the answer once.
  std::optional<RolloutAnswer> advance(int ticks);
  [[nodiscard]] bool busy() const { return candidate_ <= question_.candidates; }
  /// Simulated ticks of single arms since construction.
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }

 private:
  void start_candidate();
  void note_path();
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
  int own_ = 0;               ///< index of the own arm among them
  RolloutSimulation cell_;    ///< of those
  RolloutQuestion question_;  ///< reduced to the simulated arms
  int candidate_ = 1;         ///< present candidate; above `candidates`: idle
  Random random_;
  Manoeuvre manoeuvre_;            ///< of the present candidate
  std::vector<JointVector> path_;  ///< of the present candidate
  RolloutAnswer best_;
  std::uint64_t ticks_ = 0;
};

}  // namespace hecaton::planner
