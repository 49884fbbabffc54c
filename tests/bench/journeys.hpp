#pragma once
/// One arm of the pairs cell that goes from place to place by its own ticks, while the other two swing about.

#include "planner/collision/exact_distance.hpp"
#include "planner/tick.hpp"
#include "tests/bench/pairs_cell.hpp"

namespace hecaton::bench {

class Journeys {
 public:
  explicit Journeys(planner::LinkShapes shapes);
  Journeys(const Journeys&) = delete;
  Journeys& operator=(const Journeys&) = delete;

  /// What the next tick begins with; valid until advance().
  [[nodiscard]] const planner::TickInput& input() const { return input_; }
  /// The same, as FCL wants it.
  [[nodiscard]] const Instant& instant() const { return instant_; }
  [[nodiscard]] planner::TickMemory& memory() { return memory_; }
  [[nodiscard]] const planner::CellGeometry& geometry() const { return cell_.geometry(); }

  planner::TickResult tick() { return planner::tick(geometry(), parameters, input_, memory_, scratch_); }
  /// Moves as the tick's `result` says; after 250 ticks the arm sets off from somewhere else.
  void advance(const planner::TickResult& result);

  const planner::LocalParameters parameters;

 private:
  void set_off();
  /// The two other arms where they swing to by now.
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
