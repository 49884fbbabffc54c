#pragma once
/// What nodes of ROS 2 may order: trajectories, goals, obstacles, hold, resume and stop.

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <hecaton/client.hpp>

#include "services/config/cell_file.hpp"
#include "services/ros2/scene_editor.hpp"
#include "services/ros2/trajectory_server.hpp"

namespace hecaton::ros2 {

/// Services std_srvs/srv/Trigger for orders to the supervisor, which take up to two seconds each. A thread carries them
/// out one after the other; all other calls are for one thread.
class OrderServices {
 public:
  /// Serves NAMESPACE/hecaton/{hold,resume,stop} and NAMESPACE/ARM/{hold,resume,stop}. `mailbox` must outlive it.
  OrderServices(bus::Participant& participant, const config::CellFile& file, const Cell& cell, bus::Mailbox& mailbox);

  /// Takes requests, and replies to those that were carried out.
  void update();
  [[nodiscard]] NodeEndpoints endpoints() const;

 private:
  struct Order {
    bus::ros2::Server server;
    std::function<Receipt(const Wait&)> carry_out;
  };
  struct Request {
    std::size_t order;
    bus::ros2::RequestId id;
  };
  void run(const std::stop_token& stop);

  std::vector<Order> orders_;
  std::mutex mutex_;
  std::condition_variable_any arrived_;
  std::deque<Request> requests_;
  std::vector<std::pair<Request, TriggerResponse>> replies_;
  std::jthread thread_;
};

/// All that drives the cell from ROS 2. For one thread.
class Control {
 public:
  /// `file` and `mailbox` must outlive it. `checkpoint`: begin of the names of files that survive a restart; empty:
  /// none.
  Control(bus::Participant& participant, const config::CellFile& file,
          const std::shared_ptr<client::Connection>& connection, bus::Mailbox& mailbox, const std::string& checkpoint);

  void update(const CellView& view, bus::Clock::time_point now);

  /// Paths of the trajectories under way.
  [[nodiscard]] std::vector<OrderedPath> paths() const;
  [[nodiscard]] SceneReport scene_report() const { return scenes_.report(); }
  [[nodiscard]] NodeEndpoints endpoints() const;

 private:
  struct ArmControl {
    ArmControl(bus::Participant& participant, const std::string& ns, const planner::Arm& of,
               const std::shared_ptr<client::Connection>& connection, bus::Mailbox& mailbox,
               const std::string& checkpoint);
    const planner::Arm& arm;
    Arm client;
    TrajectoryServer trajectories;
    Subscription<PoseStamped> poses;
    Subscription<JointState> positions;
  };
  void take_goals(ArmControl& control);

  std::vector<std::unique_ptr<ArmControl>> arms_;
  OrderServices orders_;
  SceneTopics scenes_;
};

}  // namespace hecaton::ros2
