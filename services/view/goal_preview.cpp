#include "services/view/goal_preview.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <span>
#include <sstream>
#include <tuple>
#include <utility>

#include "planner/goal_check.hpp"
#include "planner/model/inverse_kinematics.hpp"
#include "planner/model/kinematics.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/thread_priority.hpp"

namespace hecaton::services {
namespace {

using planner::JointVector;

constexpr int kSeeds = 8;            // random postures, while a person drags
constexpr int kJointsOfAPose = 6;    // an arm with fewer reaches nearly no pose exactly
constexpr double kPosition = 1e-4;   // a pose is met within these [m]
constexpr double kAngle = 1e-3;      // [rad]
constexpr double kFloorHalf = 50.0;  // of the box that stands for the floor [m]
constexpr std::size_t kMostNear = 64;
constexpr std::chrono::milliseconds kLeastPause{20};

std::string length_text(double metres) {
  const double size = std::abs(metres);
  std::ostringstream out;
  out << std::fixed;
  if (size < 1.0) {
    out << std::setprecision(size < 0.01 ? 1 : 0) << size * 1e3 << " mm";
  } else {
    out << std::setprecision(2) << size << " m";
  }
  return out.str();
}

std::string away(const planner::ToolError& error) {
  std::ostringstream out;
  out << length_text(error.position) << " and " << std::setprecision(2) << error.orientation * 180.0 / std::numbers::pi
      << "° away";
  return out.str();
}

bool is_met(const planner::ToolError& error) {
  return error.position <= kPosition && error.orientation <= kAngle;
}

}  // namespace

std::string_view name_of(PreviewVerdict verdict) {
  switch (verdict) {
    case PreviewVerdict::kFree:
      return "free";
    case PreviewVerdict::kOccupied:
      return "occupied";
    case PreviewVerdict::kNear:
      return "near";
    case PreviewVerdict::kCollision:
      return "collision";
    case PreviewVerdict::kUnreachable:
      return "unreachable";
    case PreviewVerdict::kUnknown:
      break;
  }
  return "unknown";
}

PreviewScene PreviewScene::of(const CellState& state) {
  PreviewScene scene;
  for (const planner::PlannedArm& planned : state.file().cell.arms) {
    auto& q = scene.q.emplace_back();
    const auto* newest = state.state(planned.arm.name);
    if (newest == nullptr) continue;
    if (auto joints =
            messages::joints_from_message(newest->value.q(), planned.arm.name.c_str(), planned.arm.model->joints())) {
      q = *joints;
    }
  }
  scene.obstacles = state.shared_obstacles();
  scene.edition = state.obstacle_edition();
  if (const auto* states = state.obstacle_states()) {
    for (const msg::ObstacleState& one : states->value.states()) scene.X_WO.emplace(one.name(), one.X_WO());
  }
  return scene;
}

view::Json preview_json(const planner::Cell& cell, const PreviewAnswer& answer) {
  view::Json json{{"type", "preview"},
                  {"id", answer.id},
                  {"arm", cell.arms[static_cast<std::size_t>(answer.arm)].arm.name},
                  {"q", std::vector<double>(answer.q.begin(), answer.q.end())},
                  {"verdict", name_of(answer.verdict)},
                  {"accepted", answer.accepted},
                  {"text", answer.text},
                  {"pair", nullptr}};
  if (!answer.own.empty()) {
    json["pair"] = {{"own", answer.own}, {"other", answer.other}, {"distance", view::rounded(answer.distance)}};
  }
  return json;
}

// --- PreviewSolver

PreviewSolver::PreviewSolver(const planner::Cell& cell) : cell_(cell) {}

void PreviewSolver::update(const PreviewQuestion& question, const PreviewScene& scene) {
  if (!geometry_ || arm_ != question.arm || edition_ != scene.edition) {
    distances_.reset();
    geometry_.emplace(planner::arms_of(cell_), question.arm);
    std::vector<world::Obstacle> obstacles;
    for (const auto& [name, message] : *scene.obstacles) {
      if (auto obstacle = messages::from_message(message)) obstacles.push_back(*obstacle);
    }
    geometry_->set_obstacles(obstacles);
    distances_.emplace(*geometry_);
    obstacle_names_.clear();
    obstacles_.clear();
    for (const world::Obstacle& obstacle : obstacles) {
      obstacle_names_.push_back(obstacle.name);
      obstacles_.emplace_back().X_WO = obstacle.X_WO;
    }
    arm_ = question.arm;
    edition_ = scene.edition;
  }
  for (std::size_t i = 0; i < obstacle_names_.size(); ++i) {
    const auto present = scene.X_WO.find(obstacle_names_[i]);
    if (present == scene.X_WO.end()) continue;
    if (const auto X_WO = messages::from_message(present->second, obstacle_names_[i])) obstacles_[i].X_WO = *X_WO;
  }
  arms_.resize(cell_.arms.size());
  known_arms_.clear();
  for (std::size_t i = 0; i < cell_.arms.size(); ++i) {
    const planner::Arm& arm = cell_.arms[i].arm;
    const bool known = i < scene.q.size() && scene.q[i];
    if (known && static_cast<int>(i) != arm_) known_arms_.push_back(static_cast<int>(i));
    planner::forward_kinematics(*arm.model, arm.X_WB, known ? *scene.q[i] : JointVector::Zero(arm.model->joints()),
                                arms_[i]);
  }
}

/// The other body stays where it is: a goal there is rejected.
bool PreviewSolver::rests(const planner::Clearance& clearance) const {
  return clearance.counterpart != planner::Counterpart::kArm ||
         !geometry_->arm_bodies(clearance.other)[static_cast<std::size_t>(clearance.other_body)].moves;
}

/// Planners do not know the floor. An arm with its base below it is not checked.
std::optional<PreviewSolver::Blockage> PreviewSolver::below_floor(const planner::Kinematics& kinematics) const {
  const planner::Arm& arm = geometry_->own_arm();
  if (arm.X_WB.translation().z() < cell_.scene.floor_z - 1e-6) return std::nullopt;
  const world::Box box{Eigen::Vector3d::Constant(kFloorHalf)};
  world::Pose X_WF = world::Pose::Identity();
  X_WF.translation() << arm.X_WB.translation().x(), arm.X_WB.translation().y(), cell_.scene.floor_z - kFloorHalf;
  std::optional<Blockage> deepest;
  for (const planner::Body& body : geometry_->own_bodies()) {
    if (!body.moves || body.link < 0) continue;
    const world::Pose& X_WL = kinematics.X_WL[static_cast<std::size_t>(body.link)];
    const double distance = planner::shape_distance(body.shape, X_WL * body.X_CS, box, X_WF).distance;
    if (distance >= 0.0 || (deepest && distance >= deepest->distance)) continue;
    const std::string own = geometry_->body_name(arm_, body);
    deepest = Blockage{PreviewVerdict::kCollision, own + " is " + length_text(distance) + " below the floor", own,
                       "floor", distance};
  }
  return deepest;
}

PreviewSolver::Blockage PreviewSolver::blockage(const JointVector& q) {
  const planner::PlannedArm& planned = cell_.arms[static_cast<std::size_t>(arm_)];
  const double kept = planned.parameters.damper.security_distance;
  planner::Kinematics own;
  planner::forward_kinematics(*planned.arm.model, planned.arm.X_WB, q, own);
  std::array<planner::Clearance, kMostNear> near;
  planner::InfluenceDistances influence{.others = kept, .self = 0.0};
  influence.near_arms = known_arms_;
  const int count = distances_->clearances({&own, arms_, obstacles_}, influence, near);

  // The worst: what rests before what moves away, contact before nearness, then the nearest.
  const planner::Clearance* worst = nullptr;
  const auto rank = [&](const planner::Clearance& one) {
    return std::tuple(one.distance <= 0.0 && rests(one), one.distance <= 0.0, rests(one), -one.distance);
  };
  for (const planner::Clearance& one : std::span(near).first(static_cast<std::size_t>(count))) {
    if (one.counterpart == planner::Counterpart::kSelf && one.distance > 0.0) continue;
    if (worst == nullptr || rank(one) > rank(*worst)) worst = &one;
  }
  const bool hits = worst != nullptr && worst->distance <= 0.0 && rests(*worst);
  if (!hits) {
    if (auto below = below_floor(own)) return *below;
  }
  if (worst == nullptr) return {};
  Blockage found{
      PreviewVerdict::kCollision, {}, geometry_->own_name(*worst), geometry_->other_name(*worst), worst->distance};
  const bool touches = worst->distance <= 0.0;
  const std::string how = touches ? found.own + " and " + found.other + " overlap by " + length_text(worst->distance)
                                  : found.own + " would be " + length_text(worst->distance) + " from " + found.other;
  if (hits) {
    found.text = how;
  } else if (touches) {
    found.verdict = PreviewVerdict::kOccupied;
    found.text = how + " now: a goal there waits until that arm has left";
  } else {
    found.verdict = PreviewVerdict::kNear;
    found.text = how + ", but the arm keeps " + length_text(kept);
  }
  return found;
}

/// Verdict and sentence for the joint positions of the answer.
void PreviewSolver::conclude(PreviewAnswer& answer) {
  Blockage found = blockage(answer.q);
  if (found.verdict != PreviewVerdict::kCollision) {
    if (const auto rejection = planner::reject_goal(*geometry_, answer.q, obstacles_)) {
      found = {PreviewVerdict::kCollision, rejection->text, {}, rejection->subject, 0.0};
    }
  }
  answer.verdict = found.verdict;
  answer.accepted = found.verdict != PreviewVerdict::kCollision;
  answer.text = std::move(found.text);
  answer.own = std::move(found.own);
  answer.other = std::move(found.other);
  answer.distance = found.distance;
}

PreviewAnswer PreviewSolver::answer(const PreviewQuestion& question, const PreviewScene& scene) {
  PreviewAnswer answer;
  answer.page = question.page;
  answer.id = question.id;
  answer.arm = question.arm;
  try {
    update(question, scene);
  } catch (const std::exception& error) {
    geometry_.reset();
    answer.text = error.what();
    return answer;
  }
  const planner::Arm& arm = geometry_->own_arm();
  const auto& present = scene.q[static_cast<std::size_t>(arm_)];
  if (question.start.size() == 0 && !present) {
    answer.text = "the view has received no state of arm " + arm.name;
    return answer;
  }
  const JointVector start = question.start.size() > 0 ? question.start : *present;
  planner::NearestPose nearest = planner::nearest_pose(arm, question.X_WT, start);
  const bool fewer = arm.model->joints() < kJointsOfAPose;
  bool met = is_met(nearest.error) || fewer;
  const bool blocked = met && blockage(nearest.q).verdict == PreviewVerdict::kCollision;
  if ((!met || blocked) && !fewer) {
    planner::IkOptions options;
    options.seeds = kSeeds;
    options.accept = [this](const JointVector& q) { return blockage(q).verdict != PreviewVerdict::kCollision; };
    const planner::ArmReach reach = planner::arm_reach(arm);
    const bool too_far = (question.X_WT.translation() - reach.centre).norm() > reach.tool + kPosition;
    if (auto other = too_far ? std::nullopt : planner::inverse_kinematics(arm, question.X_WT, start, options)) {
      nearest.q = *other;
      nearest.error = {};
      met = true;
    }
  }
  answer.q = nearest.q;
  conclude(answer);
  if (!met) {
    answer.verdict = PreviewVerdict::kUnreachable;
    answer.accepted = false;
    answer.text = "out of reach: the nearest pose found is " + away(nearest.error);
    answer.own.clear();
    answer.other.clear();
  } else if (answer.text.empty() && !is_met(nearest.error)) {
    answer.text = "the nearest pose of this arm is " + away(nearest.error);
  }
  return answer;
}

// --- GoalPreview

GoalPreview::GoalPreview(const planner::Cell& cell) : solver_(cell) {
  thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

GoalPreview::~GoalPreview() {
  thread_.request_stop();
  thread_.join();
}

bool GoalPreview::ready(Clock::time_point now) const {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  return lock && !busy_ && now >= rests_until_;
}

void GoalPreview::ask(PreviewQuestion question, PreviewScene scene) {
  {
    const std::lock_guard lock(mutex_);
    task_ = Task{std::move(question), std::move(scene)};
    busy_ = true;
  }
  asked_.notify_one();
}

std::optional<PreviewAnswer> GoalPreview::take_answer() {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  return lock ? std::exchange(answer_, std::nullopt) : std::nullopt;
}

void GoalPreview::work(const std::stop_token& stop) {
  constexpr int kNiceness = 19;
  lower_priority(kNiceness);
  while (true) {
    std::optional<Task> task;
    {
      std::unique_lock lock(mutex_);
      if (!asked_.wait(lock, stop, [&] { return task_.has_value(); })) return;
      task = std::exchange(task_, std::nullopt);
    }
    const Clock::time_point began = Clock::now();
    PreviewAnswer answer = solver_.answer(task->question, task->scene);
    const Clock::time_point ended = Clock::now();
    const std::lock_guard lock(mutex_);
    answer_ = std::move(answer);
    busy_ = false;
    rests_until_ = ended + std::max<Clock::duration>(ended - began, kLeastPause);
  }
}

}  // namespace hecaton::services
