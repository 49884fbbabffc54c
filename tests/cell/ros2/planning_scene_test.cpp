/// Planning scenes of MoveIt as edits of obstacles, without a running cell.

#include "services/ros2/planning_scene.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "planner/model/kinematics.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::test {
namespace {

using ros2::CollisionObject;
using ros2::PlanningScene;
using ros2::SceneEdit;
using ros2::SolidPrimitive;

const planner::Arm& north() {
  static const config::CellFile kFile = config::load_cell_file(std::string(HECATON_LIVE_CELLS) + "/three_puma.yaml");
  return kFile.cell.arms[0].arm;
}
const planner::Kinematics& at_home() {
  static const planner::Kinematics kAtHome = [] {
    planner::Kinematics kinematics;
    planner::forward_kinematics(*north().model, north().X_WB, north().home(), kinematics);
    return kinematics;
  }();
  return kAtHome;
}
ros2::SceneFrames frames() {
  ros2::SceneFrames frames;
  ros2::add_frames(frames, north(), at_home(), "north_");
  frames.emplace("world", ros2::SceneFrame{});
  return frames;
}

SolidPrimitive primitive(std::uint8_t type, std::vector<double> dimensions) {
  return {type, std::move(dimensions), {}};
}
ros2::Pose at(double x, double y, double z) {
  return {{x, y, z}, {0.0, 0.0, 0.0, 1.0}};
}
CollisionObject object(const std::string& id, std::vector<SolidPrimitive> shapes, std::uint8_t operation = 0) {
  CollisionObject object;
  object.id = id;
  object.pose = at(1.0, 2.0, 3.0);
  object.primitives = std::move(shapes);
  object.operation = operation;
  return object;
}
ros2::SceneEdits edits_of(const CollisionObject& object) {
  PlanningScene scene;
  scene.is_diff = true;
  scene.world.collision_objects = {object};
  return ros2::edits_of(scene, frames());
}
ros2::SceneEdits edits_of(const ros2::AttachedCollisionObject& object) {
  PlanningScene scene;
  scene.is_diff = true;
  scene.robot_state.attached_collision_objects = {object};
  return ros2::edits_of(scene, frames());
}
/// A tetrahedron; `dent`: a fifth vertex inside, which makes it concave.
ros2::Mesh tetrahedron(bool dent) {
  ros2::Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}};
  if (!dent) {
    mesh.triangles.push_back({{1, 2, 3}});
    return mesh;
  }
  mesh.vertices.push_back({0.1, 0.1, 0.1});
  mesh.triangles.insert(mesh.triangles.end(), {{{1, 2, 4}}, {{2, 3, 4}}, {{3, 1, 4}}});
  return mesh;
}

TEST(Ros2PlanningScene, AddsPrimitivesInTheFrameOfALink) {
  CollisionObject crate =
      object("crate", {primitive(1, {0.2, 0.4, 0.6}), primitive(3, {0.5, 0.1}), primitive(2, {0.3})});
  crate.header.frame_id = "north_forearm";
  crate.primitive_poses = {at(0.0, 0.0, 0.0), at(0.0, 0.0, 1.0)};  // the third is at the object's frame
  const auto [edits, refusals] = edits_of(crate);
  ASSERT_EQ(edits.size(), 1U) << refusals.at(0).reason;
  EXPECT_EQ(edits[0].kind, SceneEdit::Kind::kAdd);
  EXPECT_FALSE(edits[0].obstacle.attachment);
  const auto& shapes = edits[0].obstacle.shapes;
  ASSERT_EQ(shapes.size(), 3U);
  EXPECT_EQ(std::get<world::Box>(shapes[0].shape).half_extents, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(std::get<world::Cylinder>(shapes[1].shape).radius, 0.1);
  EXPECT_EQ(std::get<world::Cylinder>(shapes[1].shape).half_length, 0.25);
  EXPECT_EQ(shapes[1].X_BS.translation(), Eigen::Vector3d(0.0, 0.0, 1.0));
  EXPECT_EQ(std::get<world::Sphere>(shapes[2].shape).radius, 0.3);
  const auto& links = north().model->links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].name != "forearm") continue;
    const Eigen::Vector3d expected = at_home().X_WL[i] * Eigen::Vector3d(1.0, 2.0, 3.0);
    EXPECT_LT((edits[0].obstacle.X_WO.translation() - expected).norm(), 1e-12);
  }
}

TEST(Ros2PlanningScene, GivesAnObjectWithoutPoseThatOfItsOnlyShape) {
  CollisionObject ball = object("ball", {primitive(2, {0.1})});
  ball.pose = {};  // a quaternion of zeros
  ball.primitive_poses = {at(0.1, 0.2, 0.3)};
  const auto edits = edits_of(ball).edits;
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].obstacle.X_WO.translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_TRUE(edits[0].obstacle.shapes[0].X_BS.isApprox(world::Pose::Identity()));
}

TEST(Ros2PlanningScene, MovesAndRemovesByName) {
  auto edits = edits_of(object("crate", {}, 3)).edits;
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].kind, SceneEdit::Kind::kMove);
  EXPECT_EQ(edits[0].obstacle.X_WO.translation(), Eigen::Vector3d(1.0, 2.0, 3.0));
  edits = edits_of(object("crate", {}, 1)).edits;
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].kind, SceneEdit::Kind::kRemove);
  edits = edits_of(object("crate", {primitive(2, {0.1})}, 2)).edits;
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].kind, SceneEdit::Kind::kAppend);
}

TEST(Ros2PlanningScene, TakesConvexMeshesAlone) {
  CollisionObject wedge = object("wedge", {});
  wedge.meshes = {tetrahedron(false)};
  auto [edits, refusals] = edits_of(wedge);
  ASSERT_EQ(edits.size(), 1U) << refusals.at(0).reason;
  EXPECT_EQ(std::get<world::Convex>(edits[0].obstacle.shapes[0].shape).hull->vertices.size(), 4U);
  wedge.meshes = {tetrahedron(true)};
  refusals = edits_of(wedge).refusals;
  ASSERT_EQ(refusals.size(), 1U);
  EXPECT_NE(refusals[0].reason.find("not convex"), std::string::npos) << refusals[0].reason;
}

TEST(Ros2PlanningScene, RefusesWhatACellCannotHave) {
  const CollisionObject good = object("crate", {primitive(1, {0.2, 0.4, 0.6})});
  ASSERT_EQ(edits_of(good).edits.size(), 1U);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, std::function<void(CollisionObject&)>>> cases{
      {"id", [](auto& o) { o.id.clear(); }},
      {"id", [](auto& o) { o.id = "a\x01"; }},
      {"frame_id", [](auto& o) { o.header.frame_id = "camera"; }},
      {"frame_id", [](auto& o) { o.header.frame_id = "forearm"; }},  // the cell's topic knows it as north_forearm
      {"pose", [&](auto& o) { o.pose.position.x = nan; }},
      {"pose",
       [](auto& o) {
         o.pose.orientation = {0.0, 0.0, 0.0, 2.0};
       }},
      {"dimensions", [](auto& o) { o.primitives[0].dimensions.pop_back(); }},
      {"dimensions", [](auto& o) { o.primitives[0].dimensions.resize(100, 1.0); }},
      {"shapes[0].size", [](auto& o) { o.primitives[0].dimensions[0] = -0.2; }},
      {"shapes[0].size", [&](auto& o) { o.primitives[0].dimensions[0] = nan; }},
      {"type", [](auto& o) { o.primitives[0].type = 77; }},
      {"cone",
       [](auto& o) {
         o.primitives[0] = primitive(4, {0.5, 0.1});
       }},
      {"prism", [](auto& o) { o.primitives[0] = primitive(5, {0.5}); }},
      {"primitive_poses", [](auto& o) { o.primitive_poses.resize(2); }},
      {"64 shapes", [](auto& o) { o.primitives.resize(65, o.primitives[0]); }},
      {"planes", [](auto& o) { o.planes.resize(1); }},
      {"vertex",
       [](auto& o) {
         o.meshes = {{{{{0, 1, 9}}}, {{0, 0, 0}, {1, 0, 0}}}};
       }},
      {"volume",
       [](auto& o) {
         o.meshes = {{{}, {{0, 0, 0}, {1, 0, 0}}}};
       }},
      {"vertices", [](auto& o) { o.meshes.resize(1), o.meshes[0].vertices.resize(5000); }},
      {"MOVE", [](auto& o) { o.operation = 3; }},
      {"operation", [](auto& o) { o.operation = 9; }},
      {"shapes", [](auto& o) { o.primitives.clear(); }}};
  for (const auto& [word, change] : cases) {
    CollisionObject bad = good;
    change(bad);
    const auto [edits, refusals] = edits_of(bad);
    EXPECT_TRUE(edits.empty()) << word;
    ASSERT_EQ(refusals.size(), 1U) << word;
    EXPECT_NE(refusals[0].reason.find(word), std::string::npos) << word << ": " << refusals[0].reason;
  }
  PlanningScene whole;
  whole.world.collision_objects = {good};
  EXPECT_TRUE(ros2::edits_of(whole, frames()).edits.empty()) << "it would remove the obstacles of the cell file";
  PlanningScene octomap;
  octomap.is_diff = true;
  octomap.world.octomap.octomap.data = {1};
  EXPECT_EQ(ros2::edits_of(octomap, frames()).refusals.size(), 1U);
}

TEST(Ros2PlanningScene, AttachesToLinksThatMoveWithTheTool) {
  ros2::AttachedCollisionObject attached;
  attached.link_name = "north_tool0";
  attached.object = object("part", {primitive(2, {0.03})});
  attached.object.header.frame_id = "north_flange";
  attached.object.pose = at(0.0, 0.0, 0.05);
  auto [edits, refusals] = edits_of(attached);
  ASSERT_EQ(edits.size(), 1U) << refusals.at(0).reason;
  EXPECT_EQ(edits[0].kind, SceneEdit::Kind::kAdd);
  ASSERT_TRUE(edits[0].obstacle.attachment);
  EXPECT_EQ(edits[0].obstacle.attachment->arm, "north");
  EXPECT_TRUE((at_home().X_WT * edits[0].obstacle.attachment->X_TO).isApprox(edits[0].obstacle.X_WO, 1e-9));

  attached.object.primitives.clear();  // an obstacle that the cell has
  edits = edits_of(attached).edits;
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].kind, SceneEdit::Kind::kAttach);
  EXPECT_EQ(edits[0].arm, "north");

  attached.object.operation = 1;
  edits = edits_of(attached).edits;
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].kind, SceneEdit::Kind::kDetach);

  attached.object.operation = 0;
  attached.link_name = "north_forearm";
  EXPECT_EQ(edits_of(attached).refusals.size(), 1U) << "a joint is between it and the tool";
}

TEST(Ros2PlanningScene, RemovesAndDetachesAllWithoutAnId) {
  auto edits = edits_of(object("", {}, 1)).edits;
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].kind, SceneEdit::Kind::kRemoveAll);
  EXPECT_EQ(edits[0].source, "") << "of all topics";

  ros2::AttachedCollisionObject attached;
  attached.object.operation = 1;
  edits = edits_of(attached).edits;
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].kind, SceneEdit::Kind::kDetachAll);
  EXPECT_EQ(edits[0].arm, "") << "from any arm";
  edits = ros2::of_topic(edits_of(attached), "south").edits;
  EXPECT_EQ(edits[0].arm, "south") << "the move_group of south knows no other arm";
  EXPECT_EQ(edits[0].source, "south");
  attached.link_name = "north_tool0";
  edits = ros2::of_topic(edits_of(attached), "south").edits;
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].arm, "north");
  attached.link_name = "north_forearm";
  EXPECT_EQ(edits_of(attached).refusals.size(), 1U);
}

TEST(Ros2PlanningScene, RefusesAPartFarFromTheTool) {
  ros2::AttachedCollisionObject attached;
  attached.link_name = "north_flange";
  attached.object = object("part", {primitive(2, {0.03})});
  attached.object.header.frame_id = "north_flange";
  attached.object.pose = at(0.0, 0.0, 0.5);
  const auto refusals = edits_of(attached).refusals;
  ASSERT_EQ(refusals.size(), 1U);
  EXPECT_NE(refusals[0].reason.find("tool"), std::string::npos) << refusals[0].reason;
}

}  // namespace
}  // namespace hecaton::test
