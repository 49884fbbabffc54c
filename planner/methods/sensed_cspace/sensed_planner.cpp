#include "planner/methods/sensed_cspace/sensed_planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/local/goal_objective.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner::cspace {
namespace {

/// Cells that a search expands in a control period.
constexpr int kCellsPerPeriod = 2'000;
/// New points that are mapped in a control period, times planes. The cost of one point in one plane is bounded.
constexpr int kMappingsPerPeriod = 4'096;
/// Points of the path that are checked for visibility in a period.
constexpr int kLooksPerPeriod = 40;
/// The arm leaves a blocked cell at no more than this share of its maximum velocity.
constexpr double kLeavingSpeed = 0.1;
/// Distance of positions in the trail [cells], and their largest number.
constexpr double kTrailStep = 0.25;
constexpr std::size_t kLongestTrail = 20'000;
/// Beyond this jump [cells] something else has moved the arm, and the trail is not valid.
constexpr double kJump = 8.0;
/// A slower arm counts as at rest [rad/s].
constexpr double kAtRest = 1e-3;
/// Within this distance the arm has reached a point [rad].
constexpr double kArrived = 1e-4;
/// After this many periods at rest away from its target, the arm cannot reach it.
constexpr int kRestingPeriods = 10;
/// A shorter vector has no direction [rad].
constexpr double kSame = 1e-6;

}  // namespace

SensedPlanner::SensedPlanner(const Arm& arm, const SensedParameters& parameters, double dt)
    : X_WB_(arm.X_WB),
      X_BW_(arm.X_WB.inverse()),
      model_(arm.model),
      limits_(arm.limits),
      dt_(dt),
      remember_(parameters.remember),
      planes_(*arm.model),
      known_(SensedMap(planes_, arm.limits, parameters)),
      search_(known_.map()) {
  if (remember_ != Remember::kAlways) rebuilt_ = known_;
}

void SensedPlanner::sense(const RangeScan& scan) {
  if (scan.sensor >= static_cast<int>(now_.size())) now_.resize(static_cast<std::size_t>(scan.sensor) + 1);
  forward_kinematics(*model_, Pose::Identity(), scan.q, kinematics_);
  const Pose& X_BL = kinematics_.X_WL[scan.link];
  std::vector<Eigen::Vector3d>& seen = now_[static_cast<std::size_t>(scan.sensor)];
  seen.clear();
  for (const RangeReading& reading : scan.readings) {
    if (!reading.hit) continue;
    seen.emplace_back(X_BL * (reading.ray.origin_L + reading.distance * reading.ray.direction_L));
    known_.note(reading.distance, seen.back());
    if (rebuilding_) rebuilt_->note(reading.distance, seen.back());
  }
  changed_ = true;
}

void SensedPlanner::add_obstacle(std::vector<Eigen::Vector3d> points_W) {
  for (Eigen::Vector3d& p : points_W) p = X_BW_ * p;
  blocked_more_ = known_.add(points_W) || blocked_more_;
}

/// Algorithm 3, steps 2.1 to 2.3: adds the scans to the map in shares of work. The arm stands until all points are
/// mapped.
void SensedPlanner::model() {
  const int planes = known_.map().size()[0];
  const int share = std::max(1, kMappingsPerPeriod / planes);
  int left = share;
  blocked_more_ = known_.advance(left) || blocked_more_;
  const bool remembers = remember_ == Remember::kAlways || (remember_ == Remember::kUntilNearer && detours_);
  if (remembers) {
    rebuilding_ = false;
  } else {
    rebuild_map(left);
  }
  mapped_ += static_cast<std::int64_t>(share - left) * planes;
}

/// Forgets points outside the present scans: builds a second map of the present scans, and replaces the first one when
/// it is complete. New points enter both maps meanwhile, so that the map never misses a measured point.
void SensedPlanner::rebuild_map(int& points) {
  if (!rebuilding_) {
    if (!changed_) return;
    changed_ = false;
    std::vector<Eigen::Vector3d> seen;
    for (const auto& of_sensor : now_) seen.insert(seen.end(), of_sensor.begin(), of_sensor.end());
    if (known_.complete() && known_.map().holds_exactly(seen)) return;
    rebuilt_->forget();
    for (const Eigen::Vector3d& p_B : seen) rebuilt_->note(0.0, p_B);
    rebuilding_ = true;
  }
  (void)rebuilt_->advance(points);
  if (!rebuilt_->complete()) return;
  std::swap(known_, *rebuilt_);
  rebuilding_ = false;
  blocked_more_ = forgot_ = true;
}

/// differs from paper: [Li96] uses Lumelsky's rules, which follow a boundary from a hit point to a leave point nearer
/// to the goal. Here a search among all points since the hit point replaces the boundary. Each leave point is at least
/// one cell nearer, so that the number of detours is finite.
void SensedPlanner::note_progress(const JointVector& q, bool straight) {
  const double distance = (q_goal_ - q).norm();
  if (!detours_ && !straight) {
    detours_ = true;
    nearest_ = std::min(nearest_, distance) - map().pitch();
  } else if (detours_ && straight && distance < nearest_) {
    detours_ = false;
  }
}

bool SensedPlanner::path_free() const {
  return std::none_of(path_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, path_.size())), path_.end(),
                      [&](const Cell3& cell) { return map().blocked(cell); });
}

/// The centre of a cell, clamped to the joint limits. The last point is the goal.
JointVector SensedPlanner::path_point(std::size_t i) const {
  if (i + 1 == path_.size()) return q_goal_;
  return map().centre(path_[i]).cwiseMax(limits_.lower).cwiseMin(limits_.upper);
}

void SensedPlanner::search_from(const JointVector& q) {
  at_ = 0;
  forgot_ = false;
  search_.begin(map(), map().cell_at(q), map().cell_at(q_goal_));
  ++searches_;
}

/// Continues the search. Drops a path that new points block, and the result kNone if cells were freed. Returns true if
/// there is a path.
bool SensedPlanner::search_on() {
  using State = CspaceSearch::State;
  const State state = search_.advance(map(), kCellsPerPeriod);
  if (state == State::kFound) path_ = search_.path(map());
  if ((state == State::kFound && !path_free()) || (state == State::kNone && forgot_)) drop_path();
  return !path_.empty();
}

MotionGuide::Aim SensedPlanner::guide(const JointVector& q, const JointVector& qd, const JointVector& q_goal) {
  model();
  const Aim chosen = choose(q, qd, q_goal);
  none_ = chosen.path == Path::kNone;
  return chosen;
}

MotionGuide::Aim SensedPlanner::choose(const JointVector& q, const JointVector& qd, const JointVector& q_goal) {
  const bool other_goal = q_goal_.size() != q_goal.size() || q_goal_ != q_goal;
  if (other_goal) begin(q_goal);
  const JointVector rest = rest_position(limits_, q, qd);
  if (map().blocked(map().cell_at(q))) return go_back(q, qd);
  remember_place(q);
  straight_ = map().straight_path_free(q, q_goal, !straight_);
  note_progress(q, straight_);
  if (blocked_more_ && !path_.empty() && !path_free()) {
    careful_ = false;
    drop_path();
  }
  blocked_more_ = false;
  if (path_.empty()) {
    const bool may_begin = !map().blocked(map().cell_at(rest)) && (!careful_ || qd.cwiseAbs().maxCoeff() < kAtRest);
    if (search_.state() == CspaceSearch::State::kIdle && may_begin) search_from(rest);
    if (!search_on()) return {search_.state() == CspaceSearch::State::kNone ? Path::kNone : Path::kSearching, rest};
  }
  const bool direct = straight_ && !careful_;
  const bool in_sight = look_ahead(q) || direct;
  const JointVector target = direct ? q_goal : path_point(at_);
  if (!in_sight || stands(q, qd, target)) {
    drop_path();
    careful_ = true;
    return {Path::kSearching, rest};
  }
  return {straight_ ? Path::kStraight : Path::kAround, ahead(q, qd, target)};
}

/// True if the arm cannot reach its target. This happens when the target changed during motion: the line is free at its
/// sampled positions, but not at those of a stop. Motion from rest to rest along the path resolves it.
bool SensedPlanner::stands(const JointVector& q, const JointVector& qd, const JointVector& target) {
  const bool rests = qd.cwiseAbs().maxCoeff() < kAtRest && (target - q).norm() > kArrived && known_.complete();
  standing_ = rests ? standing_ + 1 : 0;
  return standing_ > kRestingPeriods && !careful_;
}

void SensedPlanner::begin(const JointVector& q_goal) {
  q_goal_ = q_goal;
  detours_ = straight_ = careful_ = false;
  standing_ = 0;
  nearest_ = std::numeric_limits<double>::infinity();
  drop_path();
}

void SensedPlanner::drop_path() {
  path_.clear();
  search_.stop();
}

void SensedPlanner::remember_place(const JointVector& q) {
  const double step = trail_.empty() ? 0.0 : (q - trail_.back()).cwiseAbs().maxCoeff() / map().pitch();
  if (!trail_.empty() && step < kTrailStep) return;
  if (step > kJump) trail_.clear();
  if (trail_.size() == kLongestTrail) trail_.erase(trail_.begin(), trail_.begin() + kLongestTrail / 2);
  trail_.push_back(q);
}

/// Leaves a blocked cell along the trail. Neighbours of a blocked cell may be inside the obstacle; the trail was free.
MotionGuide::Aim SensedPlanner::go_back(const JointVector& q, const JointVector& qd) {
  drop_path();
  const double near = 0.5 * kTrailStep * map().pitch();
  while (!trail_.empty() && (q - trail_.back()).cwiseAbs().maxCoeff() < near) trail_.pop_back();
  if (trail_.empty()) return {Path::kNone, rest_position(limits_, q, qd)};
  return {Path::kAround, ahead(q, qd, trail_.back())};
}

/// Selects the farthest visible point of the path. From a reached point of the path, the next one is always visible.
/// Returns false if no point is visible.
bool SensedPlanner::look_ahead(const JointVector& q) {
  const bool arrived = (path_point(at_) - q).norm() < kArrived;
  if (arrived && at_ + 1 < path_.size()) ++at_;
  const auto wide_open = [&](std::size_t i) { return map().straight_path_free(q, path_point(i), true); };
  for (int look = 0; (arrived || !careful_) && look < kLooksPerPeriod; ++look) {
    if (at_ + 1 >= path_.size() || !wide_open(at_ + 1)) break;
    ++at_;
  }
  return map().straight_path_free(q, path_point(at_));
}

/// A point on the line to the target, near enough that every joint reaches its share of the speed within one period.
/// Otherwise joints with short motions would finish early, and the arm would leave the line.
JointVector SensedPlanner::ahead(const JointVector& q, const JointVector& qd, const JointVector& target) const {
  const JointVector way = target - q;
  const double length = way.norm();
  if (length < kSame) return target;
  const JointVector d = way / length;
  double gain = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < d.size(); ++j) {
    if (std::abs(d[j]) > 1e-9) gain = std::min(gain, limits_.acceleration[j] * dt_ / std::abs(d[j]));
  }
  const double speed = std::max(0.0, d.dot(qd)) + 0.9 * gain;
  const double enough = approach_distance(limits_, d, speed, dt_);
  return length <= enough ? target : JointVector(q + enough * d);
}

bool SensedPlanner::may_go(const JointVector& from, const JointVector& q, const JointVector& qd) const {
  if (!known_.complete()) return false;
  if (map().straight_path_free(q, rest_position(limits_, q, qd))) return true;
  const bool slow = (qd.array().abs() <= kLeavingSpeed * limits_.velocity.array()).all();
  return slow && map().blocked(map().cell_at(from));
}

std::optional<std::string> SensedPlanner::no_path_reason(const JointVector& q) const {
  if (!none_) return std::nullopt;
  const auto too_near = [&](const char* what) {
    return std::string(what) + " is nearer to a known obstacle than sensed.margin and a cell of its map allow";
  };
  if (map().blocked(map().cell_at(q))) return too_near("the arm's position");
  if (map().blocked(map().cell_at(q_goal_))) return too_near("its goal");
  return "the known obstacles leave no path to the goal";
}

}  // namespace hecaton::planner::cspace
