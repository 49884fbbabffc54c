#include "services/ros2/control.hpp"

#include <algorithm>
#include <cmath>

#include "services/bus/wire_rules.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::ros2 {
namespace {

constexpr std::size_t kMostOrders = 64;  // that wait

/// Sends a goal, and logs why it cannot be sent.
template <class Send>
void send(const planner::Arm& arm, const Send& go) {
  try {
    const Goal goal = go();
    services::log_info("goal sent", {{"arm", arm.name}, {"goal", goal.id()}});
  } catch (const Error& error) {
    services::log_warning("goal not sent", {{"arm", arm.name}, {"reason", error.what()}});
  }
}

void ignore(const planner::Arm& arm, const char* topic, const std::string& reason) {
  services::log_warning("goal ignored", {{"arm", arm.name}, {"topic", topic}, {"reason", reason}});
}

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
                             bus::Mailbox& mailbox) {
  const auto serve = [&](const std::string& where, const std::vector<std::string>& arms) {
    const auto add = [&](const char* name, std::function<Receipt(const Wait&)> carry_out) {
      orders_.push_back({bus::ros2::Server(participant, service_of(where + "/" + name, type::kTrigger), mailbox),
                         std::move(carry_out)});
    };
    add("hold", [cell, arms](const Wait& wait) { return cell.hold(arms, wait); });
    add("resume", [cell, arms](const Wait& wait) { return cell.resume(arms, wait); });
    add("stop", [cell, arms](const Wait& wait) { return cell.stop(arms, wait); });
  };
  serve(file.ros2->ns + "/hecaton", {});
  for (const planner::PlannedArm& planned : file.cell.arms) {
    serve(file.ros2->ns + "/" + planned.arm.name, {planned.arm.name});
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void OrderServices::update() {
  std::vector<std::pair<Request, TriggerResponse>> replies;
  {
    const std::scoped_lock lock(mutex_);
    replies.swap(replies_);
  }
  for (const auto& [request, response] : replies) orders_[request.order].server.reply(request.id, encoded(response));
  for (std::size_t i = 0; i < orders_.size(); ++i) {
    for (const bus::ros2::Request& request : orders_[i].server.take()) {
      if (!decoded<TriggerRequest>(request.bytes)) continue;
      const std::scoped_lock lock(mutex_);
      if (requests_.size() >= kMostOrders) continue;  // the client gives up
      requests_.push_back({i, request.id});
      arrived_.notify_one();
    }
  }
}

void OrderServices::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (arrived_.wait(lock, stop, [this] { return !requests_.empty(); })) {
    const Request request = requests_.front();
    requests_.pop_front();
    lock.unlock();
    TriggerResponse response;
    try {
      const Receipt receipt = orders_[request.order].carry_out({kAnswerLimit, stop});
      response = {true, receipt.warning.text};
    } catch (const Error& error) {
      response = {false, error.what()};
    }
    lock.lock();
    replies_.emplace_back(request, response);
  }
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

void Control::take_goals(ArmControl& control) {
  for (const PoseStamped& message : control.poses.take()) {
    const std::string& frame = message.header.frame_id;
    const auto pose = pose_of(message);
    if (frame != kWorldFrame) {
      ignore(control.arm, "goal_pose",
             "frame_id = '" + bus::printable(frame, bus::kLongestName) + "' must be " + kWorldFrame);
    } else if (!pose) {
      ignore(control.arm, "goal_pose", "its numbers must be finite and its orientation a unit quaternion");
    } else {
      send(control.arm, [&] { return control.client.go_to(*pose); });
    }
  }
  for (const JointState& message : control.positions.take()) {
    const auto joints = joint_numbers(message.name, control.arm);
    const bool finite = std::all_of(message.position.begin(), message.position.end(),
                                    [](double value) { return std::isfinite(value); });
    if (!joints || message.position.size() != message.name.size() || !finite) {
      ignore(control.arm, "goal_joints", "it must have each joint of the arm once, with a finite position");
      continue;
    }
    std::vector<double> q(joints->size());
    for (std::size_t i = 0; i < q.size(); ++i) q[static_cast<std::size_t>((*joints)[i])] = message.position[i];
    send(control.arm, [&] { return control.client.go_to(q); });
  }
}

std::vector<OrderedPath> Control::paths() const {
  std::vector<OrderedPath> paths;
  for (const auto& control : arms_) {
    if (auto path = control->trajectories.path()) paths.push_back(std::move(*path));
  }
  return paths;
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
