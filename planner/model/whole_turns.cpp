#include "planner/model/whole_turns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace hecaton::planner {
namespace {

constexpr double kWayStep = 0.1;  ///< between judged configurations, of the joint that moves most [rad | m]
constexpr std::size_t kMostChoices = 16;

bool within(const JointLimits& limits, int joint, double position) {
  return position >= limits.lower[joint] && position <= limits.upper[joint];
}

/// The number of blocked configurations on the straight way, counted up to `most`.
int blocked_on_way(const JointVector& from, const JointVector& to, int most,
                   const std::function<bool(const JointVector&)>& is_free) {
  double longest = 0.0;
  for (Eigen::Index j = 0; j < from.size(); ++j) longest = std::max(longest, std::abs(to[j] - from[j]));
  const int steps = static_cast<int>(std::ceil(longest / kWayStep));
  int blocked = 0;
  for (int i = 1; i < steps && blocked < most; ++i) {
    if (!is_free(from + static_cast<double>(i) / steps * (to - from))) ++blocked;
  }
  return blocked;
}

/// All choices of turns: each joint as near as it can be, or one turn farther on the other side of `start`. By the sum
/// of the joints' ways, the shortest first.
std::vector<JointVector> choices(const Arm& arm, const JointVector& nearest, const JointVector& start) {
  std::vector<JointVector> all{nearest};
  for (int j = 0; j < arm.model->joints(); ++j) {
    if (!repeats_after_turn(*arm.model, j)) continue;
    const double other = nearest[j] + (nearest[j] > start[j] ? -kWholeTurn : kWholeTurn);
    if (!within(arm.limits, j, other)) continue;
    for (std::size_t i = all.size(); i-- > 0;) {
      all.push_back(all[i]);
      all.back()[j] = other;
    }
  }
  std::stable_sort(all.begin(), all.end(), [&](const JointVector& a, const JointVector& b) {
    return (a - start).cwiseAbs().sum() < (b - start).cwiseAbs().sum();
  });
  if (all.size() > kMostChoices) all.resize(kMostChoices);
  return all;
}

}  // namespace

JointVector nearest_turns(const Arm& arm, JointVector q, const JointVector& start) {
  for (int j = 0; j < arm.model->joints(); ++j) {
    if (!repeats_after_turn(*arm.model, j)) continue;
    const double turned = q[j] + kWholeTurn * std::round((start[j] - q[j]) / kWholeTurn);
    if (within(arm.limits, j, turned)) q[j] = turned;
  }
  return q;
}

JointVector turns_with_free_way(const Arm& arm, const JointVector& q, const JointVector& start,
                                const std::function<bool(const JointVector&)>& is_free) {
  JointVector best = nearest_turns(arm, q, start);
  const std::vector<JointVector> all = choices(arm, best, start);
  if (all.size() == 1) return best;
  int least = std::numeric_limits<int>::max();
  for (const JointVector& choice : all) {
    const int blocked = blocked_on_way(start, choice, least, is_free);
    if (blocked >= least) continue;
    least = blocked;
    best = choice;
    if (blocked == 0) break;
  }
  return best;
}

}  // namespace hecaton::planner
