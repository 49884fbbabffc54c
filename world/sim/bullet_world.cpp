#include "world/sim/bullet_world.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <unordered_map>

#include "world/model/obstacle_motion.hpp"
#include "world/model/scene_checks.hpp"
#include "world/sim/obstacle_dynamics.hpp"

namespace hecaton::world {
namespace {

EditResult unknown(const char* what, const std::string& name) {
  return {EditRefusal::kUnknownName, name, std::string("there is no ") + what + " named '" + name + "'"};
}

std::string already(const std::string& name) {
  return "there is already an obstacle named '" + name + "'";
}

EditResult not_now(const std::string& subject, std::string reason) {
  return {EditRefusal::kNotNow, subject, std::move(reason)};
}

/// Returns the arms. Throws std::invalid_argument when they cannot be simulated.
std::vector<ArmBodies> checked(std::vector<ArmBodies> arms) {
  for (auto arm = arms.begin(); arm != arms.end(); ++arm) {
    if (std::any_of(arms.begin(), arm, [&](const ArmBodies& other) { return other.name == arm->name; })) {
      throw std::invalid_argument("there are two arms named '" + arm->name + "'");
    }
    for (const auto& part : arm->parts) {
      std::optional<std::string> reason = why_invalid(part.shape.shape);
      if (!reason && !is_rigid(part.shape.X_BS)) reason = "the pose of a shape must be finite and rigid";
      if (reason) throw std::invalid_argument(arm->name + "/" + part.link_name + ": " + *reason);
    }
  }
  return arms;
}

}  // namespace

struct BulletWorld::Impl {
  Impl(const Scene& initial, std::vector<ArmBodies> arms_given);

  Scene scene;  ///< its obstacles are the current ones
  std::vector<ArmBodies> arms;
  std::vector<ArmTrack> tracks;        ///< of the arms
  std::vector<ObstacleState> states;   ///< of the obstacles
  std::vector<std::uint64_t> changes;  ///< of each of these poses
  std::uint64_t last_change = 0;
  std::vector<const ArmTrack*> carriers;         ///< of the obstacles
  std::vector<int> guided;                       ///< obstacles that follow a script or an arm
  std::vector<int> free;                         ///< obstacles that physics moves
  std::unordered_map<std::string, int> indices;  ///< of the obstacles
  ObstacleDynamics dynamics;
  ContactMonitor contact_monitor;
  double time = 0.0;
  std::uint64_t edition = 0;
  std::uint64_t sequence = 0;

  [[nodiscard]] int arm_index(const std::string& name) const {
    const auto found = std::find_if(arms.begin(), arms.end(), [&](const ArmBodies& arm) { return arm.name == name; });
    return found == arms.end() ? -1 : static_cast<int>(found - arms.begin());
  }
  [[nodiscard]] int obstacle_index(const std::string& name) const {
    const auto found = indices.find(name);
    return found == indices.end() ? -1 : found->second;
  }

  [[nodiscard]] std::optional<std::string> why_impossible(const Obstacle& obstacle) const;
  void append(const Obstacle& obstacle);
  void remove(int obstacle);
  void change_obstacles();
  void change_carrier(int obstacle);
  void sort_by_motion();
  void set_state(int obstacle, const MotionState& state);
  [[nodiscard]] MotionState prescribed(int obstacle) const;
  [[nodiscard]] ObstacleSnapshot snapshot() const;
  void step(double dt);
};

BulletWorld::Impl::Impl(const Scene& initial, std::vector<ArmBodies> arms_given)
    : arms(checked(std::move(arms_given))), tracks(arms.size()), contact_monitor(arms) {
  if (!std::isfinite(initial.floor_z) || !initial.gravity.allFinite()) {
    throw std::invalid_argument("the floor's height and gravity must be finite");
  }
  scene.floor_z = initial.floor_z;
  scene.gravity = initial.gravity;
  for (const Obstacle& obstacle : initial.obstacles) {
    if (const auto reason = why_impossible(obstacle)) throw std::invalid_argument(*reason);
    if (obstacle_index(obstacle.name) >= 0) throw std::invalid_argument(already(obstacle.name));
    append(obstacle);
  }
  sort_by_motion();
  contact_monitor.set_obstacles(scene.obstacles);
}

/// Without regard to the names of obstacles.
std::optional<std::string> BulletWorld::Impl::why_impossible(const Obstacle& obstacle) const {
  if (auto reason = why_invalid(obstacle)) return reason;
  if (obstacle.attachment && arm_index(obstacle.attachment->arm) < 0) {
    return "obstacle '" + obstacle.name + "' is attached to '" + obstacle.attachment->arm +
           "', which is no arm of this cell";
  }
  return std::nullopt;
}

void BulletWorld::Impl::append(const Obstacle& obstacle) {
  scene.obstacles.push_back(obstacle);
  carriers.push_back(obstacle.attachment ? &tracks[arm_index(obstacle.attachment->arm)] : nullptr);
  const int index = static_cast<int>(states.size());
  indices.emplace(obstacle.name, index);
  states.emplace_back();
  changes.push_back(0);
  set_state(index, prescribed(index));
  dynamics.append();
}

void BulletWorld::Impl::remove(int obstacle) {
  scene.obstacles.erase(scene.obstacles.begin() + obstacle);
  states.erase(states.begin() + obstacle);
  changes.erase(changes.begin() + obstacle);
  carriers.erase(carriers.begin() + obstacle);
  dynamics.erase(obstacle);
  indices.clear();
  for (int i = 0; i < static_cast<int>(states.size()); ++i) indices.emplace(scene.obstacles[i].name, i);
}

/// Must follow each change of an obstacle's motion or carrier, and of indices.
void BulletWorld::Impl::sort_by_motion() {
  guided.clear();
  free.clear();
  for (int i = 0; i < static_cast<int>(states.size()); ++i) {
    if (carriers[i] || is_scripted(scene.obstacles[i].motion)) guided.push_back(i);
    if (is_free(scene.obstacles[i])) free.push_back(i);
  }
}

/// Must follow each append() and remove().
void BulletWorld::Impl::change_obstacles() {
  sort_by_motion();
  contact_monitor.set_obstacles(scene.obstacles);
  ++edition;
}

void BulletWorld::Impl::set_state(int obstacle, const MotionState& state) {
  ObstacleState& now = states[obstacle];
  const bool moved = changes[obstacle] == 0 || now.X_WO.matrix() != state.X_WO.matrix();
  if (moved) changes[obstacle] = ++last_change;
  now = {state.X_WO, state.velocity, 0.0};
}

/// Must follow each attaching and detaching.
void BulletWorld::Impl::change_carrier(int obstacle) {
  const Obstacle& changed = scene.obstacles[obstacle];
  carriers[obstacle] = changed.attachment ? &tracks[arm_index(changed.attachment->arm)] : nullptr;
  dynamics.renew(obstacle);
  sort_by_motion();
  contact_monitor.set_obstacles(scene.obstacles, changed.name);
  ++edition;
}

/// State of an obstacle that is not free; of a free one, its initial state.
MotionState BulletWorld::Impl::prescribed(int obstacle) const {
  const Obstacle& one = scene.obstacles[obstacle];
  if (!one.attachment) return motion_at(one, time);
  const ArmTrack& arm = *carriers[obstacle];
  if (!arm.known()) return {one.X_WO, {}};
  return carried({arm.X_WT(), arm.tool_velocity()}, one.attachment->X_TO);
}

ObstacleSnapshot BulletWorld::Impl::snapshot() const {
  ObstacleSnapshot result{edition, sequence, time, states};
  // A carried obstacle moves with every measurement, also between steps.
  for (const int i : guided) {
    if (!carriers[i]) continue;
    const MotionState state = prescribed(i);
    result.states[i] = {state.X_WO, state.velocity, 0.0};
  }
  return result;
}

void BulletWorld::Impl::step(double dt) {
  for (const int i : dynamics.advance({scene, arms, tracks, carriers, guided, free, time}, states, dt)) {
    changes[i] = ++last_change;
  }
  time += dt;
  ++sequence;
  for (ArmTrack& track : tracks) track.end_step(dt);
  for (const int i : guided) set_state(i, prescribed(i));

  std::vector<MeasuredArm> measured;
  measured.reserve(tracks.size());
  for (const ArmTrack& track : tracks) measured.push_back({track.known(), track.X_WL()});
  contact_monitor.update(measured, {states, changes}, time);
}

BulletWorld::BulletWorld(const Scene& scene, std::vector<ArmBodies> arms)
    : impl_(std::make_unique<Impl>(scene, std::move(arms))) {}
BulletWorld::~BulletWorld() = default;
BulletWorld::BulletWorld(BulletWorld&&) noexcept = default;
BulletWorld& BulletWorld::operator=(BulletWorld&&) noexcept = default;

bool BulletWorld::set_arm(int arm, std::span<const Pose> X_WL, const Pose& X_WT) {
  if (arm < 0 || arm >= static_cast<int>(impl_->arms.size())) return false;
  for (const auto& part : impl_->arms[arm].parts) {
    if (part.link >= static_cast<int>(X_WL.size())) return false;
  }
  const auto finite = [](const Pose& pose) { return pose.matrix().allFinite(); };
  if (!finite(X_WT) || !std::all_of(X_WL.begin(), X_WL.end(), finite)) return false;
  impl_->tracks[arm].measure(X_WL, X_WT);
  return true;
}

void BulletWorld::step(double dt) {
  if (!(std::isfinite(dt) && dt >= 0.0)) throw std::invalid_argument("a step of the world must be finite and ≥ 0 s");
  impl_->step(dt);
}

double BulletWorld::time() const {
  return impl_->time;
}

void BulletWorld::set_time(double seconds) {
  if (!std::isfinite(seconds)) throw std::invalid_argument("the world's time must be finite");
  impl_->time = seconds;
  for (const int i : impl_->guided) impl_->set_state(i, impl_->prescribed(i));
}

std::vector<Obstacle> BulletWorld::obstacles_now() const {
  std::vector<Obstacle> now = impl_->scene.obstacles;
  const ObstacleSnapshot at = snapshot();
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (!now[i].attachment && !is_free(now[i])) continue;
    now[i].X_WO = at.states[i].X_WO;
    if (auto* dynamic = std::get_if<DynamicMotion>(&now[i].motion)) dynamic->initial_velocity = at.states[i].velocity;
  }
  return now;
}

void BulletWorld::restore(double seconds, std::uint64_t edition, const ContactCheckpoint& contacts) {
  set_time(seconds);
  impl_->edition = edition;
  impl_->contact_monitor.restore(contacts);
}

const std::vector<Obstacle>& BulletWorld::obstacles() const {
  return impl_->scene.obstacles;
}
const Obstacle* BulletWorld::find(const std::string& name) const {
  const int index = impl_->obstacle_index(name);
  return index < 0 ? nullptr : &impl_->scene.obstacles[index];
}
ObstacleSnapshot BulletWorld::snapshot() const {
  return impl_->snapshot();
}
PresentStates BulletWorld::present() const {
  return {impl_->states, impl_->changes};
}
std::uint64_t BulletWorld::edition() const {
  return impl_->edition;
}

EditResult BulletWorld::add(const Obstacle& obstacle) {
  if (impl_->obstacle_index(obstacle.name) >= 0) {
    return {EditRefusal::kNameTaken, obstacle.name, already(obstacle.name)};
  }
  if (auto reason = impl_->why_impossible(obstacle)) {
    return {EditRefusal::kInvalidValue, obstacle.name, std::move(*reason)};
  }
  impl_->append(obstacle);
  impl_->change_obstacles();
  return {};
}

EditResult BulletWorld::replace(const Obstacle& obstacle) {
  const int index = impl_->obstacle_index(obstacle.name);
  if (index < 0) return unknown("obstacle", obstacle.name);
  if (auto reason = impl_->why_impossible(obstacle)) {
    return {EditRefusal::kInvalidValue, obstacle.name, std::move(*reason)};
  }
  const Obstacle next = obstacle;  // may be an element of obstacles()
  impl_->remove(index);
  impl_->append(next);
  impl_->change_obstacles();
  return {};
}

EditResult BulletWorld::move(const std::string& name, const Pose& X_WO) {
  const int index = impl_->obstacle_index(name);
  if (index < 0) return unknown("obstacle", name);
  Obstacle& obstacle = impl_->scene.obstacles[index];
  if (obstacle.attachment) {
    return not_now(name, "obstacle '" + name + "' is attached to '" + obstacle.attachment->arm + "': detach it first");
  }
  if (!is_rigid(X_WO)) {
    return {EditRefusal::kInvalidValue, name,
            "obstacle '" + name + "' cannot be moved: the pose must be finite and rigid"};
  }
  obstacle.X_WO = X_WO;
  if (auto* dynamic = std::get_if<DynamicMotion>(&obstacle.motion)) {
    dynamic->initial_velocity = {};
  } else {
    obstacle.motion = StaticMotion{};
  }
  impl_->set_state(index, {X_WO, {}});
  impl_->dynamics.renew(index);
  impl_->sort_by_motion();
  return {};
}

EditResult BulletWorld::remove(const std::string& name) {
  const int index = impl_->obstacle_index(name);
  if (index < 0) return unknown("obstacle", name);
  impl_->remove(index);
  impl_->change_obstacles();
  return {};
}

EditResult BulletWorld::attach(const std::string& name, const std::string& arm) {
  const int index = impl_->obstacle_index(name);
  if (index < 0) return unknown("obstacle", name);
  const int carrier = impl_->arm_index(arm);
  if (carrier < 0) return unknown("arm", arm);
  Obstacle& obstacle = impl_->scene.obstacles[index];
  if (obstacle.attachment) {
    return not_now(name, "obstacle '" + name + "' is already attached to '" + obstacle.attachment->arm + "'");
  }
  const auto is_points = [](const PlacedShape& placed) { return std::holds_alternative<Points>(placed.shape); };
  if (std::any_of(obstacle.shapes.begin(), obstacle.shapes.end(), is_points)) {
    return not_now(name, "obstacle '" + name + "' is made of points, which an arm cannot carry");
  }
  const ArmTrack& track = impl_->tracks[carrier];
  if (!track.known()) return not_now(arm, "arm '" + arm + "' has not reported its position yet");

  obstacle.X_WO = impl_->states[index].X_WO;
  obstacle.attachment = Attachment{arm, track.X_WT().inverse() * obstacle.X_WO};
  if (is_scripted(obstacle.motion)) obstacle.motion = StaticMotion{};
  impl_->change_carrier(index);
  impl_->set_state(index, impl_->prescribed(index));
  return {};
}

EditResult BulletWorld::detach(const std::string& name) {
  const int index = impl_->obstacle_index(name);
  if (index < 0) return unknown("obstacle", name);
  Obstacle& obstacle = impl_->scene.obstacles[index];
  if (!obstacle.attachment) return not_now(name, "obstacle '" + name + "' is not attached to any arm");
  if (!impl_->carriers[index]->known()) {
    return not_now(name, "arm '" + obstacle.attachment->arm + "', which carries '" + name +
                             "', has not reported its position yet");
  }
  MotionState state = impl_->prescribed(index);
  obstacle.attachment.reset();
  obstacle.X_WO = state.X_WO;
  if (is_scripted(obstacle.motion)) obstacle.motion = StaticMotion{};
  if (!is_free(obstacle)) state.velocity = {};
  impl_->change_carrier(index);
  impl_->set_state(index, state);
  return {};
}

const ContactMonitor& BulletWorld::contact_monitor() const {
  return impl_->contact_monitor;
}
ContactMonitor& BulletWorld::contact_monitor() {
  return impl_->contact_monitor;
}

}  // namespace hecaton::world
