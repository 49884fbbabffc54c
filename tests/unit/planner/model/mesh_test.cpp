// Collision meshes of the three formats that URDFs use, written by the test.

#include <limits>
#include <numbers>
#include <sstream>

#include "planner/model/capsules.hpp"
#include "planner/model/convex_hull.hpp"
#include "planner/model/mesh_shape.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

/// Corners (0,0,0) … size, 12 triangles.
Mesh box_mesh(const Eigen::Vector3d& size) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(size.cwiseProduct(Eigen::Vector3d(i & 1, (i >> 1) & 1, (i >> 2) & 1)));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

std::string stl(const Mesh& mesh) {
  std::ostringstream text;
  text << "solid m\n";
  for (const auto& triangle : mesh.triangles) {
    text << "facet normal 0 0 0\n outer loop\n";
    for (const int v : triangle) text << "  vertex " << mesh.vertices[v].transpose() << "\n";
    text << " endloop\nendfacet\n";
  }
  text << "endsolid m\n";
  return text.str();
}

std::string binary_stl(const Mesh& mesh) {
  std::string bytes(80, ' ');
  const auto append = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  append(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) append(0.0F);
    for (const int v : triangle) {
      for (int i = 0; i < 3; ++i) append(static_cast<float>(mesh.vertices[v][i]));
    }
    append(std::uint16_t{0});
  }
  return bytes;
}

std::string obj(const Mesh& mesh) {
  std::ostringstream text;
  text << "mtllib none.mtl\n";
  for (const auto& v : mesh.vertices) text << "v " << v.transpose() << "\n";
  for (const auto& t : mesh.triangles) text << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
  return text.str();
}

std::string dae(const Mesh& mesh, const std::string& up, const std::string& metre, const std::string& node = "") {
  std::ostringstream text;
  text
      << R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>)"
      << "<unit name=\"u\" meter=\"" << metre << "\"/><up_axis>" << up << "</up_axis></asset>"
      << R"(<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count=")"
      << 3 * mesh.vertices.size() << "\">";
  for (const auto& v : mesh.vertices) text << v.transpose() << " ";
  text << R"(</float_array><technique_common><accessor source="#a" stride="3" count=")" << mesh.vertices.size()
       << R"("><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>)"
       << R"(</technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>)"
       << "<triangles count=\"" << mesh.triangles.size() << R"("><input semantic="VERTEX" source="#v" offset="0"/><p>)";
  for (const auto& t : mesh.triangles) text << t[0] << " " << t[1] << " " << t[2] << " ";
  text << "</p></triangles></mesh></geometry></library_geometries>"
       << R"(<library_visual_scenes><visual_scene id="s"><node id="n">)" << node
       << R"(<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>)"
       << R"(<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
  return text.str();
}

Eigen::AlignedBox3d bounds(const LinkGeometry& geometry) {
  Eigen::AlignedBox3d box;
  for (const auto& v : std::get<world::Convex>(geometry.shape).hull->vertices) box.extend(geometry.X_LS * v);
  return box;
}

std::string arm_with_mesh(const std::string& mesh, const std::string& origin = "") {
  return test::robot(test::ball_link("base") + "<link name=\"a\"><collision>" + origin + "<geometry><mesh " + mesh +
                     "/></geometry></collision></link>" + test::joint("j", "revolute", "base", "a", test::kLimit));
}

class MeshFormats : public testing::TestWithParam<const char*> {
 protected:
  static std::string contents(const Mesh& mesh) {
    const std::string name = GetParam();
    if (name == "m.STL") return stl(mesh);
    if (name == "binary.stl") return binary_stl(mesh);
    if (name == "m.obj") return obj(mesh);
    return dae(mesh, "Z_UP", "1");
  }
};

TEST_P(MeshFormats, ReadABoxAsItsEightCorners) {
  const test::TemporaryFolder folder;
  folder.write(std::string("arm/meshes/") + GetParam(), contents(box_mesh({0.1, 0.2, 0.4})));
  const std::string urdf =
      folder.write("arm/urdf/r.urdf",
                   arm_with_mesh("filename=\"package://arm/meshes/" + std::string(GetParam()) + "\" scale=\"1 2 -0.5\"",
                                 R"(<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>)"));
  const auto model = load_urdf(urdf);
  const LinkGeometry& geometry = model->geometry.back();
  const auto& hull = *std::get<world::Convex>(geometry.shape).hull;
  EXPECT_EQ(hull.vertices.size(), 8U);
  EXPECT_NEAR(volume(hull), 0.1 * 0.4 * 0.2, 1e-9);  // scaled: 0.1 × 0.4 × −0.2
  EXPECT_EQ(geometry.excess_volume, 0.0);
  // Turned by a quarter about z: x → y, y → −x; then moved by 1 in x.
  const Eigen::AlignedBox3d box = bounds(geometry);
  EXPECT_TRUE(box.min().isApprox(Eigen::Vector3d(0.6, 0.0, -0.2), 1e-6)) << box.min().transpose();
  EXPECT_TRUE(box.max().isApprox(Eigen::Vector3d(1.0, 0.1, 0.0), 1e-6) || box.max().z() < 1e-6);
  EXPECT_NEAR(box.max().x(), 1.0, 1e-6);
  EXPECT_NEAR(box.max().y(), 0.1, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshFormats, testing::Values("m.STL", "binary.stl", "m.obj", "m.dae"));

TEST(Collada, AppliesUnitAndNodesButNotTheUpAxis) {
  const test::TemporaryFolder folder;
  const Mesh box = box_mesh({100, 200, 400});
  SourceFiles sources;
  for (const std::string up : {"Z_UP", "Y_UP", "X_UP"}) {
    const std::string path = folder.write("m.dae", dae(box, up, "0.001", "<translate>1000 0 0</translate>"));
    const Eigen::AlignedBox3d bound =
        bounds(mesh_shape(path, Eigen::Vector3d::Ones(), MeshGeometry::kConvexHull, "x", sources).geometry);
    EXPECT_TRUE(bound.min().isApprox(Eigen::Vector3d(1.0, 0, 0), 1e-6)) << up << " " << bound.min().transpose();
    EXPECT_TRUE(bound.max().isApprox(Eigen::Vector3d(1.1, 0.2, 0.4), 1e-6)) << up << " " << bound.max().transpose();
  }
}

/// A ball of radius 0.1 with many vertices.
Mesh ball_mesh() {
  Mesh mesh;
  constexpr int kRings = 20;
  constexpr int kSegments = 40;
  for (int i = 0; i <= kRings; ++i) {
    for (int j = 0; j < kSegments; ++j) {
      const double polar = std::numbers::pi * i / kRings;
      const double turn = 2.0 * std::numbers::pi * j / kSegments;
      mesh.vertices.push_back(
          0.1 * Eigen::Vector3d(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)));
      if (i == kRings) continue;
      const int here = i * kSegments + j;
      const int next = i * kSegments + (j + 1) % kSegments;
      mesh.triangles.push_back({here, here + kSegments, next});
      mesh.triangles.push_back({next, here + kSegments, next + kSegments});
    }
  }
  return mesh;
}

TEST(MeshShape, SimplifiesManyVerticesToAnEnclosingHullWithANote) {
  const test::TemporaryFolder folder;
  const Mesh ball = ball_mesh();
  folder.write("ball.stl", binary_stl(ball));
  const auto model = load_urdf(folder.write("r.urdf", arm_with_mesh("filename=\"ball.stl\"")));
  const LinkGeometry& geometry = model->geometry.back();
  const auto& hull = *std::get<world::Convex>(geometry.shape).hull;
  EXPECT_LE(hull.vertices.size(), 64U);
  for (int f = 0; f < static_cast<int>(hull.faces.size()); ++f) {
    const FacePlane plane = face_plane(hull, f);
    for (const auto& v : ball.vertices) ASSERT_LE(plane.normal.dot(v) - plane.offset, 1e-8);  // floats in the file
  }
  EXPECT_GT(geometry.excess_volume, 0.0);
  EXPECT_LT(geometry.excess_volume, 0.3);
  EXPECT_TRUE(test::has_note(*model, "an enclosing polyhedron of "));
}

TEST(MeshShape, GivesACapsuleWithItsExcessOnRequest) {
  const test::TemporaryFolder folder;
  folder.write("box.obj", obj(box_mesh({0.1, 0.1, 0.6})));
  UrdfOptions options;
  options.meshes = MeshGeometry::kCapsule;
  const auto model = load_urdf(folder.write("r.urdf", arm_with_mesh("filename=\"box.obj\"")), options);
  const LinkGeometry& geometry = model->geometry.back();
  const auto& capsule = std::get<world::Capsule>(geometry.shape);
  EXPECT_GE(capsule.radius, 0.05);
  for (const auto& v : box_mesh({0.1, 0.1, 0.6}).vertices) {
    Eigen::Vector3d p = geometry.X_LS.inverse() * v;
    p.z() -= std::clamp(p.z(), -capsule.half_length, capsule.half_length);
    EXPECT_LE(p.norm(), capsule.radius + 1e-7);
  }
  EXPECT_NEAR(geometry.excess_volume, volume(capsule) / (0.1 * 0.1 * 0.6) - 1.0, 1e-3);
  // Around a square prism the circumscribed cylinder alone is π/2 of its volume.
  EXPECT_LT(geometry.excess_volume, 1.0);
  EXPECT_TRUE(test::has_note(*model, "an enclosing capsule stands for mesh"));
}

TEST(MeshShape, RefusesBadMeshes) {
  const test::TemporaryFolder folder;
  SourceFiles sources;
  const auto error = [&](const std::string& name, const std::string& text) -> std::string {
    try {
      std::ignore = mesh_shape(folder.write(name, text), Eigen::Vector3d::Ones(), MeshGeometry::kConvexHull,
                               "r.urdf: link 'a'", sources);
    } catch (const ModelError& caught) {
      return caught.what();
    }
    return "";
  };
  const auto contains = [](const std::string& text, const std::string& part) {
    return text.starts_with("r.urdf: link 'a': mesh '") && text.find(part) != text.npos
               ? testing::AssertionSuccess()
               : testing::AssertionFailure() << text;
  };
  Mesh flat = box_mesh({0.1, 0.2, 0.4});
  for (auto& v : flat.vertices) v.z() = 0.3;
  EXPECT_TRUE(contains(error("flat.stl", stl(flat)), "has no volume"));
  EXPECT_TRUE(contains(error("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"), "has no triangles"));
  EXPECT_TRUE(contains(error("broken.dae", "<COLLADA"), "cannot be read"));
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:1f\nsize 12\n";
  for (const char* name : {"lfs.stl", "lfs.obj", "lfs.dae"}) {
    EXPECT_TRUE(contains(error(name, pointer), "is a pointer of Git LFS, not the file itself; fetch it with"));
  }
  EXPECT_TRUE(contains(error("empty.stl", "solid m\nendsolid m\n"), "has no triangles"));
  EXPECT_TRUE(contains(error("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nl 1 2\nl 3 4\n"), "has no triangles"));
  Mesh broken = box_mesh({0.1, 0.2, 0.4});
  broken.vertices[3].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(contains(error("nan.stl", binary_stl(broken)), "has a vertex that is not finite"));
  EXPECT_TRUE(contains(error("model.step", "ISO-10303-21;"), "has ending '.step'; .stl, .dae and .obj are allowed"));
  EXPECT_TRUE(contains(error("millimetres.stl", stl(box_mesh({100, 200, 4000}))), "is scale="));
}

// Two boxes of 1 litre each, 0.2 m apart: their hull has 4 litres.
TEST(Mesh, NotesTheExcessOfTheHullOfAConcaveMesh) {
  Mesh mesh = box_mesh({0.1, 0.1, 0.1});
  for (const Eigen::Vector3d& v : box_mesh({0.1, 0.1, 0.1}).vertices)
    mesh.vertices.push_back(v + Eigen::Vector3d(0.3, 0, 0));
  for (const auto& [a, b, c] : box_mesh({0.1, 0.1, 0.1}).triangles) mesh.triangles.push_back({a + 8, b + 8, c + 8});
  const test::TemporaryFolder folder;
  const auto load = [&] { return load_urdf(folder.write("r.urdf", arm_with_mesh("filename=\"m.stl\"", ""))); };
  folder.write("m.stl", stl(mesh));
  const auto closed = load();
  EXPECT_NEAR(closed->geometry.back().excess_volume, 1.0, 1e-5);
  EXPECT_TRUE(test::has_note(*closed, "the convex hull stands for mesh"));
  EXPECT_TRUE(test::has_note(*closed, "100 % larger than the mesh"));
  mesh.triangles.pop_back();
  folder.write("m.stl", stl(mesh));
  const auto open = load();
  EXPECT_EQ(open->geometry.back().excess_volume, 0.0) << "the volume of an open mesh is unknown";
}

}  // namespace
}  // namespace hecaton::planner
