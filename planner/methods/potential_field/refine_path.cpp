#include "planner/methods/potential_field/refine_path.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::planner::potential {
namespace {

/// Vertices before each round of shortcuts are no farther apart than this [m].
constexpr double kSpacings[] = {0.1, 0.05};
constexpr int kRoundings = 3;
/// Corners are cut at this share of their sides.
constexpr double kCut = 0.25;

}  // namespace

// From each vertex on to the farthest one that a bisection finds in a free straight line.
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
