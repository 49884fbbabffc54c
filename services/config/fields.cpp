#include "services/config/fields.hpp"

#include <filesystem>

namespace hecaton::config {

void read_number(const MapView& map, std::string_view key, double& out) {
  if (const auto view = map.find(key)) out = view->number();
}

void read_number(const MapView& map, std::string_view key, const Bounds& bounds, double& out) {
  if (const auto view = map.find(key)) out = view->number(bounds);
}

void read_seconds(const MapView& map, std::string_view key, const Bounds& bounds, double& out) {
  if (const auto view = map.find(key)) out = view->seconds(bounds);
}

void read_boolean(const MapView& map, std::string_view key, bool& out) {
  if (const auto view = map.find(key)) out = view->boolean();
}

Eigen::Vector3d read_vector(const YamlView& view, const Bounds& bounds, std::string_view of) {
  Eigen::Vector3d vector;
  int i = 0;
  for (const YamlView& item : view.items(3, 3, of)) vector[i++] = item.number(bounds);
  return vector;
}

Eigen::Vector3d read_vector(const YamlView& view, std::string_view of) {
  Eigen::Vector3d vector;
  int i = 0;
  for (const YamlView& item : view.items(3, 3, of)) vector[i++] = item.number();
  return vector;
}

Eigen::Vector3d read_direction(const YamlView& view) {
  const Eigen::Vector3d vector = read_vector(view, {-1e3, 1e3}, "numbers [x, y, z]");
  if (vector.norm() < 1e-6) view.fail("a direction, which the zero vector is not");
  return vector.normalized();
}

world::Pose read_pose(const YamlView& view) {
  const MapView map = view.map(section::kPose);
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  if (const auto value = map.find("xyz")) xyz = read_vector(*value, kCoordinate, "numbers [x, y, z] in m");
  if (const auto value = map.find("rpy")) rpy = read_vector(*value, kAngle, "numbers [roll, pitch, yaw] in rad");
  return world::pose_from_xyz_rpy(xyz, rpy);
}

world::Pose read_pose(const MapView& map, std::string_view key) {
  const auto view = map.find(key);
  return view ? read_pose(*view) : world::Pose::Identity();
}

std::string beside(const std::string& cell_file, const std::string& relative) {
  return (std::filesystem::path(cell_file).parent_path() / relative).lexically_normal().string();
}

}  // namespace hecaton::config
