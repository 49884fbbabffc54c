#include "planner/model/collision_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "planner/model/inverse_kinematics.hpp"
#include "planner/model/kinematics.hpp"

namespace hecaton::planner {
namespace {

/// Points in S whose convex hull, inflated by a ball, is the shape or a superset of it.
std::vector<Eigen::Vector3d> core_points(const world::Shape& shape) {
  const auto corners = [](const Eigen::Vector3d& half) {
    std::vector<Eigen::Vector3d> points;
    for (const double x : {-half.x(), half.x()}) {
      for (const double y : {-half.y(), half.y()}) {
        for (const double z : {-half.z(), half.z()}) points.emplace_back(x, y, z);
      }
    }
    return points;
  };
  if (const auto* box = std::get_if<world::Box>(&shape)) return corners(box->half_extents);
  if (const auto* capsule = std::get_if<world::Capsule>(&shape)) return corners({0.0, 0.0, capsule->half_length});
  if (const auto* cylinder = std::get_if<world::Cylinder>(&shape)) {
    return corners({cylinder->radius, cylinder->radius, cylinder->half_length});
  }
  if (const auto* convex = std::get_if<world::Convex>(&shape)) return convex->hull->vertices;
  return {Eigen::Vector3d::Zero()};
}

/// For each joint between a and b, a bound on the change of their distance per unit of motion.
///
/// With witness points p_a, p_b and n from a to b, ḋ = n·(v_b − v_a) = q̇ n·(z × (p_b − o)) = q̇ n·(z × (p_a − o)),
/// because n is parallel to p_b − p_a. Balls do not contribute: n·(z × r n) = 0. So |ḋ| ≤ |q̇| times the distance of the
/// furthest core point from the axis, for either shape. For a prismatic joint |ḋ| ≤ |q̇|.
class RateBounds {
 public:
  RateBounds(const RobotModel& model, int a, int b) : model_(model) {
    forward_kinematics(model, Pose::Identity(), reference(model), kinematics_);
    first_ = joints_before(model, model.geometry[a].link);
    last_ = joints_before(model, model.geometry[b].link) - 1;
    for (int j = first_; j <= last_; ++j) {
      rates_.push_back(kinematics_.prismatic[j] ? 1.0 : std::min(reach_of_a(a, j), reach_of_b(b, j)));
    }
  }
  [[nodiscard]] int first() const { return first_; }
  [[nodiscard]] const std::vector<double>& rates() const { return rates_; }
  [[nodiscard]] bool prismatic(int i) const { return kinematics_.prismatic[first_ + i]; }

  static JointVector reference(const RobotModel& model) {
    JointVector q = JointVector::Zero(model.joints());
    for (int j = 0; j < model.joints(); ++j) {
      if (std::isfinite(model.limits.lower[j])) q[j] = std::clamp(0.0, model.limits.lower[j], model.limits.upper[j]);
    }
    return q;
  }

 private:
  [[nodiscard]] double off_axis(const Eigen::Vector3d& p_W, int joint) const {
    return kinematics_.axis_W[joint].cross(p_W - kinematics_.origin_W[joint]).norm();
  }
  /// Travel of a prismatic joint: distances across the joint grow by at most this from the reference.
  [[nodiscard]] double travel(int joint) const {
    return kinematics_.prismatic[joint] ? model_.limits.upper[joint] - model_.limits.lower[joint] : 0.0;
  }
  [[nodiscard]] double between_origins(int joint) const {  // joint and joint + 1
    return (kinematics_.origin_W[joint + 1] - kinematics_.origin_W[joint]).norm() + travel(joint);
  }
  [[nodiscard]] std::vector<Eigen::Vector3d> core_W(int geometry) const {
    const LinkGeometry& g = model_.geometry[geometry];
    std::vector<Eigen::Vector3d> points = core_points(g.shape);
    for (auto& p : points) p = kinematics_.X_WL[g.link] * (g.X_LS * p);
    return points;
  }
  template <typename Measure>
  [[nodiscard]] double furthest(int geometry, Measure measure) const {
    double result = 0.0;
    for (const auto& p_W : core_W(geometry)) result = std::max(result, measure(p_W));
    return result;
  }

  /// Joint last_ carries b: exact for last_, by the triangle inequality along the chain for joints before it.
  [[nodiscard]] double reach_of_b(int b, int joint) const {
    if (joint == last_) return furthest(b, [&](const auto& p_W) { return off_axis(p_W, joint); });
    double reach = off_axis(kinematics_.origin_W[joint + 1], joint);
    for (int j = joint + 1; j < last_; ++j) reach += between_origins(j);
    return reach + travel(last_) +
           furthest(b, [&](const auto& p_W) { return (p_W - kinematics_.origin_W[last_]).norm(); });
  }
  /// Joint first_ is mounted on the body of a: exact for first_.
  [[nodiscard]] double reach_of_a(int a, int joint) const {
    if (joint == first_) return furthest(a, [&](const auto& p_W) { return off_axis(p_W, joint); });
    double reach = off_axis(kinematics_.origin_W[joint - 1], joint) + travel(joint - 1);
    for (int j = first_; j < joint - 1; ++j) reach += between_origins(j);
    return reach + furthest(a, [&](const auto& p_W) { return (p_W - kinematics_.origin_W[first_]).norm(); });
  }

  const RobotModel& model_;
  Kinematics kinematics_;
  int first_ = 0;
  int last_ = 0;
  std::vector<double> rates_;
};

struct Region {
  JointVector middle;
  JointVector half_width;
};

double pair_distance(const RobotModel& model, int a, int b, const PairDistance& distance,
                     const Kinematics& kinematics) {
  const LinkGeometry& one = model.geometry[a];
  const LinkGeometry& other = model.geometry[b];
  return distance(one.shape, kinematics.X_WL[one.link] * one.X_LS, other.shape,
                  kinematics.X_WL[other.link] * other.X_LS);
}

/// Proves sign · d > bound for the distance d of a and b in all configurations. Branch and bound with RateBounds.
bool proven_everywhere(const RobotModel& model, int a, int b, const PairDistance& distance, double sign, double bound,
                       int budget) {
  if (joints_before(model, model.geometry[a].link) > joints_before(model, model.geometry[b].link)) std::swap(a, b);
  const RateBounds bounds(model, a, b);
  const int n = static_cast<int>(bounds.rates().size());
  Region everything{JointVector::Zero(n), JointVector::Zero(n)};
  for (int i = 0; i < n; ++i) {
    const double lower = model.limits.lower[bounds.first() + i];
    const double upper = model.limits.upper[bounds.first() + i];
    const bool endless = !std::isfinite(lower) || !std::isfinite(upper);
    everything.middle[i] = endless ? 0.0 : 0.5 * (lower + upper);
    everything.half_width[i] = endless ? std::numbers::pi : 0.5 * (upper - lower);
    // One turn of a joint that turns has all its postures.
    if (!bounds.prismatic(i)) everything.half_width[i] = std::min(everything.half_width[i], std::numbers::pi);
  }

  JointVector q = RateBounds::reference(model);
  Kinematics kinematics;
  std::vector<Region> open{everything};
  for (int evaluations = 0; !open.empty(); ++evaluations) {
    if (evaluations >= budget) return false;
    const Region region = open.back();
    open.pop_back();
    q.segment(bounds.first(), n) = region.middle;
    forward_kinematics(model, Pose::Identity(), q, kinematics);
    const double d = sign * pair_distance(model, a, b, distance, kinematics);
    if (!(d > bound)) return false;
    double change = 0.0;
    int widest = 0;
    for (int i = 0; i < n; ++i) {
      change += bounds.rates()[i] * region.half_width[i];
      if (bounds.rates()[i] * region.half_width[i] > bounds.rates()[widest] * region.half_width[widest]) widest = i;
    }
    if (d - change > bound) continue;
    Region half = region;
    half.half_width[widest] *= 0.5;
    half.middle[widest] = region.middle[widest] - half.half_width[widest];
    open.push_back(half);
    half.middle[widest] = region.middle[widest] + half.half_width[widest];
    open.push_back(half);
  }
  return true;
}

}  // namespace

bool proven_apart(const RobotModel& model, int a, int b, const PairDistance& distance, double apart, int budget) {
  return proven_everywhere(model, a, b, distance, 1.0, apart, budget);
}

bool proven_within(const RobotModel& model, int a, int b, const PairDistance& distance, double within, int budget) {
  return proven_everywhere(model, a, b, distance, -1.0, -within, budget);
}

namespace {

using Pairs = std::vector<std::pair<int, int>>;

/// Calls visit with the kinematics of each random configuration until it returns false.
template <typename Visit>
void sample(const RobotModel& model, const FilterOptions& options, Visit visit) {
  std::mt19937_64 random(options.random_seed);
  Kinematics kinematics;
  for (int i = 0; i < options.samples; ++i) {
    const JointVector q = random_configuration(model.limits, random);
    forward_kinematics(model, Pose::Identity(), q, kinematics);
    if (!visit(q, kinematics)) return;
  }
}

Pairs always_touching(const RobotModel& model, const PairDistance& distance, const FilterOptions& options) {
  struct Count {
    std::pair<int, int> pair;
    int clear = 0;  ///< samples in which it does not touch
  };
  std::vector<Count> counts;
  for (const auto& pair : model.self_pairs) counts.push_back({pair});
  const double most_clear = (1.0 - options.always) * options.samples;
  sample(model, options, [&](const JointVector& /*q*/, const Kinematics& kinematics) {
    std::erase_if(counts, [&](Count& count) {
      if (pair_distance(model, count.pair.first, count.pair.second, distance, kinematics) > 0.0) ++count.clear;
      return count.clear > most_clear;
    });
    return !counts.empty();
  });
  Pairs touching;
  for (const Count& count : counts) touching.push_back(count.pair);
  return touching;
}

/// A pair and the configuration in which a search found it farthest apart.
struct Farthest {
  ClosePair pair;
  JointVector q;
};

/// Increases the distance of the pair joint by joint, with steps that halve, until it exceeds `enough` [m].
void climb(const RobotModel& model, const PairDistance& distance, double enough, Farthest& found) {
  constexpr double kFirstStep = 0.4;  // [rad | m]
  constexpr double kLastStep = 0.01;
  Kinematics kinematics;
  for (double step = kFirstStep; step > kLastStep && found.pair.widest <= enough;) {
    bool better = false;
    for (int j = 0; j < model.joints(); ++j) {
      for (const double change : {-step, step}) {
        JointVector q = found.q;
        q[j] = std::clamp(q[j] + change, model.limits.lower[j], model.limits.upper[j]);
        forward_kinematics(model, Pose::Identity(), q, kinematics);
        const double d = pair_distance(model, found.pair.first, found.pair.second, distance, kinematics);
        if (d <= found.pair.widest + 1e-9) continue;
        found.pair.widest = d;
        found.q = q;
        better = true;
      }
    }
    if (!better) step *= 0.5;
  }
}

/// The pairs whose distance exceeds options.close in no posture that sampling and climbing found.
std::vector<ClosePair> find_close_pairs(const RobotModel& model, const PairDistance& distance,
                                        const FilterOptions& options) {
  std::vector<Farthest> close;
  if (options.samples <= 0) return {};
  for (const auto& [a, b] : model.self_pairs) close.push_back({{a, b, 0.0}, {}});
  sample(model, options, [&](const JointVector& q, const Kinematics& kinematics) {
    std::erase_if(close, [&](Farthest& one) {
      const double d = pair_distance(model, one.pair.first, one.pair.second, distance, kinematics);
      if (one.q.size() == 0 || d > one.pair.widest) one = {{one.pair.first, one.pair.second, d}, q};
      return d > options.close;
    });
    return !close.empty();
  });
  std::vector<ClosePair> pairs;
  for (Farthest& one : close) {
    climb(model, distance, options.close, one);
    // A pair that touches in most postures and parts in a few has a widest distance above 0.
    if (one.pair.widest > 0.0 && one.pair.widest <= options.close) pairs.push_back(one.pair);
  }
  return pairs;
}

std::string names(const RobotModel& model, const Pairs& pairs) {
  std::string text;
  for (const auto& [a, b] : pairs) {
    const std::string pair = model.links[model.geometry[a].link].name + "–" + model.links[model.geometry[b].link].name;
    if (text.find(pair) == std::string::npos) text += (text.empty() ? "" : ", ") + pair;
  }
  return text;
}

void remove(RobotModel& model, const Pairs& pairs, const std::string& reason) {
  if (pairs.empty()) return;
  std::erase_if(model.self_pairs,
                [&](const auto& pair) { return std::find(pairs.begin(), pairs.end(), pair) != pairs.end(); });
  model.notes.push_back("self-collision is not checked between links that " + reason + ": " + names(model, pairs));
}

}  // namespace

Pairs pairs_of_separate_bodies(const RobotModel& model) {
  Pairs pairs;
  for (int a = 0; a < static_cast<int>(model.geometry.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(model.geometry.size()); ++b) {
      const int joints_a = joints_before(model, model.geometry[a].link);  // numbers the rigid bodies from the base
      const int joints_b = joints_before(model, model.geometry[b].link);
      if (std::abs(joints_a - joints_b) > 1) pairs.emplace_back(a, b);
    }
  }
  return pairs;
}

namespace {

std::string millimetres(double metres) {
  return std::to_string(static_cast<int>(std::ceil(1e3 * metres))) + " mm";
}

/// Drops adjacent pairs that provably cannot touch, and explains those that stay.
void filter_close_pairs(RobotModel& model, const PairDistance& distance, const FilterOptions& options) {
  std::vector<ClosePair> kept;
  Pairs never_touching;
  Pairs may_touch;
  double widest = 0.0;
  bool proven = true;
  for (const ClosePair& pair : find_close_pairs(model, distance, options)) {
    const bool adjacent = pair.widest <= options.adjacent;
    if (adjacent && proven_apart(model, pair.first, pair.second, distance, options.touching, options.close_budget)) {
      never_touching.emplace_back(pair.first, pair.second);
      continue;
    }
    kept.push_back(pair);
    if (!adjacent) continue;
    may_touch.emplace_back(pair.first, pair.second);
    widest = std::max(widest, pair.widest);
    proven = proven && proven_within(model, pair.first, pair.second, distance, pair.widest + options.touching,
                                     options.close_budget);
  }
  remove(model, never_touching,
         "no posture parts by more than " + millimetres(options.adjacent) + " and that provably never touch");
  model.close_pairs = std::move(kept);
  if (may_touch.empty()) return;
  model.notes.push_back("no posture parts these links by more than " + millimetres(widest) +
                        (proven ? " (proven)" : " (found in " + std::to_string(options.samples) + " postures)") +
                        ", therefore they keep smaller distances than other links: " + names(model, may_touch));
}

}  // namespace

void automatic_filter(RobotModel& model, const PairDistance& distance, const FilterOptions& options) {
  if (options.samples > 0) remove(model, always_touching(model, distance, options), "touch in nearly every posture");
  Pairs apart;
  for (const auto& [a, b] : model.self_pairs) {
    if (proven_apart(model, a, b, distance, options.apart, options.proof_budget)) apart.emplace_back(a, b);
  }
  remove(model, apart, "provably never come near each other");
  filter_close_pairs(model, distance, options);
}

}  // namespace hecaton::planner
