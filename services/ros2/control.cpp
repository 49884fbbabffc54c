#include "services/ros2/control.hpp"

#include <algorithm>
#include <cmath>

#include "services/bus/wire_rules.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::ros2 {
namespace {

using client::ModeOrder;

/// Empty when the message is no pose in the frame `world`.
std::optional<hecaton::Pose> pose_of(const PoseStamped& message) {
  const Point& p = message.pose.position;
  const Quaternion& o = message.pose.orientation;
  const double norm = std::sqrt(o.x * o.x + o.y * o.y + o.z * o.z + o.w * o.w);
  if (!std::isfinite(p.x + p.y + p.z) || !(std::abs(norm - 1.0) < 1e-2)) return std::nullopt;
  return hecaton::Pose{{p.x, p.y, p.z}, {o.w / norm, o.x / norm, o.y / norm, o.z / norm}};
}

void append(NodeEndpoints& all, const NodeEndpoints& more) {
  all.readers.insert(all.readers.end(), more.readers.begin(), more.readers.end());
  all.writers.insert(all.writers.end(), more.writers.begin(), more.writers.end());
}

}  // namespace

OrderServices::OrderServices(bus::Participant& participant, const config::CellFile& file, const Cell& cell,
                             bus::Mailbox& mailbox)
    : modes_([cell](ModeOrder order, const std::vector<std::string>& arms, const std::stop_token& stop) {
        const Wait wait{kAnswerLimit, stop};
        switch (order) {
          case ModeOrder::kHold:
            return cell.hold(arms, wait);
          case ModeOrder::kResume:
            return cell.resume(arms, wait);
          case ModeOrder::kStop:
            break;
        }
        return cell.stop(arms, wait);
      }) {
  const auto serve = [&](const std::string& where, const std::vector<std::string>& arms) {
    for (const auto& [name, kind] : {std::pair("/hold", ModeOrder::kHold), std::pair("/resume", ModeOrder::kResume),
                                     std::pair("/stop", ModeOrder::kStop)}) {
      orders_.push_back({bus::ros2::Server(participant, service_of(where + name, type::kTrigger), mailbox), kind, arms,
                         UnreadableLog(where + name, type::kTrigger.name)});
    }
  };
  serve(file.ros2->ns + "/hecaton", {});
  for (const planner::PlannedArm& planned : file.cell.arms) {
    serve(file.ros2->ns + "/" + planned.arm.name, {planned.arm.name});
  }
}

void OrderServices::update() {
  for (std::size_t i = 0; i < orders_.size(); ++i) {
    for (const bus::ros2::Request& request : orders_[i].server.take()) {
      if (decoded<TriggerRequest>(request.bytes)) {
        const Request at{i, request.id};
        modes_.give(orders_[i].kind, orders_[i].arms, 0, [this, at](const client::ModeOutcome& outcome) {
          const std::scoped_lock lock(mutex_);
          replies_.emplace_back(at, TriggerResponse{outcome.done, outcome.text});
        });
      } else {
        orders_[i].unreadable.note(bus::Clock::now());
      }
    }
  }
  std::vector<std::pair<Request, TriggerResponse>> replies;
  {
    const std::scoped_lock lock(mutex_);
    replies.swap(replies_);
  }
  for (const auto& [request, response] : replies) orders_[request.order].server.reply(request.id, encoded(response));
}

NodeEndpoints OrderServices::endpoints() const {
  NodeEndpoints endpoints;
  for (const Order& order : orders_) {
    endpoints.readers.push_back(order.server.reader_id());
    endpoints.writers.push_back(order.server.writer_id());
  }
  return endpoints;
}

Control::ArmControl::ArmControl(bus::Participant& participant, const std::string& ns, const planner::Arm& of,
                                const std::shared_ptr<client::Connection>& connection, bus::Mailbox& mailbox,
                                const std::string& checkpoint)
    : arm(of),
      client(Cell(connection).arm(of.name)),
      trajectories(participant, ns, of, connection, mailbox, checkpoint),
      poses(participant, ns + "/" + of.name + "/goal_pose", type::kPoseStamped, mailbox),
      positions(participant, ns + "/" + of.name + "/goal_joints", type::kJointState, mailbox) {}

Control::Control(bus::Participant& participant, const config::CellFile& file,
                 const std::shared_ptr<client::Connection>& connection, bus::Mailbox& mailbox,
                 const std::string& checkpoint)
    : orders_(participant, file, Cell(connection), mailbox), scenes_(participant, file, connection, mailbox) {
  for (const planner::PlannedArm& planned : file.cell.arms) {
    const std::string of_arm = checkpoint.empty() ? "" : checkpoint + "-" + planned.arm.name;
    arms_.push_back(std::make_unique<ArmControl>(participant, file.ros2->ns, planned.arm, connection, mailbox, of_arm));
  }
}

void Control::update(const CellView& view, bus::Clock::time_point now) {
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    arms_[i]->trajectories.update(view.arm(i), now);
    take_goals(*arms_[i]);
  }
  orders_.update();
  scenes_.update(view, now);
}

template <class Send>
void Control::send(ArmControl& control, const Send& go) {
  control.refusal.reset();
  try {
    const Goal goal = go();
    ++goals_.applied;
    services::log_info("goal sent", {{"arm", control.arm.name}, {"goal", goal.id()}});
  } catch (const Error& error) {
    ++goals_.refused;
    control.refusal = error.what();
    services::log_warning("goal not sent", {{"arm", control.arm.name}, {"reason", error.what()}});
  }
}

void Control::refuse(ArmControl& control, const char* topic, const std::string& reason) {
  ++goals_.refused;
  control.refusal = std::string(topic) + ": " + reason;
  services::log_warning("goal ignored", {{"arm", control.arm.name}, {"topic", topic}, {"reason", reason}});
}

void Control::take_goals(ArmControl& control) {
  control.poses.take_each([&](const PoseStamped& message) {
    const std::string& frame = message.header.frame_id;
    const auto pose = pose_of(message);
    if (frame != kWorldFrame) {
      refuse(control, "goal_pose",
             "frame_id = '" + bus::printable(frame, bus::kLongestName) + "' must be " + kWorldFrame);
    } else if (!pose) {
      refuse(control, "goal_pose", "its numbers must be finite and its orientation a unit quaternion");
    } else {
      send(control, [&] { return control.client.go_to(*pose); });
    }
  });
  control.positions.take_each([&](const JointState& message) {
    const auto joints = joint_numbers(message.name, control.arm);
    const bool finite = std::all_of(message.position.begin(), message.position.end(),
                                    [](double value) { return std::isfinite(value); });
    if (!joints || message.position.size() != message.name.size() || !finite) {
      refuse(control, "goal_joints", "it must have each joint of the arm once, with a finite position");
      return;
    }
    std::vector<double> q(joints->size());
    for (std::size_t i = 0; i < q.size(); ++i) q[static_cast<std::size_t>((*joints)[i])] = message.position[i];
    send(control, [&] { return control.client.go_to(q); });
  });
}

std::vector<OrderedPath> Control::paths() const {
  std::vector<OrderedPath> paths;
  for (const auto& control : arms_) {
    if (auto path = control->trajectories.path()) paths.push_back(std::move(*path));
  }
  return paths;
}

std::vector<OrderReport> Control::reports() const {
  OrderReport goals = goals_;
  for (const auto& control : arms_) {
    if (!goals.refusal && control->refusal) goals.refusal = "arm " + control->arm.name + ": " + *control->refusal;
  }
  return {scenes_.report(), std::move(goals)};
}

NodeEndpoints Control::endpoints() const {
  NodeEndpoints endpoints = orders_.endpoints();
  append(endpoints, scenes_.endpoints());
  for (const auto& control : arms_) {
    append(endpoints, control->trajectories.endpoints());
    append(endpoints, {{control->poses.id(), control->positions.id()}, {}});
  }
  return endpoints;
}

}  // namespace hecaton::ros2
