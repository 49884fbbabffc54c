/// Continuous collision checks of edges by bounds on motion [Schwarzer05]: proofs that an edge is free, and lower
/// bounds of its clearance.

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/collision/exact_distance.hpp"
#include "planner/global/validity.hpp"

namespace hecaton::planner::global {
namespace {

constexpr double kRoundedUp = 1.0 + 1e-5;

/// Distance of p from an axis through the origin.
double axis_distance(const Eigen::Vector3d& axis, const Eigen::Vector3d& p) {
  return (p - axis.dot(p) * axis).norm();
}

// Walks from the body to the base. In each frame, a sphere about the frame's origin contains the body for all values of
// the joints beyond it.
void add_levers(const Arm& arm, const Body& body, float* levers) {
  const RobotModel& model = *arm.model;
  Eigen::Vector3d centre = body.bound.centre;
  double radius = body.bound.radius;
  for (int link = body.link; link >= 0; link = model.links[link].parent) {
    const Link& at = model.links[link];
    if (at.joint >= 0) {
      const bool prismatic = at.joint_type == JointType::kPrismatic;
      levers[at.joint] = static_cast<float>(kRoundedUp * (prismatic ? 1.0 : axis_distance(at.axis, centre) + radius));
      radius += centre.norm();
      if (prismatic) radius += std::max(std::abs(arm.limits.lower[at.joint]), std::abs(arm.limits.upper[at.joint]));
      centre = Eigen::Vector3d::Zero();
    }
    centre = at.X_PJ * centre;
  }
}

/// Segments on which no point moves farther than this are not halved any more; they count as colliding [m].
constexpr float kFinest = 2e-5F;
/// Exact distances are used for segments below this motion, comparable to the excess of covering spheres [m].
constexpr float kCoarse = 8e-3F;
/// Largest number of undecided segments; a grazing edge needs fewer.
constexpr std::size_t kMaxSegments = 1U << 14U;

/// q = (1 − t)² a + 2 t (1 − t) c + t² b.
struct Curve {
  const float* a;
  const float* c;
  const float* b;
  int stride;

  void at(float t, float* q) const {
    const float s = 1.0F - t;
    for (int j = 0; j < stride; ++j) q[j] = s * s * a[j] + 2.0F * s * t * c[j] + t * t * b[j];
  }
  /// Upper bound of |dq/dt|, which is linear in t between 2 (c − a) and 2 (b − c).
  [[nodiscard]] float fastest(int j) const { return 2.0F * std::max(std::abs(c[j] - a[j]), std::abs(b[j] - c[j])); }
  /// Upper bound of the length in joint space; exact for a line.
  [[nodiscard]] double longest() const {
    double sum = 0.0;
    for (int j = 0; j < stride; ++j) sum += std::pow(fastest(j), 2);
    return std::sqrt(sum);
  }
};

/// Upper bounds of the motion of bodies when each joint j moves by steps(j), and of the relative motion of pairs: a
/// joint that moves both bodies of a pair does not move them relative to each other.
struct Motion {
  std::vector<float> body;
  std::vector<float> pair;

  template <typename Steps>
  Motion(const KernelRobot& robot, const std::vector<float>& levers, const Steps& steps)
      : body(robot.bodies.size(), 0.0F), pair(robot.pairs.size(), 0.0F) {
    for (int j = 0; j < robot.dimensions; ++j) {
      const float step = steps(j);
      const auto lever = [&](int i) { return levers[i * robot.dimensions + j]; };
      for (int i = 0; i < static_cast<int>(body.size()); ++i) body[i] += lever(i) * step;
      for (std::size_t i = 0; i < pair.size(); ++i) {
        const float one = lever(robot.pairs[i].a);
        const float two = lever(robot.pairs[i].b);
        if (one <= 0.0F || two <= 0.0F) pair[i] += (one + two) * step;
      }
    }
  }
};

/// Midpoints of `count` segments (a multiple of eight) of half length `half`. Each group of eight spreads over the
/// whole edge, so that an obstacle is found early.
std::vector<float> first_middles(int count, float half) {
  std::vector<float> middles(count);
  for (int i = 0; i < count; ++i) {
    const int place = i % kWidth * (count / kWidth) + i / kWidth;
    middles[i] = static_cast<float>(2 * place + 1) * half;
  }
  return middles;
}

/// values · factor + beyond
std::vector<float> times(const std::vector<float>& values, float factor, const std::vector<float>& beyond) {
  std::vector<float> result(values.size());
  std::transform(values.begin(), values.end(), beyond.begin(), result.begin(),
                 [factor](float x, float more) { return x * factor + more; });
  return result;
}

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

std::vector<float> body_levers(const std::vector<CellGeometry>& planned) {
  std::size_t dimensions = 0;
  std::size_t bodies = 0;
  for (const CellGeometry& geometry : planned) {
    dimensions += static_cast<std::size_t>(geometry.own_arm().model->joints());
    bodies += geometry.own_bodies().size();
  }
  std::vector<float> levers(bodies * dimensions, 0.0F);
  float* row = levers.data();
  int first = 0;
  for (const CellGeometry& geometry : planned) {
    for (const Body& body : geometry.own_bodies()) {
      add_levers(geometry.own_arm(), body, row + first);
      row += dimensions;
    }
    first += geometry.own_arm().model->joints();
  }
  return levers;
}

bool Validity::proven_free(const float* a, const float* b, double clearance) const {
  std::vector<float> middle(stride());
  for (int j = 0; j < stride(); ++j) middle[j] = 0.5F * (a[j] + b[j]);
  return proven_free(a, middle.data(), b, clearance);
}

bool Validity::proven_free(const float* a, const float* corner, const float* b, double clearance,
                           const float* spread) const {
  const Curve curve{a, corner, b, stride()};
  const Motion speeds(robot_, levers_, [&](int j) { return curve.fastest(j); });  // per unit of t
  const Motion beyond(robot_, levers_, [&](int j) { return spread == nullptr ? 0.0F : spread[j]; });
  const float fastest = *std::max_element(speeds.body.begin(), speeds.body.end());
  const int first = kWidth * std::max(1, static_cast<int>(std::ceil(curve.longest() / (options_.step * kWidth))));
  float half = 0.5F / static_cast<float>(first);
  std::vector<float> middles = first_middles(first, half);
  std::vector<float> halves;
  std::vector<float> q(static_cast<std::size_t>(kWidth) * stride());
  for (;; half *= 0.5F) {
    const std::vector<float> growth = times(speeds.body, half, beyond.body);
    const std::vector<float> pair_growth = times(speeds.pair, half, beyond.pair);
    const KernelSweep sweep{growth.data(), pair_growth.data(), static_cast<float>(options_.padding + clearance),
                            fastest * half < kCoarse};
    halves.clear();
    for (std::size_t i = 0; i < middles.size(); i += kWidth) {
      const std::size_t count = std::min<std::size_t>(kWidth, middles.size() - i);
      for (std::size_t lane = 0; lane < kWidth; ++lane) {
        curve.at(middles[i + std::min(lane, count - 1)], q.data() + lane * stride());
      }
      checks_ += kWidth;
      const SweepHits hits = fastest_validity().swept(robot_, world_, exact(), sweep, q.data(), stride());
      if (hits.sure != 0) return false;
      for (std::size_t lane = 0; lane < count; ++lane) {
        if ((hits.maybe >> lane & 1U) == 0) continue;
        halves.push_back(middles[i + lane] - 0.5F * half);
        halves.push_back(middles[i + lane] + 0.5F * half);
      }
    }
    if (halves.empty()) return true;
    if (fastest * half < kFinest || halves.size() > kMaxSegments) return false;
    middles.swap(halves);
  }
}

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
      // A joint that moves both bodies, of one arm, does not move them relative to each other.
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
