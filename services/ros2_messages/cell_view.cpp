#include "services/ros2_messages/cell_view.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "planner/model/outside_joints.hpp"
#include "services/messages/convert.hpp"
#include "services/ros2_messages/time.hpp"
#include "services/runtime/state_age.hpp"

namespace hecaton::ros2 {
namespace {

/// `a` is a later status of the same arm than `b`: stamps of one term have one clock.
bool is_later(const msg::GoalStatus& a, const msg::GoalStatus& b) {
  return std::tuple(a.term(), a.stamp_ns(), a.sequence_number()) >
         std::tuple(b.term(), b.stamp_ns(), b.sequence_number());
}

/// Puts the links that joints outside the chain move where these joints are measured, with all that is fixed to them.
void place_outside(const planner::RobotModel& model, const std::vector<double>& positions,
                   planner::Kinematics& kinematics) {
  if (!model.outside || positions.size() != model.outside->joints.size()) return;
  const std::vector<world::Pose> places = planner::outside_places(model, positions);
  const auto held = kinematics.X_WL;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const auto& bodies = model.outside->bodies;
    const auto body =
        std::find_if(bodies.begin(), bodies.end(), [&](const auto& one) { return one.link == model.links[i].name; });
    const int parent = model.links[i].parent;
    if (body != bodies.end()) {
      kinematics.X_WL[i] = kinematics.X_WT * places[static_cast<std::size_t>(body - bodies.begin())];
    } else if (parent >= 0) {
      kinematics.X_WL[i] = kinematics.X_WL[parent] * (held[parent].inverse() * held[i]);
    }
  }
}

}  // namespace

/// When the state was true, on the clock of `received`. A driver whose device measures no longer repeats its last
/// state. A state without a stamp counts from its arrival.
CellView::Clock::time_point CellView::measured_at(const bus::Sample<msg::ArmState>& sample, Known& known) {
  const auto& last = known.state;
  const bool goes_on =
      last && last->writer == sample.writer && last->value.sequence_number() <= sample.value.sequence_number();
  if (!goes_on) known.clock = services::SenderClock();
  if (sample.value.stamp_ns() == 0) return sample.received;
  return services::measured_at(sample.value, sample.received, known.clock);
}

CellView::CellView(const planner::Cell& cell, CellEpoch epoch) : epoch_(epoch) {
  for (const planner::PlannedArm& planned : cell.arms) {
    index_.emplace(planned.arm.name, arms_.size());
    arms_.emplace_back().arm = &planned.arm;
  }
}

void CellView::apply(bus::Sample<msg::ArmState> sample) {
  const auto found = index_.find(sample.value.arm());
  if (sample.disposed || found == index_.end()) return;
  Known& known = arms_[found->second];
  const auto q = messages::joints_from_message(sample.value.q(), "ArmState", known.arm->model->joints());
  known.placed = static_cast<bool>(q);
  sample.received = measured_at(sample, known);
  if (q) {
    planner::forward_kinematics(*known.arm->model, known.arm->X_WB, *q, known.kinematics);
    place_outside(*known.arm->model, sample.value.outside(), known.kinematics);
  }
  known.state = std::move(sample);
}

void CellView::apply(bus::Sample<msg::GoalStatus> sample) {
  const auto found = index_.find(sample.value.arm());
  if (sample.disposed || found == index_.end()) return;
  auto& goal = arms_[found->second].goal;
  if (sample.value.state() == msg::GoalState::GOAL_REPLACED) return;
  if (!goal || is_later(sample.value, *goal)) goal = std::move(sample.value);
}

void CellView::apply(const bus::Sample<msg::ObstacleShapes>& sample) {
  if (sample.disposed) {
    known_shapes_.erase(sample.key);
  } else {
    set_shapes(sample.value.name(), sample.value.obstacle());
  }
}

void CellView::set_shapes(const std::string& name, const msg::Obstacle& obstacle) {
  if (const auto known = messages::from_message(obstacle)) known_shapes_[name] = known->shapes;
}

void CellView::apply(bus::Sample<msg::ObstacleStates> sample) {
  if (!sample.disposed) newest_ = std::move(sample.value);
}

void CellView::apply(bus::Sample<msg::PlannedMotion> sample) {
  const auto found = index_.find(sample.disposed ? sample.key : sample.value.arm());
  if (found == index_.end()) return;
  auto& motion = arms_[found->second].motion;
  motion.reset();
  if (!sample.disposed) motion = std::move(sample.value);
}

void CellView::forget_motions() {
  for (Known& known : arms_) known.motion.reset();
}

void CellView::place_obstacles() {
  obstacles_.clear();
  for (const msg::ObstacleState& state : newest_.states()) {
    const auto shapes = known_shapes_.find(state.name());
    const auto pose = messages::from_message(state.X_WO(), state.name());
    if (shapes != known_shapes_.end() && pose) obstacles_[state.name()] = {shapes->second, *pose};
  }
}

ArmSnapshot CellView::arm(std::size_t index) const {
  const Known& known = arms_[index];
  return {known.arm,
          known.state ? &*known.state : nullptr,
          known.goal ? &*known.goal : nullptr,
          known.motion ? &*known.motion : nullptr,
          known.placed ? &known.kinematics : nullptr,
          known.state ? time_at(known.state->received) : Time()};
}

Time CellView::time_at(Clock::time_point at) const {
  if (epoch_ == CellEpoch::kBoot) return ros_time(at);
  return ros_time(std::chrono::system_clock::time_point(
      std::chrono::duration_cast<std::chrono::system_clock::duration>(at.time_since_epoch())));
}

std::optional<Eigen::Vector3d> CellView::position_of(const std::string& body) const {
  if (const auto obstacle = obstacles_.find(body); obstacle != obstacles_.end()) {
    return obstacle->second.X_WO.translation();
  }
  const auto slash = body.find('/');
  const auto found = index_.find(std::string_view(body).substr(0, slash));
  if (slash == std::string::npos || found == index_.end() || !arms_[found->second].placed) return std::nullopt;
  const Known& known = arms_[found->second];
  const auto& links = known.arm->model->links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (body.compare(slash + 1, std::string::npos, links[i].name) == 0) return known.kinematics.X_WL[i].translation();
  }
  return std::nullopt;
}

}  // namespace hecaton::ros2
