#include "services/view/ros2_scene.hpp"

#include <algorithm>
#include <chrono>

#include "services/runtime/cause.hpp"

namespace hecaton::services {
namespace {

constexpr std::size_t kMostFaults = 256;  // that are shown, the newest

}  // namespace

Ros2Scene::Ros2Scene(const config::CellFile& file, ros2::CellEpoch epoch)
    : file_(file),
      view_(file.cell, epoch),
      markers_(file.cell, ros2::MarkerLayer::Content::kWhole),
      taken_(file.cell.arms.size()) {}

void Ros2Scene::update_states(const CellState& cell) {
  for (std::size_t i = 0; i < taken_.size(); ++i) {
    const std::string& arm = file_.cell.arms[i].arm.name;
    if (const auto* state = cell.state(arm); state != nullptr && state->received != taken_[i]) {
      taken_[i] = state->received;
      view_.apply(*state);
    }
  }
  for (const auto& [arm, goal] : cell.goals()) view_.apply(goal);
}

void Ros2Scene::update_markers(const CellState& cell, const ros2::Time& stamp) {
  if (cell.obstacle_edition() != obstacle_edition_) {
    obstacle_edition_ = cell.obstacle_edition();
    view_.forget_shapes();
    for (const auto& [name, obstacle] : cell.obstacles()) view_.set_shapes(name, obstacle);
  }
  if (const auto* states = cell.obstacle_states()) view_.apply(*states);
  view_.forget_motions();
  for (const planner::PlannedArm& planned : file_.cell.arms) {
    if (const auto* motion = cell.motion(planned.arm.name)) view_.apply(*motion);
  }
  markers_.update(view_, {}, stamp);
}

ros2::DiagnosticArray Ros2Scene::diagnostics(const CellState& cell, bus::Clock::time_point now,
                                             const ros2::Time& stamp) const {
  ros2::DiagnosticArray message;
  message.header.stamp = stamp;
  if (!cell.mode().heard()) {
    message.status.push_back(
        ros2::diagnostic(ros2::level::kStale, "cell", "no supervisor has been heard", file_.cell.name));
  } else {
    const msg::CellMode& mode = cell.mode().mode();
    const bool run = mode.mode() == msg::Mode::MODE_RUN;
    message.status.push_back(ros2::diagnostic(run ? ros2::level::kOk : ros2::level::kWarn, "cell",
                                              run ? "running" : mode.cause().text(), file_.cell.name));
  }
  for (const auto& [name, sample] : cell.heartbeats()) {
    const msg::Heartbeat& heartbeat = sample.value;
    message.status.push_back(ros2::diagnostic(
        ros2::NodeDiagnosis{name, heartbeat.host(), heartbeat.state(), heartbeat.cause().text(),
                            cell.alive(sample, now), std::chrono::duration<double>(sample.age(now)).count()}));
  }
  std::vector<const msg::Fault*> faults;
  for (const auto& [id, fault] : cell.faults().all()) faults.push_back(&fault);
  std::sort(faults.begin(), faults.end(),
            [](const auto* a, const auto* b) { return a->since_unix_ms() > b->since_unix_ms(); });
  faults.resize(std::min(faults.size(), kMostFaults));
  for (const msg::Fault* fault : faults) {
    message.status.push_back(ros2::diagnostic(
        ros2::FaultDiagnosis{fault->id(), fault->cause().subject(), std::string(cause_name(fault->cause().kind())),
                             fault->cause().text(), fault->severity(), fault->cleared()}));
  }
  return message;
}

std::vector<Ros2Topic> Ros2Topics::all(const config::CellFile& file) {
  const std::string ns = file.ros2 ? file.ros2->ns : std::string();
  std::vector<Ros2Topic> topics;
  const auto add = [&](std::string name, const ros2::TypeInfo& type, bool latched = false) {
    topics.push_back({std::move(name), std::string(type.name), latched});
  };
  add(ns + "/robot_description", ros2::type::kString, true);
  add(ns + "/joint_states", ros2::type::kJointState);
  add("/tf", ros2::type::kTransforms);
  add("/tf_static", ros2::type::kTransforms, true);
  add("/diagnostics", ros2::type::kDiagnostics);
  for (const std::string_view name : ros2::CellMarkers::kNames) {
    add(ns + "/hecaton/" + std::string(name), ros2::type::kMarkers);
  }
  for (const planner::PlannedArm& planned : file.cell.arms) {
    const std::string prefix = ns + "/" + planned.arm.name;
    add(prefix + "/robot_description", ros2::type::kString, true);
    add(prefix + "/joint_states", ros2::type::kJointState);
    add(prefix + "/status", ros2::type::kDiagnosticStatus);
  }
  return topics;
}

}  // namespace hecaton::services
