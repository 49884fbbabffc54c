#pragma once
/// The messages in which a cell appears in ROS 2 and in tools that speak its formats. docs/reference/ros2.md lists
/// their topics.

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <idl/health.h>

#include "planner/cell.hpp"
#include "services/ros2_messages/cell_view.hpp"
#include "services/ros2_messages/markers.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::ros2 {

/// Between two messages of a topic, live and in bags.
inline constexpr std::chrono::milliseconds kMarkerPeriod{100};
inline constexpr std::chrono::milliseconds kStatusPeriod{500};
inline constexpr std::chrono::milliseconds kDiagnosticsPeriod{1000};

/// The path of the tool of one arm that a node of ROS 2 has ordered.
struct OrderedPath {
  std::string arm;
  std::vector<planner::JointVector> points;  ///< [rad | m]
};

/// The state of the arm is known and younger than a second.
[[nodiscard]] bool is_shown(const ArmSnapshot& arm, bus::Clock::time_point now);
/// Joints with the names of the arm's URDF, then those outside the chain whose position is known, with velocity 0. The
/// arm is_shown().
[[nodiscard]] JointState joint_state(const ArmSnapshot& arm);
/// Joints of all arms that are shown, as ARM_JOINT. No names: none is.
[[nodiscard]] JointState joint_states(const CellView& view, bus::Clock::time_point now);
/// The links that a joint moves, of all arms that are shown.
[[nodiscard]] TFMessage moving_transforms(const CellView& view, bus::Clock::time_point now);
/// Bases in `world`, fixed links and tools.
[[nodiscard]] TFMessage fixed_transforms(const planner::Cell& cell, const Time& stamp);

/// Markers of obstacles, goals, plans and the pairs of bodies that bound motions. For one thread.
class CellMarkers {
 public:
  enum Topic : std::uint8_t { kObstacles, kGoals, kPlans, kPairs };
  static constexpr std::array<std::string_view, 4> kNames{"obstacles", "goals", "plans", "binding_pairs"};

  /// `cell` must outlive it.
  explicit CellMarkers(const planner::Cell& cell, MarkerLayer::Content content = MarkerLayer::Content::kChanges)
      : cell_(cell), layers_{MarkerLayer(content), MarkerLayer(content), MarkerLayer(content), MarkerLayer(content)} {}

  /// A reader of the topic is new.
  void welcome(std::size_t topic) { layers_[topic].welcome(); }
  /// `ordered`: paths to draw beside the plans. `stamp`: of the markers.
  void update(CellView& view, const std::vector<OrderedPath>& ordered, const Time& stamp);
  /// Of the last update(). Valid until the next one.
  [[nodiscard]] const MarkerArray& message(std::size_t topic) const { return layers_[topic].message(); }

 private:
  void mark_goal(const ArmSnapshot& arm);
  void mark_binding(const CellView& view, const ArmSnapshot& arm);
  void mark_plan(const ArmSnapshot& arm);
  void mark_orders(const std::vector<OrderedPath>& ordered);

  const planner::Cell& cell_;
  std::array<MarkerLayer, kNames.size()> layers_;
};

/// The status of an arm as ROS 2 shows it.
[[nodiscard]] DiagnosticStatus status_of(const ArmSnapshot& arm, bus::Clock::time_point now);

/// What a node reports of itself.
struct NodeDiagnosis {
  std::string name;
  std::string host;
  msg::NodeState state{};
  std::string cause;  ///< a sentence; empty: none
  bool alive = false;
  double age = 0.0;  ///< of its newest heartbeat [s]
};
/// A fault of the cell.
struct FaultDiagnosis {
  std::string id;
  std::string subject;
  std::string kind;
  std::string text;
  msg::Severity severity{};
  bool cleared = false;
};
/// `name`: without the prefix "hecaton: ".
[[nodiscard]] DiagnosticStatus diagnostic(std::uint8_t grade, const std::string& name, std::string message,
                                          std::string hardware);
[[nodiscard]] DiagnosticStatus diagnostic(const NodeDiagnosis& node);
[[nodiscard]] DiagnosticStatus diagnostic(const FaultDiagnosis& fault);

/// Levels of diagnostic_msgs/msg/DiagnosticStatus.
namespace level {
inline constexpr std::uint8_t kOk = 0;
inline constexpr std::uint8_t kWarn = 1;
inline constexpr std::uint8_t kError = 2;
inline constexpr std::uint8_t kStale = 3;
}  // namespace level

}  // namespace hecaton::ros2
