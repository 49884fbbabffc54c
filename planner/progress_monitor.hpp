#pragma once
/// Whether an arm still comes nearer to its goal. One that follows boundaries moves all the time, and may do so for
/// ever.

#include <limits>

namespace hecaton::planner {

class ProgressMonitor {
 public:
  /// A new goal.
  void restart() { *this = {}; }

  /// One period of `dt` [s] at `distance` = ‖q_goal − q‖ [rad | m], in which the arm was free to plan.
  void note(double distance, double dt) {
    if (distance < kNearer * nearest_) {
      nearest_ = distance;
      without_progress_ = 0.0;
    } else {
      without_progress_ += dt;
    }
  }

  /// Since it was nearer than ever before [s].
  [[nodiscard]] double time_without_progress() const { return without_progress_; }
  /// There may be no way: it has looked for one so long.
  [[nodiscard]] bool stalled() const { return without_progress_ > kStallTimeout; }

 private:
  static constexpr double kNearer = 0.98;        // of the nearest so far
  static constexpr double kStallTimeout = 10.0;  // [s]

  double nearest_ = std::numeric_limits<double>::infinity();
  double without_progress_ = 0.0;
};

}  // namespace hecaton::planner
