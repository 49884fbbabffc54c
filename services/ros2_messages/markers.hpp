#pragma once
/// Markers of ROS 2 for what a cell's planners and its world service publish. All are in the frame `world`.

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "services/ros2_messages/ros2_types.hpp"
#include "world/model/pose.hpp"
#include "world/model/scene.hpp"

namespace hecaton::ros2 {

[[nodiscard]] Pose to_ros(const world::Pose& pose);
[[nodiscard]] Transform transform_of(const world::Pose& pose);
[[nodiscard]] inline Point to_point(const Eigen::Vector3d& p) {
  return {p.x(), p.y(), p.z()};
}

/// A marker's place in its array: namespace and number.
using MarkerKey = std::pair<std::string, std::int32_t>;

/// The markers of one topic. A marker that is not in the next message is deleted in it.
class MarkerLayer {
 public:
  enum class Content : std::uint8_t {
    kChanges,  ///< a reader needs each message: it deletes what the last one had
    kWhole,    ///< each message deletes all markers before its own, so that a reader may miss messages
  };
  explicit MarkerLayer(Content content = Content::kChanges) : content_(content) {}

  /// A reader is new: it may show what an earlier process has left, and the next message deletes that.
  void welcome() { first_ = true; }
  /// Begins a message. The first one deletes what an earlier process has left.
  void begin(const Time& stamp);
  /// A marker with its header, namespace, number and colour; lines and texts get their points and text by the caller.
  Marker& add(std::int32_t type, const std::string& ns, const ColorRGBA& color);
  /// The shapes of a body at `X_WO`.
  void add_body(const std::string& ns, const std::vector<world::PlacedShape>& shapes, const world::Pose& X_WO,
                const ColorRGBA& color);
  void add_text(const std::string& ns, const std::string& text, const Eigen::Vector3d& p_W, const ColorRGBA& color);
  /// A line through the points, or between each two of them.
  void add_line(const std::string& ns, const std::vector<Eigen::Vector3d>& points_W, double width,
                const ColorRGBA& color);
  /// The three axes of a frame: x red, y green, z blue.
  void add_axes(const std::string& ns, const world::Pose& X_WF, double length);
  /// Ends the message. Valid until the next begin().
  const MarkerArray& end();
  [[nodiscard]] const MarkerArray& message() const { return message_; }

 private:
  Time stamp_;
  MarkerArray message_;
  std::map<std::string, std::int32_t> numbers_;  ///< of the next marker, by namespace
  std::set<MarkerKey> present_;
  std::set<MarkerKey> before_;
  Content content_;
  bool first_ = true;
};

// Types and actions of visualization_msgs/msg/Marker.
namespace marker {
inline constexpr std::int32_t kCube = 1;
inline constexpr std::int32_t kSphere = 2;
inline constexpr std::int32_t kCylinder = 3;
inline constexpr std::int32_t kLineStrip = 4;
inline constexpr std::int32_t kLineList = 5;
inline constexpr std::int32_t kText = 9;
inline constexpr std::int32_t kSpheres = 7;  ///< a list
inline constexpr std::int32_t kTriangles = 11;
inline constexpr std::int32_t kDelete = 2;
inline constexpr std::int32_t kDeleteAll = 3;
}  // namespace marker

}  // namespace hecaton::ros2
