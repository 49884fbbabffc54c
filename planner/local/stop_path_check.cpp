#include "planner/local/stop_path_check.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "planner/collision/exact_distance.hpp"
#include "planner/model/rate_bounds.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// Share of a pair's security distance that every measured place of a path keeps.
constexpr double kLimitShare = 0.5;
/// A step between measured places may use up a pair's distance down to this share of the limit.
constexpr double kFloorShare = 0.5;
/// Shortest step between measured places, as a share of the limit.
constexpr double kStepShare = 0.125;
/// A cut aims at this share of the limit more than a path must keep, because the distance is curved.
constexpr double kCutShare = 0.25;
/// Distances repeat up to rounding [m].
constexpr double kRounding = 1e-9;
/// A bound clears a pair only with this margin, many times the error of a distance [m]. A measurement then clears it,
/// too, so that the answer does not depend on the bound.
constexpr double kBoundMargin = 1e-5;
/// Measurements in one period, without those at its beginning.
constexpr int kMostMeasurements = 200;

LinkPart part_of(const Body& body) {
  return link_part(body.link, body.shape, body.X_CS);
}

/// How far the stop from q̇ leads along q̇ [s], at least. Set-points end a stop with a whole period, at most dt²/8T
/// farther than the stop profile.
double stop_way(const JointLimits& limits, const JointVector& qd, double dt) {
  const double T = stop_time(limits, qd);
  return T <= dt ? 0.5 * dt : 0.5 * T + dt * dt / (8.0 * T);
}

}  // namespace

StopPathCheck::StopPathCheck(const CellGeometry& geometry)
    : anchor_(JointVector::Zero(geometry.own_arm().model->joints())), kinematics_(std::make_unique<Kinematics>()) {
  const RobotModel& model = *geometry.own_arm().model;
  const std::vector<Body>& bodies = geometry.own_bodies();
  for (const auto& [first, second] : geometry.self_pairs()) {
    const auto part = [&](int i) { return Part{i, bodies[i].link, make_swept_core(bodies[i].shape), bodies[i].X_CS}; };
    Pair& pair = pairs_.emplace_back();
    pair.first = part(first);
    pair.second = part(second);
    pair.rates = RateBounds(model, part_of(bodies[first]), part_of(bodies[second])).rates();
    if (!pair.rates.allFinite()) {
      throw std::invalid_argument("a prismatic joint of " + model.name +
                                  " has no limits, but moves links that can touch");
    }
    pair.widest = geometry.widest(first, second);
    pair.bound = -std::numeric_limits<double>::infinity();
  }
  open_.reserve(pairs_.size());
}

void StopPathCheck::set_limits(const DamperParameters& damper) {
  security_distance_ = damper.self_security_distance;
  for (Pair& pair : pairs_) pair.limit = kLimitShare * damper.against_self(0.0, pair.widest).security_distance;
}

void StopPathCheck::begin(const CellGeometry& geometry, const DamperParameters& damper, const Start& start) {
  period_.arm = &geometry.own_arm();
  refusal_.reset();
  if (pairs_.empty()) return;
  if (security_distance_ != damper.self_security_distance) set_limits(damper);
  period_.near = start.near;
  period_.dt = start.dt;
  period_.measurements = 0;
  period_.q = start.q;
  period_.qd = start.qd;
  period_.error.setZero(start.q.size());
  if (start.tracking_error.size() == start.q.size()) {
    period_.q += start.tracking_error;
    period_.error = start.tracking_error.cwiseAbs();
  }
}

bool StopPathCheck::is_clear(const JointVector& qd_next) {
  refusal_.reset();
  if (period_.arm == nullptr) return false;
  if (pairs_.empty()) return true;
  const double dt = period_.dt;
  const double stop = stop_way(period_.arm->limits, qd_next, dt);
  const JointVector slowed = qd_next.cwiseAbs();
  const JointVector fastest = slowed.cwiseMax(period_.qd.cwiseAbs());
  const JointVector travel = dt * fastest + stop * slowed;
  if (bounds_clear(travel + (period_.q - anchor_).cwiseAbs())) return true;
  const Path path{qd_next, fastest, slowed, dt + stop};
  move_anchor();
  open_pairs(path, travel);
  return open_.empty() || walk(path);
}

/// `travel`: of each joint from the anchor along the path [rad | m].
bool StopPathCheck::bounds_clear(const JointVector& travel) const {
  return std::all_of(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
    return pair.bound - pair.rates.dot(travel) >= pair.limit + kBoundMargin;
  });
}

/// Moves the anchor to the beginning of the period, and takes over the distances that the tick has measured.
void StopPathCheck::move_anchor() {
  const JointVector moved = (period_.q - anchor_).cwiseAbs();
  anchor_ = period_.q;
  auto near = period_.near.begin();
  for (Pair& pair : pairs_) {
    pair.bound -= pair.rates.dot(moved);
    if (near == period_.near.end() || near->counterpart != Counterpart::kSelf || near->own_body != pair.first.body ||
        near->other_body != pair.second.body) {
      continue;
    }
    pair.bound = std::max(pair.bound, near->distance - pair.rates.dot(period_.error));
    ++near;
  }
}

/// `travel`: of each joint along the path [rad | m].
void StopPathCheck::open_pairs(const Path& path, const JointVector& travel) {
  open_.clear();
  for (Pair& pair : pairs_) {
    if (pair.bound - pair.rates.dot(travel) >= pair.limit + kBoundMargin) continue;
    open_.push_back({.pair = &pair,
                     .limit = pair.limit,
                     .period_rate = pair.rates.dot(path.fastest),
                     .stop_rate = pair.rates.dot(path.slowed)});
  }
}

/// The configuration at a place on the path.
JointVector StopPathCheck::place(const JointVector& qd_next, double at) const {
  const double dt = period_.dt;
  const double within = std::min(at, dt);
  return period_.q + within * period_.qd + (0.5 * within * within / dt) * (qd_next - period_.qd) +
         (at - within) * qd_next;
}

/// Measures the beginning, the set-point and the rest position unless rates clear them, because later periods start
/// there.
bool StopPathCheck::walk(const Path& path) {
  for (double at = 0.0; at <= path.end;) {
    place_links(*period_.arm->model, period_.arm->X_WB, place(path.qd_next, at), *kinematics_);
    double next = std::numeric_limits<double>::infinity();
    for (OpenPair& open : open_) {
      if (!open.open) continue;
      if (open.due <= at && !measure(path, at, open)) return false;
      if (open.open) next = std::min(next, open.due);
    }
    at = next;
  }
  return true;
}

bool StopPathCheck::measure(const Path& path, double at, OpenPair& open) {
  Pair& pair = *open.pair;
  const bool at_beginning = at == 0.0;
  if (!at_beginning && ++period_.measurements > kMostMeasurements) return false;
  const auto pose = [&](const Part& part) { return kinematics_->X_WL[part.link] * part.X_LS; };
  const ShapeDistance found = prepared_distance(pair.first.core, pose(pair.first), pair.second.core, pose(pair.second));
  const double distance = found.distance;
  if (at_beginning) {
    pair.bound = distance;
    open.limit = std::min(open.limit, distance - kRounding);
  }
  if (distance < open.limit) {
    refusal_ = Refusal{&pair, open.limit, found, at, path.qd_next};
    return false;
  }
  const double dt = period_.dt;
  const double to_set_point = open.period_rate * std::max(0.0, dt - at);
  if (distance - to_set_point - open.stop_rate * (path.end - std::max(at, dt)) >= open.limit) {
    open.open = false;
    return true;
  }
  const double step = std::max(distance - kFloorShare * pair.limit, kStepShare * pair.limit);
  open.due = std::min(at + step / (at < dt ? open.period_rate : open.stop_rate), path.end);
  const bool skips_set_point = at < dt && open.due > dt;
  if (skips_set_point && distance - to_set_point < open.limit) open.due = dt;
  return true;
}

std::optional<std::pair<int, int>> StopPathCheck::refused() const {
  if (!refusal_) return std::nullopt;
  return std::pair(refusal_->pair->first.body, refusal_->pair->second.body);
}

// The place on the path is q + … + lead · q̇', so that a change of q̇' by Δ moves it by lead · Δ. To first order the
// distance there becomes d − lead · g·Δ, which must be at least the limit.
Row StopPathCheck::cut() {
  const RobotModel& model = *period_.arm->model;
  const Refusal& refusal = *refusal_;
  const double within = std::min(refusal.at, period_.dt);
  const double lead = 0.5 * within * within / period_.dt + (refusal.at - within);
  forward_kinematics(model, period_.arm->X_WB, place(refusal.qd, refusal.at), *kinematics_);
  const ShapeDistance& found = refusal.distance;
  Row row;
  JointVector other;
  directional_jacobian(model, *kinematics_, refusal.pair->first.link, found.p_a_W, found.n_W, row.g);
  directional_jacobian(model, *kinematics_, refusal.pair->second.link, found.p_b_W, found.n_W, other);
  row.g -= other;
  const double aim = refusal.limit + kCutShare * refusal.pair->limit;
  row.h = row.g.dot(refusal.qd) + (found.distance - aim) / lead;
  return row;
}

}  // namespace hecaton::planner
