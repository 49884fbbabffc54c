#pragma once
/// One arm of the pairs cell that moves between random goals by its ticks, while the other two oscillate.

#include "planner/collision/exact_distance.hpp"
#include "planner/tick.hpp"
#include "tests/bench/pairs_cell.hpp"

namespace hecaton::bench {

class Journeys {
 public:
  explicit Journeys(planner::LinkShapes shapes);
  Journeys(const Journeys&) = delete;
  Journeys& operator=(const Journeys&) = delete;

  /// The input of the next tick; valid until advance().
  [[nodiscard]] const planner::TickInput& input() const { return input_; }
  /// The same for FCL.
  [[nodiscard]] const Instant& instant() const { return instant_; }
  [[nodiscard]] planner::TickMemory& memory() { return memory_; }
  [[nodiscard]] const planner::CellGeometry& geometry() const { return cell_.geometry(); }

  planner::TickResult tick() { return planner::tick(geometry(), parameters, input_, memory_, scratch_); }
  /// Moves to the tick's `result`. After 250 ticks the arm starts at another position.
  void advance(const planner::TickResult& result);

  const planner::LocalParameters parameters;

 private:
  void set_off();
  /// Updates the states of the two other arms.
  void look_around();

  PairsCell cell_;
  planner::ExactDistance distance_;
  planner::TickScratch scratch_;
  planner::TickMemory memory_;
  planner::TickInput input_;
  Instant start_;
  Instant instant_;
  std::vector<planner::ArmObservation> arms_;
  int journey_ = 0;
  int ticks_ = 0;
};

}  // namespace hecaton::bench
