#include "services/ros2/control.hpp"

#include <algorithm>
#include <cmath>

#include "services/bus/wire_rules.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/orders.hpp"

namespace hecaton::ros2 {
namespace {

using client::ModeOrder;

double norm(const Quaternion& o) {
  return std::sqrt(o.x * o.x + o.y * o.y + o.z * o.z + o.w * o.w);
}

/// Why the message is no goal; empty: it is one.
std::optional<std::string> why_no_goal(const PoseStamped& message) {
  const std::string& frame = message.header.frame_id;
  if (frame != kWorldFrame) {
    return "frame_id = '" + bus::printable(frame, bus::kLongestName) + "' must be " + kWorldFrame;
  }
  const Point& p = message.pose.position;
  for (const auto& [name, value] : {std::pair("x", p.x), std::pair("y", p.y), std::pair("z", p.z)}) {
    if (auto complaint = out_of_range(std::string("pose.position.") + name, value, kLargestPosition)) return complaint;
  }
  if (!(std::abs(norm(message.pose.orientation) - 1.0) < 1e-2)) return "pose.orientation must be a unit quaternion";
  return std::nullopt;
}

std::optional<std::string> why_no_goal(const JointState& message, bool joints_known) {
  if (!joints_known || message.position.size() != message.name.size()) {
    return "it must have each joint of the arm once, with its position";
  }
  for (std::size_t i = 0; i < message.position.size(); ++i) {
    const std::string field = "position[" + std::to_string(i) + "]";
    if (auto complaint = out_of_range(field, message.position[i], kLargestPosition)) return complaint;
  }
  return std::nullopt;
}

/// `message` is a goal.
hecaton::Pose pose_of(const PoseStamped& message) {
  const Point& p = message.pose.position;
  const Quaternion& o = message.pose.orientation;
  const double length = norm(o);
  return {{p.x, p.y, p.z}, {o.w / length, o.x / length, o.y / length, o.z / length}};
}

/// Resumes the cell. The warning also names arms that do not move yet.
Receipt resumed(const Cell& cell, const Wait& wait) {
  Receipt receipt = cell.resume(wait);
  try {
    const std::string stopped = still_stopped(cell.status(wait).stopped_arms);
    std::string& text = receipt.warning.text;
    text += (text.empty() || stopped.empty() ? "" : "; ") + stopped;
  } catch (const Error&) {  // the order is carried out all the same
  }
  return receipt;
}

void append(NodeEndpoints& all, const NodeEndpoints& more) {
  all.readers.insert(all.readers.end(), more.readers.begin(), more.readers.end());
  all.writers.insert(all.writers.end(), more.writers.begin(), more.writers.end());
}

}  // namespace

std::optional<std::string> latched_by(const services::CellModeView& modes, const std::string& arm) {
  if (!modes.heard()) return std::nullopt;
  if (modes.order(arm) == msg::Mode::MODE_STOP) return modes.why(arm).text();
  const msg::ArmOrder* own = services::order_in(modes.mode(), arm);
  if (own == nullptr || own->ordered() == msg::Mode::MODE_RUN || !services::is_for_device(own->cause(), arm)) {
    return std::nullopt;
  }
  return "the arm is on " + own->cause().text();
}

std::string still_stopped(const std::vector<std::string>& stopped_arms) {
  std::string text;
  for (const std::string& arm : stopped_arms) {
    text += (text.empty() ? "" : "; ") + arm + " stays stopped: it was stopped by name; resume it by name";
  }
  return text;
}

OrderServices::OrderServices(bus::Participant& participant, const config::CellFile& file, const Cell& cell,
                             bus::Mailbox& mailbox)
    : modes_([cell](ModeOrder order, const std::vector<std::string>& arms, const std::stop_token& stop) {
        const Wait wait{kAnswerLimit, stop};
        switch (order) {
          case ModeOrder::kHold:
            return cell.hold(arms, wait);
          case ModeOrder::kResume:
            return arms.empty() ? resumed(cell, wait) : cell.resume(arms, wait);
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

void Control::update(const CellView& view, const services::CellModeView& modes, const PlannerWatch& planners,
                     bus::Clock::time_point now) {
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    const std::string& name = arms_[i]->arm.name;
    arms_[i]->trajectories.update(view.arm(i), {planners.knows(name), latched_by(modes, name)}, now);
    take_goals(*arms_[i], now);
    arms_[i]->goals.update(now);
  }
  orders_.update();
  scenes_.update(view, now);
}

template <class Send>
void Control::send(ArmControl& control, bus::Clock::time_point now, const Send& go) {
  try {
    const Goal goal = go();
    control.goals.add([goal] { return goal.progress(); }, now);
    services::log_info("goal sent", {{"arm", control.arm.name}, {"goal", goal.id()}});
  } catch (const Error& error) {
    control.goals.refuse(error.what());
    services::log_warning("goal not sent", {{"arm", control.arm.name}, {"reason", error.what()}});
  }
}

void Control::refuse(ArmControl& control, const char* topic, const std::string& reason) {
  control.goals.refuse(std::string(topic) + ": " + reason);
  services::log_warning("goal ignored", {{"arm", control.arm.name}, {"topic", topic}, {"reason", reason}});
}

void Control::take_goals(ArmControl& control, bus::Clock::time_point now) {
  control.poses.take_each([&](const PoseStamped& message) {
    if (const auto complaint = why_no_goal(message)) return refuse(control, "goal_pose", *complaint);
    send(control, now, [&] { return control.client.go_to(pose_of(message)); });
  });
  control.positions.take_each([&](const JointState& message) {
    const auto joints = joint_numbers(message.name, control.arm);
    if (const auto complaint = why_no_goal(message, joints.has_value()))
      return refuse(control, "goal_joints", *complaint);
    std::vector<double> q(joints->size());
    for (std::size_t i = 0; i < q.size(); ++i) q[static_cast<std::size_t>((*joints)[i])] = message.position[i];
    send(control, now, [&] { return control.client.go_to(q); });
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
  OrderReport goals{.name = "goals"};
  for (const auto& control : arms_) {
    const GoalReports& of_arm = control->goals;
    goals.applied += of_arm.accepted();
    goals.refused += of_arm.refused();
    goals.unreadable += control->poses.unreadable() + control->positions.unreadable();
    if (!goals.refusal && of_arm.refusal()) goals.refusal = "arm " + control->arm.name + ": " + *of_arm.refusal();
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
