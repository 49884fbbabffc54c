#include "services/ros2_messages/markers.hpp"

#include "services/ros2_messages/cell_description.hpp"

namespace hecaton::ros2 {
namespace {

constexpr double kTextHeight = 0.06;  // [m]
constexpr double kAxisWidth = 0.006;  // [m]

Quaternion to_ros(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return {q.x(), q.y(), q.z(), q.w()};
}

struct ShapeMarkers {
  MarkerLayer& layer;
  const std::string& ns;
  const ColorRGBA& color;
  world::Pose X_WS;

  void add(std::int32_t type, const world::Pose& pose, const Eigen::Vector3d& sizes) const {
    Marker& marker = layer.add(type, ns, color);
    marker.pose = ros2::to_ros(pose);
    marker.scale = {sizes.x(), sizes.y(), sizes.z()};
  }
  void operator()(const world::Box& box) const { add(marker::kCube, X_WS, 2.0 * box.half_extents); }
  void operator()(const world::Sphere& ball) const {
    add(marker::kSphere, X_WS, Eigen::Vector3d::Constant(2.0 * ball.radius));
  }
  void operator()(const world::Cylinder& body) const {
    add(marker::kCylinder, X_WS, {2.0 * body.radius, 2.0 * body.radius, 2.0 * body.half_length});
  }
  void operator()(const world::Capsule& body) const {
    add(marker::kCylinder, X_WS, {2.0 * body.radius, 2.0 * body.radius, 2.0 * body.half_length});
    for (const double end : {-body.half_length, body.half_length}) {
      add(marker::kSphere, X_WS * Eigen::Translation3d(0.0, 0.0, end), Eigen::Vector3d::Constant(2.0 * body.radius));
    }
  }
  void operator()(const world::Convex& body) const {
    Marker& marker = layer.add(marker::kTriangles, ns, color);
    marker.pose = ros2::to_ros(X_WS);
    marker.scale = {1.0, 1.0, 1.0};
    const auto& vertices = body.hull->vertices;
    for (const auto& face : body.hull->faces) {
      for (std::size_t i = 2; i < face.size(); ++i) {
        for (const std::size_t corner : {std::size_t{0}, i - 1, i}) {
          marker.points.push_back(to_point(vertices[static_cast<std::size_t>(face[corner])]));
        }
      }
    }
  }
  void operator()(const world::Points& body) const {
    Marker& marker = layer.add(marker::kSpheres, ns, color);
    marker.pose = ros2::to_ros(X_WS);
    marker.scale.x = marker.scale.y = marker.scale.z = 2.0 * body.cloud->radius();
    marker.points.reserve(body.cloud->size());
    for (const Eigen::Vector3f& point : body.cloud->points()) {
      marker.points.push_back(to_point(Eigen::Vector3d(point.cast<double>())));
    }
  }
};

}  // namespace

Pose to_ros(const world::Pose& pose) {
  return {to_point(pose.translation()), to_ros(Eigen::Matrix3d(pose.linear()))};
}

Transform transform_of(const world::Pose& pose) {
  const auto& p = pose.translation();
  return {{p.x(), p.y(), p.z()}, to_ros(Eigen::Matrix3d(pose.linear()))};
}

void MarkerLayer::begin(const Time& stamp) {
  stamp_ = stamp;
  message_.markers.clear();
  numbers_.clear();
  present_.clear();
  if (!first_ && content_ == Content::kChanges) return;
  first_ = false;
  Marker& all = message_.markers.emplace_back();
  all.header = {stamp_, kWorldFrame};
  all.action = marker::kDeleteAll;
  all.pose.orientation.w = 1.0;
}

Marker& MarkerLayer::add(std::int32_t type, const std::string& ns, const ColorRGBA& color) {
  Marker& marker = message_.markers.emplace_back();
  marker.header = {stamp_, kWorldFrame};
  marker.ns = ns;
  marker.id = numbers_[ns]++;
  marker.type = type;
  marker.pose.orientation.w = 1.0;
  marker.color = color;
  present_.emplace(ns, marker.id);
  return marker;
}

void MarkerLayer::add_body(const std::string& ns, const std::vector<world::PlacedShape>& shapes,
                           const world::Pose& X_WO, const ColorRGBA& color) {
  for (const world::PlacedShape& placed : shapes) {
    std::visit(ShapeMarkers{*this, ns, color, X_WO * placed.X_BS}, placed.shape);
  }
}

void MarkerLayer::add_text(const std::string& ns, const std::string& text, const Eigen::Vector3d& p_W,
                           const ColorRGBA& color) {
  Marker& marker = add(marker::kText, ns, color);
  marker.pose.position = to_point(p_W);
  marker.scale.z = kTextHeight;
  marker.text = text;
}

void MarkerLayer::add_line(const std::string& ns, const std::vector<Eigen::Vector3d>& points_W, double width,
                           const ColorRGBA& color) {
  if (points_W.size() < 2) return;
  Marker& marker = add(marker::kLineStrip, ns, color);
  marker.scale.x = width;
  for (const Eigen::Vector3d& point : points_W) marker.points.push_back(to_point(point));
}

void MarkerLayer::add_axes(const std::string& ns, const world::Pose& X_WF, double length) {
  Marker& marker = add(marker::kLineList, ns, {1.0F, 1.0F, 1.0F, 1.0F});
  marker.scale.x = kAxisWidth;
  for (int axis = 0; axis < 3; ++axis) {
    const ColorRGBA color{axis == 0 ? 1.0F : 0.0F, axis == 1 ? 1.0F : 0.0F, axis == 2 ? 1.0F : 0.0F, 1.0F};
    for (const double at : {0.0, length}) {
      marker.points.push_back(to_point(X_WF * Eigen::Vector3d(at * Eigen::Vector3d::Unit(axis))));
      marker.colors.push_back(color);
    }
  }
}

const MarkerArray& MarkerLayer::end() {
  for (const MarkerKey& key : before_) {
    if (content_ == Content::kWhole || present_.contains(key)) continue;
    Marker& gone = message_.markers.emplace_back();
    gone.header = {stamp_, kWorldFrame};
    gone.ns = key.first;
    gone.id = key.second;
    gone.action = marker::kDelete;
    gone.pose.orientation.w = 1.0;
  }
  before_ = present_;
  return message_;
}

}  // namespace hecaton::ros2
