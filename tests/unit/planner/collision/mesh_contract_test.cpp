// Distances of the shapes that replace a mesh never exceed FCL's distances of the mesh's own hull.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/model/capsules.hpp"
#include "planner/model/convex_hull.hpp"
#include "planner/model/mesh_shape.hpp"
#include "random_shapes.hpp"
#include "tests/support/fcl_shape.hpp"

namespace hecaton::planner {
namespace {

constexpr double kMeshAccuracy = 2e-6;  // ours and FCL's together [m]

/// Some hundred points of a dented ellipsoid, as an OBJ file: many more than a planner's hull keeps.
world::ConvexHull write_mesh(test::Random& random, const std::string& path) {
  std::vector<Eigen::Vector3d> points;
  const Eigen::Vector3d half(test::uniform(random, 0.03, 0.3), test::uniform(random, 0.03, 0.3),
                             test::uniform(random, 0.03, 0.3));
  const int count = static_cast<int>(test::uniform(random, 150.0, 400.0));
  for (int i = 0; i < count; ++i) {
    points.push_back(test::uniform(random, 0.8, 1.0) * test::random_direction(random).cwiseProduct(half));
  }
  const auto hull = convex_hull(points);
  std::ofstream file(path);
  file.precision(17);
  for (const Eigen::Vector3d& v : hull->vertices) file << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  for (const auto& face : hull->faces) {
    file << "f";
    for (const int corner : face) file << ' ' << corner + 1;
    file << '\n';
  }
  return *hull;
}

/// A shape in the frame of the mesh.
struct StandIn {
  world::Shape shape;
  Pose X_MS;
};

std::vector<StandIn> stand_ins(const std::string& path) {
  std::vector<StandIn> all;
  for (const MeshGeometry kind : {MeshGeometry::kConvexHull, MeshGeometry::kCapsule}) {
    SourceFiles sources;
    const LinkGeometry geometry = mesh_shape(path, {1, 1, 1}, kind, "test", sources).geometry;
    all.push_back({geometry.shape, geometry.X_LS});
    if (const auto fast = link_capsule(geometry.shape)) {
      all.push_back({fast->placed.capsule, geometry.X_LS * fast->placed.X_FS});
    }
  }
  return all;
}

/// The environment variable HECATON_MESH_PAIRS sets another number.
long pairs_wanted() {
  const char* text = std::getenv("HECATON_MESH_PAIRS");
  return text != nullptr ? std::max(1L, std::atol(text)) : 1'000'000L;
}

constexpr int kShapes = 40;   // beside a mesh
constexpr int kPlaces = 100;  // of each

TEST(FclContract, NeverReportsMoreClearanceForMeshesThanFclForTheirHulls) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("hecaton_mesh_" + std::to_string(getpid()) + ".obj")).string();
  test::Random random(12);
  const long wanted = pairs_wanted();
  long pairs = 0;
  int meshes = 0;
  int reduced = 0;
  for (; pairs < wanted; ++meshes) {
    const world::ConvexHull hull = write_mesh(random, path);
    reduced += hull.vertices.size() > kMaxHullVertices ? 1 : 0;
    const auto stands = stand_ins(path);
    fcl::CollisionObjectd theirs(test::fcl_shape(world::Convex{std::make_shared<world::ConvexHull>(hull)}));
    for (int other = 0; other < kShapes; ++other) {
      const world::Shape shape = test::random_shape(static_cast<test::Kind>(other % test::kKinds), random);
      fcl::CollisionObjectd thing(test::fcl_shape(shape));
      for (int pose = 0; pose < kPlaces; ++pose, ++pairs) {
        const Pose X_WM = test::random_pose(random, 0.6);
        const Pose X_WO = test::random_pose(random, 0.6);
        theirs.setTransform(X_WM);
        thing.setTransform(X_WO);
        fcl::DistanceResultd result;
        const double distance = std::max(0.0, fcl::distance(&theirs, &thing, fcl::DistanceRequestd(), result));
        for (const StandIn& ours : stands) {
          ASSERT_LE(shape_distance(ours.shape, X_WM * ours.X_MS, shape, X_WO).distance, distance + kMeshAccuracy)
              << "mesh " << meshes << ", shape " << other << ", pose " << pose;
        }
      }
    }
  }
  std::filesystem::remove(path);
  EXPECT_GE(reduced, meshes - meshes / 5) << "most meshes must have more vertices than a hull keeps";
  RecordProperty("pairs", std::to_string(pairs));
  std::printf("%ld pairs of %d meshes\n", pairs, meshes);
}

}  // namespace
}  // namespace hecaton::planner
