#pragma once
/// The node hecaton-ros2: shows a cell to the nodes of a ROS 2 domain.

#include <memory>
#include <optional>

#include "services/config/cell_file.hpp"
#include "services/ros2/cell_publisher.hpp"
#include "services/ros2/cell_reader.hpp"
#include "services/ros2/control.hpp"
#include "services/ros2/name_watch.hpp"
#include "services/ros2/node_graph.hpp"
#include "services/ros2/planner_watch.hpp"
#include "services/ros2/status_poller.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"

namespace hecaton::ros2 {

/// Reads the topics of the cell in its own domain, and publishes in the ROS 2 domain. The cell does not depend on it.
class Ros2Service {
 public:
  /// Throws std::runtime_error with a sentence when a domain cannot be joined. `file` has a section `ros2` and must
  /// outlive it.
  Ros2Service(const config::CellFile& file, const services::ServiceOptions& options,
              const services::ShutdownSignal& shutdown);

  /// Runs until the process shall end.
  void run();

 private:
  using Clock = bus::Clock;

  void publish(Clock::time_point now);
  void publish_heartbeat();
  void look_at_graph(Clock::time_point now);
  void look_at_names(Clock::time_point now);

  const config::CellFile& file_;
  bus::Mailbox mailbox_;
  bus::Mailbox ros_mailbox_;
  bus::Participant participant_;
  bus::Participant ros_participant_;
  services::CellModeListener modes_;
  services::HeartbeatPublisher heartbeat_;
  services::PeriodicLoop loop_;
  CellReader cell_;
  PlannerWatch planners_;
  std::shared_ptr<client::Connection> connection_;
  CellPublisher publisher_;
  NameWatch names_;
  std::optional<Control> control_;  ///< empty: ROS 2 nodes may only watch
  std::optional<NodeGraph> graph_;  ///< empty: no distribution is chosen
  StatusPoller status_;
  std::uint64_t told_status_ = 0;  ///< number of the last published status
  std::uint64_t ticks_ = 0;
};

}  // namespace hecaton::ros2
