#pragma once
/// What nodes of ROS 2 may order: trajectories, goals, obstacles, hold, resume and stop.

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <hecaton/client.hpp>

#include "services/client/mode_orders.hpp"
#include "services/config/cell_file.hpp"
#include "services/ros2/goal_reports.hpp"
#include "services/ros2/planner_watch.hpp"
#include "services/ros2/scene_editor.hpp"
#include "services/ros2/trajectory_server.hpp"
#include "services/ros2/unreadable_log.hpp"
#include "services/runtime/cell_mode.hpp"

namespace hecaton::ros2 {

/// Why the arm stands until a person resumes it, a clause: a stop, or a fault of its device. Empty: it may move, or is
/// held for another reason.
[[nodiscard]] std::optional<std::string> latched_by(const services::CellModeView& modes, const std::string& arm);

/// After a resume of the whole cell: the arms that stay stopped, a sentence. Empty: none.
[[nodiscard]] std::string still_stopped(const std::vector<std::string>& stopped_arms);

/// Services std_srvs/srv/Trigger for orders to the supervisor, which take up to two seconds each. All calls are for one
/// thread.
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
    client::ModeOrder kind;
    std::vector<std::string> arms;  ///< empty: the cell
    UnreadableLog unreadable;
  };
  struct Request {
    std::size_t order;
    bus::ros2::RequestId id;
  };

  std::vector<Order> orders_;  ///< fixed after construction
  std::mutex mutex_;           ///< guards replies_
  std::vector<std::pair<Request, TriggerResponse>> replies_;
  client::ModeOrders modes_;  ///< last: its threads use all of it
};

/// All that drives the cell from ROS 2. For one thread.
class Control {
 public:
  /// `file` and `mailbox` must outlive it. `checkpoint`: begin of the names of files that survive a restart; empty:
  /// none.
  Control(bus::Participant& participant, const config::CellFile& file,
          const std::shared_ptr<client::Connection>& connection, bus::Mailbox& mailbox, const std::string& checkpoint);

  void update(const CellView& view, const services::CellModeView& modes, const PlannerWatch& planners,
              bus::Clock::time_point now);

  /// Paths of the trajectories under way.
  [[nodiscard]] std::vector<OrderedPath> paths() const;
  /// Of planning scenes, and of goals by topics.
  [[nodiscard]] std::vector<OrderReport> reports() const;
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
    GoalReports goals;  ///< from topics
  };
  void take_goals(ArmControl& control, bus::Clock::time_point now);
  template <class Send>
  void send(ArmControl& control, bus::Clock::time_point now, const Send& go);
  void refuse(ArmControl& control, const char* topic, const std::string& reason);

  std::vector<std::unique_ptr<ArmControl>> arms_;
  OrderServices orders_;
  SceneTopics scenes_;
};

}  // namespace hecaton::ros2
