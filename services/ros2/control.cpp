#include "services/ros2/control.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "services/bus/wire_rules.hpp"
#include "services/ros2_messages/cell_description.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::ros2 {
namespace {

constexpr std::size_t kMostOrders = 16;  // of one service that wait

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
                             bus::Mailbox& mailbox)
    : cell_(cell) {
  const auto serve = [&](const std::string& where, const std::vector<std::string>& arms) {
    for (const auto& [name, kind] :
         {std::pair("/hold", Kind::kHold), std::pair("/resume", Kind::kResume), std::pair("/stop", Kind::kStop)}) {
      orders_.push_back({bus::ros2::Server(participant, service_of(where + name, type::kTrigger), mailbox), kind, arms,
                         where + name, UnreadableLog(where + name, type::kTrigger.name)});
    }
  };
  serve(file.ros2->ns + "/hecaton", {});
  for (const planner::PlannedArm& planned : file.cell.arms) {
    serve(file.ros2->ns + "/" + planned.arm.name, {planned.arm.name});
  }
  threads_[0] = std::jthread([this](const std::stop_token& stop) { run(stop, stops_); });
  threads_[1] = std::jthread([this](const std::stop_token& stop) { run(stop, others_); });
}

void OrderServices::update() {
  for (std::size_t i = 0; i < orders_.size(); ++i) {
    for (const bus::ros2::Request& request : orders_[i].server.take()) {
      if (decoded<TriggerRequest>(request.bytes)) {
        enqueue({i, request.id});
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

void OrderServices::enqueue(const Request& request) {
  const Order& order = orders_[request.order];
  Queue& queue = order.kind == Kind::kStop ? stops_ : others_;
  const std::scoped_lock lock(mutex_);
  if (order.kind != Kind::kResume) withdraw_resumes(order);
  const auto same = std::count_if(queue.waiting.begin(), queue.waiting.end(),
                                  [&](const Request& other) { return other.order == request.order; });
  if (static_cast<std::size_t>(same) >= kMostOrders) {
    replies_.emplace_back(request, TriggerResponse{false, std::to_string(kMostOrders) + " requests of " + order.name +
                                                              " wait already; send it again later"});
    return;
  }
  auto place = queue.waiting.end();
  if (order.kind == Kind::kHold) {
    place = std::find_if(queue.waiting.begin(), queue.waiting.end(),
                         [&](const Request& other) { return orders_[other.order].kind == Kind::kResume; });
  }
  queue.waiting.insert(place, request);
  queue.arrived.notify_one();
}

void OrderServices::withdraw_resumes(const Order& by) {
  std::erase_if(others_.waiting, [&](const Request& request) {
    const Order& order = orders_[request.order];
    const bool apart = !by.arms.empty() && !order.arms.empty() && by.arms != order.arms;
    if (order.kind != Kind::kResume || apart) return false;
    replies_.emplace_back(request, TriggerResponse{false, "not carried out: a later request of " + by.name +
                                                              " came first; send it again to resume"});
    return true;
  });
}

void OrderServices::run(const std::stop_token& stop, Queue& queue) {
  std::unique_lock lock(mutex_);
  while (queue.arrived.wait(lock, stop, [&] { return !queue.waiting.empty(); })) {
    const std::vector<Request> requests = next_of(queue);
    lock.unlock();
    const TriggerResponse response = carry_out(requests, stop);
    lock.lock();
    for (const Request& request : requests) replies_.emplace_back(request, response);
  }
}

std::vector<OrderServices::Request> OrderServices::next_of(Queue& queue) const {
  const auto end = &queue == &stops_ ? queue.waiting.end() : queue.waiting.begin() + 1;
  std::vector<Request> requests(queue.waiting.begin(), end);
  queue.waiting.erase(queue.waiting.begin(), end);
  return requests;
}

TriggerResponse OrderServices::carry_out(const std::vector<Request>& requests, const std::stop_token& stop) const {
  std::set<std::string> arms;
  bool whole_cell = false;
  for (const Request& request : requests) {
    const Order& order = orders_[request.order];
    whole_cell = whole_cell || order.arms.empty();
    arms.insert(order.arms.begin(), order.arms.end());
  }
  if (whole_cell) arms.clear();
  const std::vector<std::string> of(arms.begin(), arms.end());
  const Wait wait{kAnswerLimit, stop};
  try {
    switch (orders_[requests.front().order].kind) {
      case Kind::kHold:
        return {true, cell_.hold(of, wait).warning.text};
      case Kind::kResume:
        return {true, cell_.resume(of, wait).warning.text};
      case Kind::kStop:
        break;
    }
    return {true, cell_.stop(of, wait).warning.text};
  } catch (const Error& error) {
    return {false, error.what()};
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
  control.poses.take_each([&](const PoseStamped& message) {
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
  });
  control.positions.take_each([&](const JointState& message) {
    const auto joints = joint_numbers(message.name, control.arm);
    const bool finite = std::all_of(message.position.begin(), message.position.end(),
                                    [](double value) { return std::isfinite(value); });
    if (!joints || message.position.size() != message.name.size() || !finite) {
      ignore(control.arm, "goal_joints", "it must have each joint of the arm once, with a finite position");
      return;
    }
    std::vector<double> q(joints->size());
    for (std::size_t i = 0; i < q.size(); ++i) q[static_cast<std::size_t>((*joints)[i])] = message.position[i];
    send(control.arm, [&] { return control.client.go_to(q); });
  });
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
