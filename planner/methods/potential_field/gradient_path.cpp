#include "planner/methods/potential_field/gradient_path.hpp"

#include <algorithm>
#include <cmath>

#include "planner/local/goal_objective.hpp"
#include "planner/methods/potential_field/oscillation_monitor.hpp"

namespace hecaton::planner::potential {
namespace {

/// A step must gain this share of the decrease that the gradient predicts.
constexpr double kArmijo = 1e-2;
/// Growth of the step length after an accepted step.
constexpr double kGrowth = 1.5;
/// Window [steps] and least travel [rad | m] of the oscillation monitor.
constexpr double kWindow = 24.0;
constexpr double kLeastTravel = 1e-3;

class Walk {
 public:
  Walk(PotentialField& field, FreeMotion& motion, const JointLimits& limits, const JointVector& q_goal,
       const DescentOptions& options, Descent& out)
      : field_(field), motion_(motion), limits_(limits), q_goal_(q_goal), options_(options), out_(out) {}

  DescentOutcome from(const JointVector& q_start) {
    q_ = q_start;
    out_.path = {q_};
    evaluate(q_, here_);
    for (out_.steps = 0; out_.steps < options_.most_steps; ++out_.steps) {
      if (finish(field_.parameters().goal_distance)) return DescentOutcome::kReached;
      if (!step()) return finish(kAnyDistance) ? DescentOutcome::kReached : DescentOutcome::kLocalMinimum;
      monitor_.observe(q_, 1.0, kWindow, kLeastTravel);
      if (monitor_.oscillating) return finish(kAnyDistance) ? DescentOutcome::kReached : DescentOutcome::kOscillating;
    }
    return DescentOutcome::kOutOfSteps;
  }

 private:
  static constexpr double kAnyDistance = 1e9;

  void evaluate(const JointVector& q, FieldValue& value) {
    ++out_.evaluations;
    field_.evaluate(motion_.poses(q), q, value);
  }

  /// Appends the goal if the straight line to it is free and moves no point farther than `distance` [m].
  bool finish(double distance) {
    const JointVector way = joint_difference(limits_, q_, q_goal_);
    if (motion_.sweep(way) > distance || !motion_.free(q_, q_ + way)) return false;
    if (way.norm() > 0.0) out_.path.emplace_back(q_ + way);
    return true;
  }

  /// The descent direction. A joint at its limit stays there.
  [[nodiscard]] JointVector downhill() const {
    JointVector d = options_.alpha > 0.0 ? JointVector(-here_.gradient) : steepest_descent(here_);
    for (Eigen::Index j = 0; j < d.size(); ++j) {
      const bool out = (q_[j] <= limits_.lower[j] && d[j] < 0.0) || (q_[j] >= limits_.upper[j] && d[j] > 0.0);
      if (out) d[j] = 0.0;
    }
    return d;
  }

  // [Cardenas10] fig. 4, line 4:   q(i+1) = q(i) − α(i) ∇U(q(i))
  // differs from paper: the listing prints U where it means −∇U.
  bool step() {
    const JointVector d = downhill();
    const double speed = motion_.sweep(d);
    if (speed <= 0.0) return false;
    const double longest = options_.longest_step / speed;
    double alpha = options_.alpha > 0.0 ? std::min(options_.alpha, longest) : std::min(alpha_, longest);
    for (; alpha * speed >= options_.shortest_step; alpha *= 0.5) {
      const JointVector next = (q_ + alpha * d).cwiseMax(limits_.lower).cwiseMin(limits_.upper);
      if (!motion_.free(q_, next)) continue;
      evaluate(next, there_);
      const double promised = -here_.gradient.dot(next - q_);
      const bool lower = there_.potential() <= here_.potential() - kArmijo * promised;
      if (!lower && options_.alpha <= 0.0) continue;
      q_ = next;
      std::swap(here_, there_);
      out_.path.push_back(q_);
      alpha_ = kGrowth * alpha;
      return true;
    }
    return false;
  }

  PotentialField& field_;
  FreeMotion& motion_;
  const JointLimits& limits_;
  const JointVector& q_goal_;
  const DescentOptions& options_;
  Descent& out_;
  JointVector q_;
  FieldValue here_, there_;
  double alpha_ = 1e9;
  OscillationMonitor monitor_;
};

}  // namespace

Descent descend(PotentialField& field, FreeMotion& motion, const JointLimits& limits, const JointVector& q_start,
                const JointVector& q_goal, const DescentOptions& options) {
  Descent out;
  if (!motion.free(q_start)) {
    out.outcome = DescentOutcome::kStartBlocked;
  } else if (!motion.free(q_goal)) {
    out.outcome = DescentOutcome::kGoalBlocked;
  } else {
    field.set_goal(q_goal);
    out.outcome = Walk(field, motion, limits, q_goal, options, out).from(q_start);
  }
  return out;
}

const char* describe(DescentOutcome outcome) {
  switch (outcome) {
    case DescentOutcome::kReached:
      return "the goal";
    case DescentOutcome::kLocalMinimum:
      return "a local minimum of the potential";
    case DescentOutcome::kOscillating:
      return "an oscillation about a local minimum of the potential";
    case DescentOutcome::kOutOfSteps:
      return "the most steps allowed";
    case DescentOutcome::kStartBlocked:
      return "a start in collision, or nearer to one than the margin";
    case DescentOutcome::kGoalBlocked:
      return "a goal in collision, or nearer to one than the margin";
  }
  return "";
}

namespace {

/// Distance of vertices before each round of shortcuts [m].
constexpr double kSpacings[] = {0.1, 0.05};
constexpr int kRoundings = 3;
/// Corners are cut at this share of their segments.
constexpr double kCut = 0.25;

}  // namespace

// From each vertex, a bisection finds a far vertex on a free straight line.
std::vector<JointVector> shortcut(const std::vector<JointVector>& path, FreeMotion& motion) {
  if (path.size() < 3) return path;
  std::vector<JointVector> shorter{path.front()};
  for (std::size_t at = 0; at + 1 < path.size();) {
    std::size_t free = at + 1;
    std::size_t tried = path.size() - 1;
    while (tried > free) {
      if (motion.free(path[at], path[tried])) {
        free = tried;
        break;
      }
      tried = free + (tried - free) / 2;
    }
    at = free;
    shorter.push_back(path[at]);
  }
  return shorter;
}

std::vector<JointVector> round_corners(std::vector<JointVector> path, FreeMotion& motion, int times) {
  for (int i = 0; i < times && path.size() > 2; ++i) {
    std::vector<JointVector> rounder{path.front()};
    for (std::size_t k = 1; k + 1 < path.size(); ++k) {
      const JointVector before = path[k] + kCut * (path[k - 1] - path[k]);
      const JointVector after = path[k] + kCut * (path[k + 1] - path[k]);
      if (motion.free(before, after)) {
        rounder.push_back(before);
        rounder.push_back(after);
      } else {
        rounder.push_back(path[k]);
      }
    }
    rounder.push_back(path.back());
    path = std::move(rounder);
  }
  return path;
}

std::vector<JointVector> resample(const std::vector<JointVector>& path, const FreeMotion& motion, double longest) {
  std::vector<JointVector> finer;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i > 0) {
      const JointVector way = path[i] - path[i - 1];
      const int pieces = std::max(1, static_cast<int>(std::ceil(motion.sweep(way) / longest)));
      for (int k = 1; k < pieces; ++k) finer.emplace_back(path[i - 1] + way * k / pieces);
    }
    finer.push_back(path[i]);
  }
  return finer;
}

std::vector<JointVector> refine(const std::vector<JointVector>& path, FreeMotion& motion) {
  std::vector<JointVector> refined = shortcut(path, motion);
  for (const double spacing : kSpacings) refined = shortcut(resample(refined, motion, spacing), motion);
  return round_corners(std::move(refined), motion, kRoundings);
}

double length(const std::vector<JointVector>& path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

}  // namespace hecaton::planner::potential
