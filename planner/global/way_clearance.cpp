/// The smallest distance on a straight way, from below: between configurations no point of a body moves farther than
/// its joints' levers allow, as in proven_free.

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/global/validity.hpp"

namespace hecaton::planner::global {
namespace {

/// The result may be smaller than the truth by this share of it, or by this [m].
constexpr double kShare = 2e-3;
constexpr double kLeast = 2e-6;
/// Distances that are looked at before anything: what is near somewhere spares looking elsewhere.
constexpr int kFirst = 8;
/// No more distances than this on one way; what is left then counts as near as it may be.
constexpr std::size_t kMostDistances = 1'000'000;

/// Two bodies of which at least one moves, and how fast they can near each other [m for the whole way].
struct Gap {
  int own;
  int other;
  bool world;  ///< what `other` is an index of
  double rate;
};

/// A part of the way, and what may be nearest there.
struct Stretch {
  double middle;
  double half;
  std::vector<Gap> gaps;
};

}  // namespace

double Validity::clearance(std::span<const double> a, std::span<const double> b, Pairs pairs) const {
  const auto lever = [&](int body, int j) {
    return static_cast<double>(levers_[static_cast<std::size_t>(body) * robot_.dimensions + j]);
  };
  std::vector<const Body*> bodies;
  for (const CellGeometry& geometry : planned_) {
    for (const Body& body : geometry.own_bodies()) bodies.push_back(&body);
  }
  std::vector<Gap> all;
  for (const KernelPair& pair : robot_.pairs) {
    if (pairs == Pairs::kNotOwn && body_arm_[pair.a] == body_arm_[pair.b]) continue;
    Gap gap{pair.a, pair.b, false, 0.0};
    for (int j = 0; j < robot_.dimensions; ++j) {
      const double one = lever(pair.a, j);
      const double two = lever(pair.b, j);
      // A joint that moves both does not move them against each other: they are of one arm.
      if (one <= 0.0 || two <= 0.0) gap.rate += (one + two) * std::abs(b[j] - a[j]);
    }
    all.push_back(gap);
  }
  for (int own = 0; own < static_cast<int>(bodies.size()); ++own) {
    if (!bodies[own]->moves) continue;
    double rate = 0.0;
    for (int j = 0; j < robot_.dimensions; ++j) rate += lever(own, j) * std::abs(b[j] - a[j]);
    for (int other = 0; other < static_cast<int>(world_bodies_.size()); ++other)
      all.push_back({own, other, true, rate});
  }

  const auto placed_at = [&](double t) {
    std::vector<Pose> poses;
    Eigen::Index first = 0;
    for (const CellGeometry& geometry : planned_) {
      const Arm& arm = geometry.own_arm();
      JointVector q(arm.model->joints());
      for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = a[first + j] + t * (b[first + j] - a[first + j]);
      first += q.size();
      Kinematics kinematics;
      forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
      for (const Body& body : geometry.own_bodies()) poses.emplace_back(kinematics.X_WL[body.link] * body.X_CS);
    }
    return poses;
  };
  const auto distance = [&](const Gap& gap, const std::vector<Pose>& poses) {
    const world::Shape& other = gap.world ? world_bodies_[gap.other].shape : bodies[gap.other]->shape;
    const Pose& X_WS = gap.world ? world_bodies_[gap.other].X_WS : poses[gap.other];
    return shape_distance(bodies[gap.own]->shape, poses[gap.own], other, X_WS).distance;
  };

  double seen = std::numeric_limits<double>::infinity();   // somewhere on the way
  double bound = std::numeric_limits<double>::infinity();  // nowhere nearer, where it was not halved any more
  std::size_t distances = 0;
  std::vector<Stretch> stretches;
  for (int i = 0; i < kFirst; ++i) stretches.push_back({(i + 0.5) / kFirst, 0.5 / kFirst, all});
  for (const double end : {0.0, 1.0}) stretches.push_back({end, 0.0, all});
  while (!stretches.empty()) {
    const Stretch stretch = std::move(stretches.back());
    stretches.pop_back();
    const std::vector<Pose> poses = placed_at(stretch.middle);
    std::vector<std::pair<double, Gap>> found;
    for (const Gap& gap : stretch.gaps) {
      found.emplace_back(distance(gap, poses), gap);
      seen = std::min(seen, found.back().first);
    }
    distances += stretch.gaps.size();
    const double good_enough = seen - std::max(kLeast, kShare * std::abs(seen));
    std::vector<Gap> left;
    for (const auto& [here, gap] : found) {
      const double least = here - gap.rate * stretch.half;
      if (least < good_enough && distances < kMostDistances) {
        left.push_back(gap);
      } else {
        bound = std::min(bound, least);
      }
    }
    if (left.empty()) continue;
    const double quarter = 0.5 * stretch.half;
    stretches.push_back({stretch.middle - quarter, quarter, left});
    stretches.push_back({stretch.middle + quarter, quarter, std::move(left)});
  }
  return std::min(seen, bound);
}

}  // namespace hecaton::planner::global
