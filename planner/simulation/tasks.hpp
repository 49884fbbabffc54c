#pragma once
/// Random conflicting tasks: configurations that bring all tools into the shared area, such that driving there on
/// straight joint-space lines would collide.

#include <optional>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/local/random.hpp"

namespace hecaton::planner {

/// One configuration per arm of the cell.
using CellConfiguration = std::vector<JointVector>;

/// The obstacles of one episode.
[[nodiscard]] std::vector<world::Obstacle> draw_clutter(const Clutter& clutter, Random& random);

class TaskGenerator {
 public:
  explicit TaskGenerator(const Cell& cell);
  ~TaskGenerator();
  TaskGenerator(TaskGenerator&&) noexcept;

  /// A stop of the cell's route, if it has one; of a motion problem, all arms in their first areas or all in their
  /// second. Otherwise: tools in the task area; all arms clear of each other, of themselves and of everything that
  /// obstacles ever sweep, by a margin above the dampers' security distance. Nothing when `attempts` draws (of each
  /// arm, if each has an area of its own) found none.
  [[nodiscard]] std::optional<CellConfiguration> draw_configuration(Random& random, int attempts = 400);

  /// Why the last draw that found nothing did so: the end of a sentence.
  [[nodiscard]] const std::string& shortage() const;

  /// Whether arms that stand at `starts` are as clear of the scripted obstacles at this instant of their scripts [s] as
  /// drawn configurations are of everything.
  [[nodiscard]] bool clear_at(double time, const CellConfiguration& starts);
  /// An instant within `span` [s] at which they are. Nothing when `attempts` draws found none.
  [[nodiscard]] std::optional<double> draw_time(Random& random, double span, const CellConfiguration& starts,
                                                int attempts = 200);

  /// Goals for arms that stand at `starts`: the next stop of the cell's route, if it has one; of a motion problem, each
  /// arm's next area. Otherwise a configuration
  /// as above for which the simultaneous straight-line motion brings arms into contact: two at least, or every one of
  /// them if the cell's task area says so. Nothing when `attempts` draws found none.
  [[nodiscard]] std::optional<CellConfiguration> draw_conflicting_goals(Random& random, const CellConfiguration& starts,
                                                                        int attempts = 2000);

  /// Whether two arms (or every arm some other, see above; or, in a cell with clutter, an arm and an obstacle) touch
  /// while all move from `starts` to `goals` on straight lines in the same time.
  [[nodiscard]] bool straight_motion_collides(const CellConfiguration& starts, const CellConfiguration& goals);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::planner
