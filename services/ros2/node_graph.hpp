#pragma once
/// The name of this node in the graph of ROS 2: the topic ros_discovery_info, which `ros2 node list` shows.

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/ros2_endpoint.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::ros2 {

/// The endpoints of a node.
struct NodeEndpoints {
  std::vector<bus::EndpointId> readers;
  std::vector<bus::EndpointId> writers;
};

/// Publishes the node's name once no other node has announced itself for a while with identifiers of another size. Two
/// sizes exist under one type name. A sample of the wrong size can abort the nodes that receive it, so this node falls
/// silent when it sees one. For one thread.
class NodeGraph {
 public:
  using Clock = bus::Clock;

  /// Time in which other nodes announce themselves first.
  static constexpr std::chrono::seconds kLook{2};

  struct Node {
    std::string ns;    ///< "/" or "/cell1"
    std::string name;  ///< "hecaton"
  };
  /// `mailbox` must outlive it.
  NodeGraph(bus::Participant& participant, config::Ros2Distribution distribution, Node node, NodeEndpoints endpoints,
            bus::Mailbox& mailbox);

  /// Takes announcements of other nodes, and publishes this node's when it is due.
  void update(Clock::time_point now);

  /// A node with identifiers of another size was seen: this node is not announced.
  [[nodiscard]] bool conflicting() const { return conflicting_; }
  [[nodiscard]] bool announced() const { return announced_; }

 private:
  bus::Participant& participant_;
  config::Ros2Distribution distribution_;
  Node node_;
  NodeEndpoints endpoints_;
  bus::ros2::Reader others_;
  std::optional<bus::ros2::Writer> writer_;
  Clock::time_point begin_;
  bool conflicting_ = false;
  bool announced_ = false;
};

/// The announcement of one node with identifiers of the distribution's size. `id`: of the participant's endpoints.
[[nodiscard]] bus::ros2::Bytes announcement(config::Ros2Distribution distribution, const NodeGraph::Node& node,
                                            const NodeEndpoints& endpoints);
/// True when the bytes are an announcement of nodes of the other distributions.
[[nodiscard]] bool is_of_other(config::Ros2Distribution distribution, const bus::ros2::Bytes& bytes);

}  // namespace hecaton::ros2
