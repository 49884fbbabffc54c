/// Lower bounds of the clearance of edges, by bounds on motion [Schwarzer05].

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/collision/exact_distance.hpp"
#include "planner/global/validity.hpp"

namespace hecaton::planner::global {
namespace {

/// Largest error of the result: this share of it, or this distance [m].
constexpr double kRelativeError = 2e-3;
constexpr double kAbsoluteError = 2e-6;
/// Initial segments. A small distance found in one makes halving others unnecessary.
constexpr int kFirstSegments = 8;
/// Largest number of distances for one edge; the lower bounds of the remaining segments count.
constexpr std::size_t kMaxDistances = 1'000'000;

/// A pair of bodies, at least one of which moves.
struct Gap {
  int own;
  int other;
  bool world;   ///< `other` is an index of a world body
  double rate;  ///< largest change of the distance on the whole edge [m]
};

/// A segment of the edge, and the pairs that may be nearest there.
struct Segment {
  double middle;
  double half;
  std::vector<Gap> gaps;
};

}  // namespace

double Validity::clearance(std::span<const double> a, std::span<const double> b, Pairs pairs) const {
  const std::size_t frames = built_.robot.frames.size();
  const auto lever = [&](int body, std::size_t j) {
    return static_cast<double>(levers_[static_cast<std::size_t>(body) * frames + j]);
  };
  const auto step = [&](std::size_t j) {
    const KernelFrame& frame = built_.robot.frames[j];
    return static_cast<double>(std::abs(frame.multiplier)) * std::abs(b[frame.coordinate] - a[frame.coordinate]);
  };
  std::vector<const Body*> bodies;
  for (const CellGeometry& geometry : planned_) {
    for (const Body& body : geometry.own_bodies()) bodies.push_back(&body);
  }
  std::vector<Gap> all;
  for (const KernelPair& pair : built_.robot.pairs) {
    if (pairs == Pairs::kNotOwn && built_.arm_of_body[pair.a] == built_.arm_of_body[pair.b]) continue;
    Gap gap{pair.a, pair.b, false, 0.0};
    for (std::size_t j = 0; j < frames; ++j) {
      const double one = lever(pair.a, j);
      const double two = lever(pair.b, j);
      // A frame that moves both bodies, of one arm, does not move them relative to each other.
      if (one <= 0.0 || two <= 0.0) gap.rate += (one + two) * step(j);
    }
    all.push_back(gap);
  }
  for (int own = 0; own < static_cast<int>(bodies.size()); ++own) {
    if (!bodies[own]->moves) continue;
    double rate = 0.0;
    for (std::size_t j = 0; j < frames; ++j) rate += lever(own, j) * step(j);
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

  double seen = std::numeric_limits<double>::infinity();   // smallest distance computed
  double bound = std::numeric_limits<double>::infinity();  // smallest lower bound of segments that are done
  std::size_t distances = 0;
  std::vector<Segment> segments;
  for (int i = 0; i < kFirstSegments; ++i) segments.push_back({(i + 0.5) / kFirstSegments, 0.5 / kFirstSegments, all});
  for (const double end : {0.0, 1.0}) segments.push_back({end, 0.0, all});
  while (!segments.empty()) {
    const Segment segment = std::move(segments.back());
    segments.pop_back();
    const std::vector<Pose> poses = placed_at(segment.middle);
    std::vector<std::pair<double, Gap>> found;
    for (const Gap& gap : segment.gaps) {
      found.emplace_back(distance(gap, poses), gap);
      seen = std::min(seen, found.back().first);
    }
    distances += segment.gaps.size();
    const double good_enough = seen - std::max(kAbsoluteError, kRelativeError * std::abs(seen));
    std::vector<Gap> left;
    for (const auto& [here, gap] : found) {
      const double least = here - gap.rate * segment.half;
      if (least < good_enough && distances < kMaxDistances) {
        left.push_back(gap);
      } else {
        bound = std::min(bound, least);
      }
    }
    if (left.empty()) continue;
    const double quarter = 0.5 * segment.half;
    segments.push_back({segment.middle - quarter, quarter, left});
    segments.push_back({segment.middle + quarter, quarter, std::move(left)});
  }
  return std::min(seen, bound);
}

}  // namespace hecaton::planner::global
