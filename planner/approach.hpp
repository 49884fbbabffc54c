#pragma once
/// Whether an arm still comes nearer to its goal. One that follows boundaries moves all the time, and may do so for
/// ever.

#include <limits>

namespace hecaton::planner {

class Approach {
 public:
  /// A new goal.
  void restart() { *this = {}; }

  /// One period of `dt` [s] at `distance` = ‖q_goal − q‖ [rad | m], in which the arm was free to plan.
  void note(double distance, double dt) {
    if (distance < kNearer * nearest_) {
      nearest_ = distance;
      lost_ = 0.0;
    } else {
      lost_ += dt;
    }
  }

  /// Since it was nearer than ever before [s].
  [[nodiscard]] double lost() const { return lost_; }
  /// There may be no way: it has looked for one so long.
  [[nodiscard]] bool hopeless() const { return lost_ > kHopeless; }

 private:
  static constexpr double kNearer = 0.98;    // of the nearest so far
  static constexpr double kHopeless = 10.0;  // [s]

  double nearest_ = std::numeric_limits<double>::infinity();
  double lost_ = 0.0;
};

}  // namespace hecaton::planner
