#include "planner/model/collision_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "planner/model/inverse_kinematics.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/model/rate_bounds.hpp"
#include "planner/model/whole_turns.hpp"

namespace hecaton::planner {
namespace {

struct Region {
  JointVector middle;
  JointVector half_width;
  double distance = 0.0;  ///< sign · d at the middle [m]
};

RateBounds rate_bounds(const RobotModel& model, int a, int b) {
  const auto part = [&](const LinkGeometry& geometry) {
    return link_part(geometry.link, geometry.shape, geometry.X_LS);
  };
  return {model, part(model.geometry[a]), part(model.geometry[b])};
}

double pair_distance(const RobotModel& model, int a, int b, const PairDistance& distance,
                     const Kinematics& kinematics) {
  const LinkGeometry& one = model.geometry[a];
  const LinkGeometry& other = model.geometry[b];
  return distance(one.shape, kinematics.X_WL[one.link] * one.X_LS, other.shape,
                  kinematics.X_WL[other.link] * other.X_LS);
}

/// A joint that a proof holds at a position [rad].
struct HeldJoint {
  int joint = -1;  ///< −1: none
  double position = 0.0;
};

/// Proves sign · d > bound for the distance d of a and b in all configurations. Branch and bound with their RateBounds.
/// Of two halves the one with the smaller value comes first: without a proof it leads to a counterexample.
bool proven_everywhere(const RobotModel& model, int a, int b, const RateBounds& bounds, const PairDistance& distance,
                       double sign, double bound, int budget, const HeldJoint& held = {}) {
  const int n = model.joints();
  Region everything{RateBounds::reference(model), JointVector::Zero(n)};
  for (const int j : bounds.joints()) {
    const double lower = model.limits.lower[j];
    const double upper = model.limits.upper[j];
    const bool endless = !std::isfinite(lower) || !std::isfinite(upper);
    everything.middle[j] = endless ? 0.0 : 0.5 * (lower + upper);
    everything.half_width[j] = endless ? std::numbers::pi : 0.5 * (upper - lower);
    // One turn has all postures.
    if (repeats_after_turn(model, j)) everything.half_width[j] = std::min(everything.half_width[j], std::numbers::pi);
    if (j != held.joint) continue;
    everything.middle[j] = held.position;
    everything.half_width[j] = 0.0;
  }

  Kinematics kinematics;
  int evaluations = 0;
  // False: the middle is a counterexample, or the budget is used up.
  const auto evaluate = [&](Region& region) {
    if (evaluations++ >= budget) return false;
    forward_kinematics(model, Pose::Identity(), region.middle, kinematics);
    region.distance = sign * pair_distance(model, a, b, distance, kinematics);
    return region.distance > bound;
  };
  if (!evaluate(everything)) return false;
  std::vector<Region> open{everything};
  while (!open.empty()) {
    const Region region = open.back();
    open.pop_back();
    double change = 0.0;
    int widest = 0;
    for (int i = 0; i < n; ++i) {
      change += bounds.rates()[i] * region.half_width[i];
      if (bounds.rates()[i] * region.half_width[i] > bounds.rates()[widest] * region.half_width[widest]) widest = i;
    }
    if (region.distance - change > bound) continue;
    Region low = region;
    low.half_width[widest] *= 0.5;
    Region high = low;
    low.middle[widest] -= low.half_width[widest];
    high.middle[widest] += high.half_width[widest];
    if (!evaluate(low) || !evaluate(high)) return false;
    if (low.distance < high.distance) std::swap(low, high);
    open.push_back(std::move(low));
    open.push_back(std::move(high));
  }
  return true;
}

}  // namespace

bool proven_apart(const RobotModel& model, int a, int b, const PairDistance& distance, double apart, int budget) {
  return proven_everywhere(model, a, b, rate_bounds(model, a, b), distance, 1.0, apart, budget);
}

bool proven_within(const RobotModel& model, int a, int b, const PairDistance& distance, double within, int budget) {
  return proven_everywhere(model, a, b, rate_bounds(model, a, b), distance, -1.0, -within, budget);
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
      if (pair_distance(model, count.pair.first, count.pair.second, distance, kinematics) > options.contact)
        ++count.clear;
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
  model.details.push_back("self-collision is not checked between links that " + reason + ": " + names(model, pairs));
}

}  // namespace

Pairs pairs_of_separate_bodies(const RobotModel& model) {
  Pairs pairs;
  for (int a = 0; a < static_cast<int>(model.geometry.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(model.geometry.size()); ++b) {
      const int axes_a = axes_before(model, model.geometry[a].link);  // numbers the rigid bodies from the base
      const int axes_b = axes_before(model, model.geometry[b].link);
      if (std::abs(axes_a - axes_b) > 1) pairs.emplace_back(a, b);
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
  model.details.push_back("no posture parts these links by more than " + millimetres(widest) +
                          (proven ? " (proven)" : " (found in " + std::to_string(options.samples) + " postures)") +
                          ", therefore they keep smaller distances than other links: " + names(model, may_touch));
}

int joints_between(const RobotModel& model, int a, int b) {
  return std::abs(axes_before(model, model.geometry[a].link) - axes_before(model, model.geometry[b].link));
}

/// Positions of a turn at which a joint may be blocked; a divisor of 360, so that half a turn is one of them.
constexpr int kTurnPositions = 24;

/// A pair whose distance a joint changes.
struct TurnedPair {
  std::pair<int, int> pair;
  RateBounds bounds;
};

std::vector<TurnedPair> pairs_turned_by(const RobotModel& model, int joint) {
  std::vector<TurnedPair> turned;
  for (const auto& pair : model.self_pairs) {
    RateBounds bounds = rate_bounds(model, pair.first, pair.second);
    if (bounds.joints().contains(joint)) turned.push_back({pair, std::move(bounds)});
  }
  return turned;
}

/// True if a pair overlaps in every posture with `joint` at `position` [rad].
bool blocked_at(const RobotModel& model, const std::vector<TurnedPair>& turned, int joint, double position,
                const PairDistance& distance, const FilterOptions& options) {
  return std::any_of(turned.begin(), turned.end(), [&](const TurnedPair& one) {
    return proven_everywhere(model, one.pair.first, one.pair.second, one.bounds, distance, -1.0, 0.0,
                             options.proof_budget, {joint, position});
  });
}

/// The widest range between blocked positions of a joint; of equals, the nearest to zero. Empty: nothing blocks it.
std::optional<std::pair<double, double>> passable_range(const RobotModel& model, int joint,
                                                        const PairDistance& distance, const FilterOptions& options) {
  const bool endless = !std::isfinite(model.limits.lower[joint]) || !std::isfinite(model.limits.upper[joint]);
  const double lower = endless ? -kWholeTurn : model.limits.lower[joint];
  const double upper = endless ? kWholeTurn : model.limits.upper[joint];
  if (upper - lower <= kWholeTurn) return std::nullopt;
  const std::vector<TurnedPair> turned = pairs_turned_by(model, joint);
  std::vector<double> bounds;
  for (int k = 0; k < kTurnPositions; ++k) {
    const double position = kWholeTurn * k / kTurnPositions;
    if (!blocked_at(model, turned, joint, position, distance, options)) continue;
    for (double at = position + kWholeTurn * std::ceil((lower - position) / kWholeTurn); at <= upper;
         at += kWholeTurn) {
      bounds.push_back(at);
    }
  }
  if (bounds.empty()) return std::nullopt;
  if (!endless) {
    bounds.push_back(lower);
    bounds.push_back(upper);
  }
  std::sort(bounds.begin(), bounds.end());
  std::pair widest{bounds[0], bounds[0]};
  for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
    constexpr double kEqual = 1e-6;  // [rad]
    const double gain = bounds[i + 1] - bounds[i] - (widest.second - widest.first);
    const bool nearer = std::abs(bounds[i] + bounds[i + 1]) < std::abs(widest.first + widest.second);
    if (gain > kEqual || (gain > -kEqual && nearer)) widest = {bounds[i], bounds[i + 1]};
  }
  return widest;
}

std::string degrees(double radians) {
  return std::to_string(std::lround(radians * 180.0 / std::numbers::pi)) + "°";
}

/// Ends joints of more than one turn where they cannot go on, because a pair overlaps in every posture. Other turns
/// have the same postures, but no motion of the arm leads there.
void end_blocked_turns(RobotModel& model, const PairDistance& distance, const FilterOptions& options) {
  std::string joints;
  for (Link& link : model.links) {
    if (link.joint < 0 || link.follows || !repeats_after_turn(model, link.joint)) continue;
    const auto range = passable_range(model, link.joint, distance, options);
    if (!range) continue;
    std::tie(model.limits.lower[link.joint], model.limits.upper[link.joint]) = *range;
    link.joint_type = JointType::kRevolute;
    joints +=
        (joints.empty() ? "" : ", ") + link.joint_name + " " + degrees(range->first) + " to " + degrees(range->second);
  }
  if (joints.empty()) return;
  model.notes.push_back("joints end where links overlap in every posture, because no motion passes there: " + joints);
  std::erase_if(model.named, [&](const auto& pose) {
    const JointVector& q = pose.second;
    const bool within =
        (q.array() >= model.limits.lower.array()).all() && (q.array() <= model.limits.upper.array()).all();
    if (!within) model.notes.push_back("pose " + pose.first + " of the SRDF is left out: it is in another turn");
    return !within;
  });
}

}  // namespace

void automatic_filter(RobotModel& model, const PairDistance& distance, const FilterOptions& options) {
  if (options.samples > 0)
    remove(model, always_touching(model, distance, options),
           "touch in nearly every posture, or are nearer than " + millimetres(options.contact));
  Pairs apart;
  Pairs never_touching;
  for (const auto& [a, b] : model.self_pairs) {
    if (proven_apart(model, a, b, distance, options.apart, options.proof_budget)) {
      apart.emplace_back(a, b);
    } else if (joints_between(model, a, b) == 2 &&
               proven_apart(model, a, b, distance, options.touching, options.close_budget)) {
      never_touching.emplace_back(a, b);
    }
  }
  remove(model, apart, "provably never come near each other");
  remove(model, never_touching, "have two joints between them and provably never touch");
  filter_close_pairs(model, distance, options);
  end_blocked_turns(model, distance, options);
}

}  // namespace hecaton::planner
