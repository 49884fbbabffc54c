#pragma once
/// Random conflicting tasks: goals in the shared area to which straight motions in joint space would collide.

#include <optional>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/local/random.hpp"
#include "planner/simulation/rest_clearance.hpp"

namespace hecaton::planner {

/// Draws starts and goals of a cell's tasks (tasks: in the cell file). Not thread-safe.
class TaskGenerator {
 public:
  explicit TaskGenerator(const Cell& cell);
  ~TaskGenerator();
  TaskGenerator(TaskGenerator&&) noexcept;

  /// With a pose sequence: one of its poses. With a motion problem: all arms in their first areas, or all in their
  /// second. Otherwise: tools in the task area. Except in a sequence, all arms are clear of each other, of themselves,
  /// and of all places of obstacles, by a margin above the dampers' security distance. Empty when `attempts` draws
  /// found none; with an area for each arm, `attempts` counts per arm.
  [[nodiscard]] std::optional<CellConfiguration> draw_configuration(Random& random, int attempts = 400);

  /// As above, in the turns of the joints that the arms reach from home on the straightest free way. In other turns a
  /// goal may be out of reach for good.
  [[nodiscard]] std::optional<CellConfiguration> draw_starts(Random& random);

  /// Why the last draw found nothing: the end of a sentence.
  [[nodiscard]] const std::string& shortage() const;

  /// True if arms at `starts` are clear of the scripted obstacles at world time `time` [s], by the margin of
  /// draw_configuration().
  [[nodiscard]] bool clear_at(double time, const CellConfiguration& starts);
  /// A time in [0, span] [s] at which clear_at() holds. Empty when `attempts` draws found none.
  [[nodiscard]] std::optional<double> draw_time(Random& random, double span, const CellConfiguration& starts,
                                                int attempts = 200);

  /// Goals of arms at `starts`. With a pose sequence: the next pose. With a motion problem: each arm's next area.
  /// Otherwise a configuration as above to which straight_motion_collides(); any when no two arms can meet. Joints that
  /// turn more than once take the turn with the straightest free way. Empty when `attempts` draws found none.
  [[nodiscard]] std::optional<CellConfiguration> draw_conflicting_goals(Random& random, const CellConfiguration& starts,
                                                                        int attempts = 2000);

  /// True if two arms touch while all move from `starts` to `goals` in joint space, on straight lines in the same time.
  /// If the task area demands it, every arm must touch another. In a cell with clutter, obstacles count as well.
  [[nodiscard]] bool straight_motion_collides(const CellConfiguration& starts, const CellConfiguration& goals);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::planner
