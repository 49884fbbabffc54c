#pragma once
/// The topics on which a cell appears in ROS 2. docs/reference/ros2.md lists them.

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <hecaton/types.hpp>

#include "services/config/cell_file.hpp"
#include "services/ros2/order_report.hpp"
#include "services/ros2/publisher.hpp"
#include "services/ros2_messages/cell_messages.hpp"

namespace hecaton::ros2 {

/// A warning after a refusal.
[[nodiscard]] DiagnosticStatus diagnostic(const OrderReport& report, const std::string& cell);

/// For one thread. `file` must outlive it.
class CellPublisher {
 public:
  using Clock = bus::Clock;

  CellPublisher(const config::CellFile& file, bus::Participant& participant);

  /// Publishes descriptions and fixed transforms, which late joiners get, too.
  void publish_descriptions();
  /// Publishes joint states, moving transforms and the clock.
  void publish_states(const CellView& view, Clock::time_point now);
  /// Publishes the status of each arm.
  void publish_arm_status(const CellView& view, Clock::time_point now);
  /// Publishes obstacles, goals, plans and the pairs of bodies that bound motions.
  void publish_markers(CellView& view, const std::vector<OrderedPath>& ordered);
  /// Publishes the nodes and the faults of the cell, and what became of orders. `status` null: `problem` says why.
  void publish_diagnostics(const CellStatus* status, const std::string& problem,
                           const std::vector<OrderReport>& orders);

  /// A node reads the markers of plans.
  [[nodiscard]] bool shows_plans() const { return marker_topics_[CellMarkers::kPlans].wanted(); }
  [[nodiscard]] std::vector<bus::EndpointId> writers() const;

 private:
  struct ArmTopics {
    ArmTopics(const planner::Arm& of, bus::Participant& participant, const std::string& ns);
    const planner::Arm* arm;
    Publisher<String> description;
    Publisher<JointState> states;
    Publisher<DiagnosticStatus> status;
  };
  const config::CellFile& file_;
  bool simulated_;  ///< all devices are
  Publisher<String> description_;
  Publisher<JointState> joint_states_;
  Publisher<TFMessage> transforms_;
  Publisher<TFMessage> fixed_transforms_;
  Publisher<ros2::Clock> clock_;
  Publisher<DiagnosticArray> diagnostics_;
  std::optional<std::set<std::string>> listed_faults_;  ///< in the newest message that had a status
  CellMarkers markers_;
  std::vector<Publisher<MarkerArray>> marker_topics_;  ///< by CellMarkers::Topic
  std::vector<int> marker_readers_;                    ///< of each topic, when it was published last
  std::vector<std::unique_ptr<ArmTopics>> arms_;
};

}  // namespace hecaton::ros2
