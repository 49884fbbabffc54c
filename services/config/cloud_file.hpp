#pragma once
/// Files of point clouds: XYZ (text) and PCD, the format of the Point Cloud Library.

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace hecaton::config {

/// The points of a file [m], by its extension:
/// - .xyz: a line for each point, which begins with x, y and z; further numbers, such as a colour, are skipped. Empty
///   lines and lines that begin with # or // are skipped.
/// - .pcd: fields x, y and z of type F; data ascii or binary. A camera has no measurement where one is NaN: such points
///   are left out.
///
/// `path`: where the file is read. `name`: how messages call it. Throws std::invalid_argument with a sentence: for a
/// file that cannot be read or has no points, one that has too many for world::PointCloud, and the first bad line.
[[nodiscard]] std::vector<Eigen::Vector3f> read_cloud_file(const std::filesystem::path& path, const std::string& name);

}  // namespace hecaton::config
