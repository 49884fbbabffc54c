// A collision mesh as a convex shape. The last byte chooses the format and the shape.

#include <array>

#include "planner/model/mesh_shape.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(mesh)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  fuzz::Input input(data, size);
  const std::uint8_t choice = input.last_byte();
  constexpr std::array kFormats{"mesh.stl", "mesh.obj", "mesh.dae"};
  const auto kind = (choice & 4U) != 0 ? planner::MeshGeometry::kCapsule : planner::MeshGeometry::kConvexHull;
  const std::string path = fuzz::folder().write(kFormats[(choice & 3U) % kFormats.size()], fuzz::text_of(input.rest()));
  planner::SourceFiles sources;
  try {
    const auto mesh = planner::mesh_shape(path, {1.0, 1.0, 1.0}, kind, "fuzz.urdf: link 'fuzz'", sources);
    fuzz::require(mesh.geometry.X_LS.matrix().allFinite() && world::bounding_sphere(mesh.geometry.shape).radius > 0.0,
                  "a mesh becomes a shape with a size");
  } catch (const planner::ModelError& error) {
    fuzz::require_sentence(error.what());
  }
  return 0;
}
