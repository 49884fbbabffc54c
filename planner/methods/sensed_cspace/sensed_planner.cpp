#include "planner/methods/sensed_cspace/sensed_planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/local/goal_objective.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner::cspace {
namespace {

/// Cells that a search looks at in a control period.
constexpr int kCellsPerPeriod = 2'000;
/// New points that are mapped in a control period, times planes: what one takes in a plane is bounded.
constexpr int kMappingsPerPeriod = 4'096;
/// Points of the way that are tried for being in sight in a period.
constexpr int kLooksPerPeriod = 40;
/// Who has to leave a blocked cell does so at no more than this share of the fastest.
constexpr double kLeavingSpeed = 0.1;
/// The arm's trail has a place for each such share of a cell, and so many at most.
constexpr double kTrailStep = 0.25;
constexpr std::size_t kLongestTrail = 20'000;
/// So many cells farther on it was moved by somebody else: where it came from is no way back.
constexpr double kJump = 8.0;
/// A slower arm is at rest [rad/s].
constexpr double kAtRest = 1e-3;
/// Who is nearer to a point has arrived there [rad].
constexpr double kArrived = 1e-4;
/// Who has rested so many periods although it has somewhere to go is not let go there.
constexpr int kPatience = 10;
/// What is nearer has no direction [rad].
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
  if (remember_ != Remember::kAlways) anew_ = known_;
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
    if (modelling_anew_) anew_->note(reading.distance, seen.back());
  }
  changed_ = true;
}

void SensedPlanner::see(const Eigen::Vector3d& p_W) {
  blocked_more_ = known_.see(X_BW_ * p_W) || blocked_more_;
}

/// Algorithm 3, steps 2.1 to 2.3: the map follows what the sensors see, a share of the work in each period. The arm
/// stands until nothing that is new is left to be mapped.
void SensedPlanner::model() {
  const int planes = known_.map().size()[0];
  const int share = std::max(1, kMappingsPerPeriod / planes);
  int left = share;
  blocked_more_ = known_.advance(left) || blocked_more_;
  const bool remembers = remember_ == Remember::kAlways || (remember_ == Remember::kUntilNearer && detours_);
  if (remembers) {
    modelling_anew_ = false;
  } else {
    model_anew(left);
  }
  mapped_ += static_cast<std::int64_t>(share - left) * planes;
}

/// What the arm no longer sees is forgotten as soon as a second map of all that it sees now is ready; only begun when
/// that is something else than it knows. Until then both take what is new, so that the arm never knows less than it
/// sees.
void SensedPlanner::model_anew(int& points) {
  if (!modelling_anew_) {
    if (!changed_) return;
    changed_ = false;
    std::vector<Eigen::Vector3d> seen;
    for (const auto& of_sensor : now_) seen.insert(seen.end(), of_sensor.begin(), of_sensor.end());
    if (known_.complete() && known_.map().holds_just(seen)) return;
    anew_->forget();
    for (const Eigen::Vector3d& p_B : seen) anew_->note(0.0, p_B);
    modelling_anew_ = true;
  }
  (void)anew_->advance(points);
  if (!anew_->complete()) return;
  std::swap(known_, *anew_);
  modelling_anew_ = false;
  blocked_more_ = forgot_ = true;
}

/// differs from paper: [Li96] takes its way round an obstacle from Lumelsky's rules for a point, which follow a
/// boundary from a hit point until a leave point nearer to the goal. Here a search among everything seen since the hit
/// point takes the boundary's place, and each leave point is a cell nearer at least: so there are finitely many of
/// both.
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

/// A cell's centre, or what the limits leave of the cell next to it. The last one is the goal itself.
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

/// What is seen during a search may block the way that it finds; what is forgotten may open one where it finds none.
/// True: there is a way.
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

/// The target changed on the way and the arm has left the line, so that what is in sight is not where it may go: a line
/// is looked at in places, and those of a stop on it are others. From rest to rest along the way, all of them are free.
bool SensedPlanner::stands(const JointVector& q, const JointVector& qd, const JointVector& target) {
  const bool rests = qd.cwiseAbs().maxCoeff() < kAtRest && (target - q).norm() > kArrived && known_.complete();
  standing_ = rests ? standing_ + 1 : 0;
  return standing_ > kPatience && !careful_;
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

/// Nothing is sure about a blocked cell's neighbours: they may be inside of what was seen. Where the arm was is sure.
MotionGuide::Aim SensedPlanner::go_back(const JointVector& q, const JointVector& qd) {
  drop_path();
  const double near = 0.5 * kTrailStep * map().pitch();
  while (!trail_.empty() && (q - trail_.back()).cwiseAbs().maxCoeff() < near) trail_.pop_back();
  if (trail_.empty()) return {Path::kNone, rest_position(limits_, q, qd)};
  return {Path::kAround, ahead(q, qd, trail_.back())};
}

/// Goes on to the farthest point of the way that is in a straight line of sight. From a point of it where the arm has
/// arrived, the next one always is. False: none is.
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

/// No farther on the line to the target than keeps the arm on it: every joint reaches its part of the speed within one
/// period. Without this a joint that has little to do would be done early, and the arm would leave the line.
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

std::optional<std::string> SensedPlanner::why_none(const JointVector& q) const {
  if (!none_) return std::nullopt;
  const auto too_near = [&](const char* what) {
    return std::string(what) + " is nearer to an obstacle that it knows than sensed.margin and a cell of its map allow";
  };
  if (map().blocked(map().cell_at(q))) return too_near("where the arm stands");
  if (map().blocked(map().cell_at(q_goal_))) return too_near("its goal");
  return "what it knows of the obstacles leaves no way to the goal";
}

}  // namespace hecaton::planner::cspace
