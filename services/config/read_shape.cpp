#include "services/config/read_shape.hpp"

#include <array>

#include "planner/model/mesh_shape.hpp"
#include "services/config/config_error.hpp"
#include "services/config/fields.hpp"

namespace hecaton::config {
namespace {

// What the numbers may be, obstacle_rules says.
world::PlacedShape read_box(const MapView& map) {
  const Eigen::Vector3d size = read_vector(map.at("size"), "numbers [x, y, z] in m");
  return {world::Box{size / 2.0}, read_pose(map, "pose")};
}

world::PlacedShape read_sphere(const MapView& map) {
  return {world::Sphere{map.at("radius").number()}, read_pose(map, "pose")};
}

world::PlacedShape read_capsule(const MapView& map) {
  const double length = map.at("length").number();
  return {world::Capsule{map.at("radius").number(), length / 2.0}, read_pose(map, "pose")};
}

world::PlacedShape read_cylinder(const MapView& map) {
  const double height = map.at("height").number();
  return {world::Cylinder{map.at("radius").number(), height / 2.0}, read_pose(map, "pose")};
}

world::PlacedShape read_mesh(const MapView& map) {
  const YamlView file = map.at("file");
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  if (const auto view = map.find("scale")) {
    constexpr Bounds kScale{1e-6, 1e6, ""};
    scale = view->is_sequence() ? read_vector(*view, kScale, "factors [x, y, z]")
                                : Eigen::Vector3d::Constant(view->number(kScale));
  }
  const std::string where = file.file() + ": " + file.path();
  try {
    const planner::LinkGeometry geometry =
        planner::mesh_shape(beside(file.file(), file.text()), scale, planner::MeshGeometry::kConvexHull, where,
                            file.sources())
            .geometry;
    return {geometry.shape, read_pose(map, "pose") * geometry.X_LS};
  } catch (const planner::ModelError& error) {
    throw ConfigError(error.what());
  }
}

using ShapeReader = world::PlacedShape (*)(const MapView&);
constexpr std::array<std::string_view, 5> kTypes = {"box", "sphere", "capsule", "cylinder", "mesh"};
constexpr std::array<const Section*, 5> kSections = {&section::kBox, &section::kSphere, &section::kCapsule,
                                                     &section::kCylinder, &section::kMesh};
constexpr std::array<ShapeReader, 5> kReaders = {read_box, read_sphere, read_capsule, read_cylinder, read_mesh};

}  // namespace

world::PlacedShape read_shape(const YamlView& view) {
  const std::size_t type = view.type(kTypes);
  return kReaders[type](view.map(*kSections[type]));
}

}  // namespace hecaton::config
