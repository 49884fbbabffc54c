#include "services/ros2/cell_publisher.hpp"

#include <algorithm>
#include <string_view>

#include "services/ros2_messages/cell_description.hpp"

namespace hecaton::ros2 {
namespace {

bool all_simulated(const config::CellFile& file) {
  return std::all_of(file.devices.begin(), file.devices.end(),
                     [](const config::DeviceOptions& device) { return device.type == "simulated"; });
}

/// Public enumerations are generated from idl/ with the same values.
template <class Message, class Public>
Message same(Public value) {
  return static_cast<Message>(value);
}

}  // namespace

CellPublisher::ArmTopics::ArmTopics(const planner::Arm& of, bus::Participant& participant, const std::string& ns)
    : arm(&of),
      description(participant, ns + "/" + of.name + "/robot_description", type::kString, Delivery::kLatched),
      states(participant, ns + "/" + of.name + "/joint_states", type::kJointState),
      status(participant, ns + "/" + of.name + "/status", type::kDiagnosticStatus) {}

DiagnosticStatus diagnostic(const OrderReport& report, const std::string& cell) {
  const std::uint8_t grade = report.refusal ? level::kWarn : level::kOk;
  DiagnosticStatus entry = diagnostic(grade, report.name, report.refusal.value_or("applied"), cell);
  entry.values = {{"applied", std::to_string(report.applied)},
                  {"refused", std::to_string(report.refused)},
                  {"unreadable", std::to_string(report.unreadable)}};
  return entry;
}

CellPublisher::CellPublisher(const config::CellFile& file, bus::Participant& participant)
    : file_(file),
      simulated_(all_simulated(file)),
      description_(participant, file.ros2->ns + "/robot_description", type::kString, Delivery::kLatched),
      joint_states_(participant, file.ros2->ns + "/joint_states", type::kJointState),
      transforms_(participant, "/tf", type::kTransforms, Delivery::kTransforms),
      fixed_transforms_(participant, "/tf_static", type::kTransforms, Delivery::kLatched),
      clock_(participant, "/clock", type::kClock, Delivery::kClock),
      diagnostics_(participant, "/diagnostics", type::kDiagnostics),
      markers_(file.cell) {
  for (const std::string_view name : CellMarkers::kNames) {
    marker_topics_.emplace_back(participant, file.ros2->ns + "/hecaton/" + std::string(name), type::kMarkers);
  }
  for (const planner::PlannedArm& planned : file.cell.arms) {
    arms_.push_back(std::make_unique<ArmTopics>(planned.arm, participant, file.ros2->ns));
  }
}

void CellPublisher::publish_descriptions() {
  description_.publish({cell_urdf(file_.cell)});
  for (const auto& topics : arms_) topics->description.publish({arm_urdf(*topics->arm)});
  fixed_transforms_.publish(fixed_transforms(file_.cell, ros_time(std::chrono::system_clock::now())));
}

void CellPublisher::publish_states(const CellView& view, Clock::time_point now) {
  if (simulated_) clock_.publish({ros_time(now)});
  for (std::size_t i = 0; i < view.size(); ++i) {
    if (arms_[i]->states.wanted() && is_shown(view.arm(i), now)) arms_[i]->states.publish(joint_state(view.arm(i)));
  }
  if (joint_states_.wanted()) {
    const JointState all = joint_states(view, now);
    if (!all.name.empty()) joint_states_.publish(all);
  }
  if (transforms_.wanted()) {
    const TFMessage moving = moving_transforms(view, now);
    if (!moving.transforms.empty()) transforms_.publish(moving);
  }
}

void CellPublisher::publish_arm_status(const CellView& view, Clock::time_point now) {
  for (std::size_t i = 0; i < view.size(); ++i) {
    if (arms_[i]->status.wanted()) arms_[i]->status.publish(status_of(view.arm(i), now));
  }
}

void CellPublisher::publish_markers(CellView& view, const std::vector<OrderedPath>& ordered) {
  marker_readers_.resize(marker_topics_.size());
  for (std::size_t i = 0; i < marker_topics_.size(); ++i) {
    const int readers = marker_topics_[i].readers();
    if (readers > std::exchange(marker_readers_[i], readers)) markers_.welcome(i);
  }
  markers_.update(view, ordered, ros_time(std::chrono::system_clock::now()));
  for (std::size_t i = 0; i < marker_topics_.size(); ++i) {
    if (marker_topics_[i].wanted()) marker_topics_[i].publish(markers_.message(i));
  }
}

void CellPublisher::publish_diagnostics(const CellStatus* status, const std::string& problem,
                                        const std::vector<OrderReport>& orders) {
  DiagnosticArray message;
  message.header.stamp = ros_time(std::chrono::system_clock::now());
  if (status == nullptr) {
    message.status.push_back(diagnostic(level::kStale, "cell", problem, file_.cell.name));
  } else {
    const bool run = status->mode == CellMode::kRun;
    message.status.push_back(
        diagnostic(run ? level::kOk : level::kWarn, "cell", run ? "running" : status->cause.text, status->cell));
    for (const NodeStatus& node : status->nodes) {
      message.status.push_back(diagnostic(NodeDiagnosis{node.name, node.host, same<msg::NodeState>(node.state),
                                                        node.cause.text, node.alive, node.age.count()}));
    }
    std::set<std::string> listed;
    for (const Fault& fault : status->faults) {
      // One that came and went between two messages is an error in one of them.
      const bool over = fault.cleared && (!listed_faults_ || listed_faults_->contains(fault.id));
      message.status.push_back(
          diagnostic(FaultDiagnosis{fault.id, fault.cause.subject, std::string(name_of(fault.cause.kind)),
                                    fault.cause.text, same<msg::Severity>(fault.severity), over}));
      listed.insert(fault.id);
    }
    listed_faults_ = std::move(listed);
  }
  for (const OrderReport& report : orders) message.status.push_back(diagnostic(report, file_.cell.name));
  diagnostics_.publish(message);
}

std::vector<bus::EndpointId> CellPublisher::writers() const {
  std::vector<bus::EndpointId> ids{description_.id(),      joint_states_.id(), transforms_.id(),
                                   fixed_transforms_.id(), clock_.id(),        diagnostics_.id()};
  for (const auto& topic : marker_topics_) ids.push_back(topic.id());
  for (const auto& topics : arms_) {
    ids.insert(ids.end(), {topics->description.id(), topics->states.id(), topics->status.id()});
  }
  return ids;
}

}  // namespace hecaton::ros2
