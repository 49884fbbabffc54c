#pragma once
/// Readers of what many sections have: optional numbers, vectors, poses. All throw ConfigError.

#include <Eigen/Core>

#include "services/config/yaml_view.hpp"
#include "world/model/pose.hpp"

namespace hecaton::config {

/// Each keeps `out` when the key is absent.
void read_number(const MapView& map, std::string_view key, double& out);  ///< any, as YamlView::number()
void read_number(const MapView& map, std::string_view key, const Bounds& bounds, double& out);
void read_seconds(const MapView& map, std::string_view key, const Bounds& bounds, double& out);
void read_boolean(const MapView& map, std::string_view key, bool& out);

[[nodiscard]] Eigen::Vector3d read_vector(const YamlView& view, const Bounds& bounds, std::string_view of);
/// Any three numbers, also ones that are not finite: whoever uses this judges them.
[[nodiscard]] Eigen::Vector3d read_vector(const YamlView& view, std::string_view of);
/// Normalised; the zero vector is rejected.
[[nodiscard]] Eigen::Vector3d read_direction(const YamlView& view);
/// {xyz, rpy}, either may be missing.
[[nodiscard]] world::Pose read_pose(const YamlView& view);
/// Identity when the key is absent.
[[nodiscard]] world::Pose read_pose(const MapView& map, std::string_view key);

/// `relative` seen from the folder of the cell file; absolute paths stay.
[[nodiscard]] std::string beside(const std::string& cell_file, const std::string& relative);

}  // namespace hecaton::config
