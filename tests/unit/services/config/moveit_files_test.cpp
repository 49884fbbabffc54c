#include "services/config/moveit_files.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "services/config/yaml_tree.hpp"

namespace hecaton::config {
namespace {

/// The message with which `read` refuses a file with this text; empty: none.
template <typename Read>
std::string refusal(const std::string& text, const Read& read) {
  const auto path = std::filesystem::temp_directory_path() / ("moveit" + std::to_string(::getpid()) + ".yaml");
  std::ofstream(path) << text;
  std::string says;
  try {
    read(path.string());
  } catch (const ConfigError& error) {
    says = error.what();
  }
  std::filesystem::remove(path);
  return says;
}

std::string scene_with(const std::string& object, const std::string& more = "") {
  return "world:\n  collision_objects:\n    - {" + object + "}\n" + more;
}

constexpr const char* kBox =
    "id: a, primitives: [{type: box, dimensions: [1, 2, 3]}], "
    "primitive_poses: [{position: [1, 2, 3], orientation: [0, 0, 0, 1]}]";

std::string shape(const std::string& primitive,
                  const std::string& pose = "position: [0, 0, 0], orientation: [0, 0, 0, 1]") {
  return scene_with("id: a, primitives: [{" + primitive + "}], primitive_poses: [{" + pose + "}]");
}

MoveItScene scene_of(const std::string& text) {
  MoveItScene scene;
  EXPECT_EQ(refusal(text, [&](const std::string& path) { scene = read_moveit_scene(path); }), "");
  return scene;
}

TEST(MoveItScene, ReadsFilesOfBenchmarksAndOfRos) {
  const MoveItScene lists = scene_of(scene_with(kBox));
  const MoveItScene maps = scene_of(scene_with(
      "header: {seq: 0, stamp: {secs: 0, nsecs: 0}, frame_id: world}, id: a, type: {key: '', db: ''}, operation: 0, "
      "pose: {position: {x: 1, y: 2, z: 3}, orientation: {x: 0, y: 0, z: 0, w: 1}}, meshes: [], "
      "primitives: [{type: 1, dimensions: [1, 2, 3]}], primitive_poses: [{position: {x: 0, y: 0, z: 0}, orientation: "
      "{x: 0, y: 0, z: 0, w: 1}}], planes: [], subframe_names: [tip], subframe_poses: []"));
  ASSERT_EQ(lists.obstacles.size(), 1U);
  ASSERT_EQ(maps.obstacles.size(), 1U);
  for (const MoveItScene& scene : {lists, maps}) {
    const world::Obstacle& box = scene.obstacles.front();
    EXPECT_EQ(std::get<world::Box>(box.shapes.at(0).shape).half_extents, Eigen::Vector3d(0.5, 1.0, 1.5));
    EXPECT_EQ((box.X_WO * box.shapes[0].X_BS).translation(), Eigen::Vector3d(1, 2, 3));
  }
  EXPECT_TRUE(lists.notes.empty());
  ASSERT_EQ(maps.notes.size(), 1U);
  EXPECT_NE(maps.notes[0].find("world.collision_objects[0]: subframe_names is not read"), std::string::npos);
}

TEST(MoveItScene, ReadsTheRobotName) {
  EXPECT_EQ(scene_of(scene_with(kBox)).robot, "");
  EXPECT_EQ(scene_of(scene_with(kBox, "robot_model_name: ur5\n")).robot, "ur5");
}

TEST(MoveItScene, NotesIgnoredKeys) {
  const MoveItScene scene = scene_of(scene_with(
      kBox, "allowed_collision_matrix: {entry_names: [a]}\nrobot_state: {joint_state: {name: [j], position: [0]}}\n"));
  ASSERT_EQ(scene.notes.size(), 1U);
  EXPECT_NE(scene.notes[0].find("allowed_collision_matrix, robot_state are not read"), std::string::npos);
}

TEST(MoveItScene, RefusesUnknownContent) {
  const auto refused = [](const std::string& text, const std::string& says) {
    const std::string said = refusal(text, [](const std::string& path) { static_cast<void>(read_moveit_scene(path)); });
    EXPECT_NE(said.find(says), std::string::npos) << says << "\n" << said << "\n" << text;
  };
  const std::string box = std::string(kBox) + ", ";
  refused(scene_with(box + "operation: 1"), "collision_objects[0].operation = 1 must be 0 (ADD)");
  refused(scene_with(box + "meshes: [{}]"), "has meshes = [{}], which are not read; give primitives");
  refused(scene_with(box + "planes: [{coef: [0, 0, 1, 0]}]"), "has planes");
  refused(scene_with(box + "primitve: []"), "primitve is not a known key; did you mean 'primitives'");
  refused(scene_with(box + "header: {frame_id: camera}"), "header.frame_id = camera must be empty or world");
  refused(shape("type: cone, dimensions: [1, 1]"), "type = cone must be box, sphere or cylinder");
  refused(shape("type: 4, dimensions: [1, 1]"), "type = 4 must be");
  refused(shape("type: box, dimensions: [1, 1]"), "dimensions = [1, 1] must be a list of 3 numbers");
  refused(shape("type: sphere, dimensions: [-1]"), "dimensions[0] = -1 must be above 0");
  refused(shape("type: sphere, dimensions: [.nan]"), "must be a finite number");
  const std::string ball = "type: sphere, dimensions: [1]";
  refused(shape(ball, "position: [0, .inf, 0], orientation: [0, 0, 0, 1]"), "position[1] = .inf must be a finite");
  refused(shape(ball, "position: [0, 0, 0], orientation: [0, 0, 0, 0]"), "must be a quaternion x, y, z, w of length 1");
  refused(shape(ball, "position: [0, 0, 0], orientation: [0, 0, 1, 1]"), "must be a quaternion x, y, z, w of length 1");
  refused(shape(ball, "position: [0, 0, 0]"), "has no key 'orientation'");
  refused(scene_with("id: a, primitives: [{" + ball + "}], primitive_poses: []"), "one for each primitive");
  refused(scene_with(kBox) + "    - {" + kBox + "}\n", "id = a must be a name that no other object has");
  refused(scene_with(kBox, "is_diff: true\n"), "is_diff = true must be false");
  refused(scene_with(kBox, "link_padding: [{link_name: a, padding: 0.1}]\n"),
          "link_padding[0].padding = 0.1 must be 0");
  refused(scene_with(kBox, "link_scale: [{link_name: a, scale: 2}]\n"), "link_scale[0].scale = 2 must be 1");
  refused("world: {collision_objects: [], octomap: {octomap: {data: [1]}}}\n", "has data = [1], which is not read");
  const auto state = [](const std::string& more) {
    return scene_with(kBox, "robot_state: {joint_state: {name: [j], position: [0]}, " + more + "}\n");
  };
  refused(state("attached_collision_objects: [{link_name: hand}]"), "has attached_collision_objects");
  refused(state("is_diff: true"), "robot_state.is_diff = true must be false");
  refused(state("multi_dof_joint_state: {joint_names: [v], transforms: [{translation: [0, 1, 0], rotation: [0, 0, 0, "
                "1]}]}"),
          "translation = [0, 1, 0] must be [0, 0, 0]");
  const std::string turned = "{child_frame_id: world, transform: {translation: [0, 0, 1], rotation: [0, 0, 0, 1]}}";
  refused(scene_with(kBox, "fixed_frame_transforms: [" + turned + "]\n"), "translation = [0, 0, 1] must be [0, 0, 0]");
}

std::string request_with(const std::string& goal, const std::string& more = "",
                         const std::string& state = "joint_state: {name: [j], position: [0]}") {
  return "start_state: {" + state + "}\ngoal_constraints: [{" + goal + "}]\n" + more;
}

constexpr const char* kJoint = "joint_constraints: [{joint_name: j, position: 1, tolerance_above: 0.1, weight: 1}]";

TEST(MoveItRequest, ReadsConstraintsWithTolerances) {
  MoveItRequest request;
  const std::string text =
      request_with(kJoint, "path_constraints: {name: '', joint_constraints: []}\nmax_velocity_scaling_factor: 1\n");
  EXPECT_EQ(refusal(text, [&](const std::string& path) { request = read_moveit_request(path); }), "");
  EXPECT_EQ(request.start, (std::map<std::string, double>{{"j", 0.0}}));
  EXPECT_EQ(request.goal, (std::map<std::string, double>{{"j", 1.0}}));
  EXPECT_TRUE(request.notes.empty());
}

TEST(MoveItRequest, RefusesUnknownContent) {
  const auto refused = [](const std::string& text, const std::string& says) {
    const std::string said =
        refusal(text, [](const std::string& path) { static_cast<void>(read_moveit_request(path)); });
    EXPECT_NE(said.find(says), std::string::npos) << says << "\n" << said << "\n" << text;
  };
  const std::string joint = std::string(kJoint) + ", ";
  refused(request_with(joint + "position_constraints: [{link_name: hand}]"), "has position_constraints");
  refused(request_with(joint + "orientation_constraints: [{link_name: hand}]"), "has orientation_constraints");
  refused(request_with(joint + "visibility_constraints: [{}]"), "has visibility_constraints");
  refused(request_with("position_constraints: [{link_name: hand}]"), "has position_constraints");
  refused(request_with(std::string(kJoint) + "}, {" + kJoint), "goals to choose from are not read");
  refused(request_with("joint_constraints: [{joint_name: j, position: .nan}]"), "must be a finite number");
  refused(request_with("joint_constraints: [{joint_name: j, position: 1, tolerance_below: -1}]"),
          "tolerance_below = -1");
  refused(request_with("joint_constraints: [{joint_name: j, position: 1}, {joint_name: j, position: 2}]"),
          "joint_name = j must be a joint that is constrained once");
  refused(request_with(kJoint, "path_constraints: {orientation_constraints: [{link_name: hand}]}\n"),
          "has path_constraints");
  refused(request_with(kJoint, "trajectory_constraints: {constraints: [{name: a}]}\n"), "has trajectory_constraints");
  refused(request_with(kJoint, "max_velocity_scaling_factor: 0.5\n"),
          "max_velocity_scaling_factor = 0.5 must be 0 or 1");
  refused(request_with(kJoint, "max_cartesian_speed: 0.5\n"), "max_cartesian_speed = 0.5 must be 0");
  refused(request_with(kJoint, "goal_constraint: []\n"), "goal_constraint is not a known key");
  refused(request_with(kJoint, "", "joint_state: {name: [j, j], position: [0, 1]}"),
          "must be a joint that is named once");
  refused(request_with(kJoint, "", "joint_state: {name: [j, k], position: [0]}"), "one for each name");
  refused(request_with(kJoint, "", "joint_state: {name: [j], position: [0], velocity: [1]}"), "plans begin at rest");
  refused(request_with(kJoint, "", "joint_state: {name: [j], position: [0]}, attached_collision_objects: [{}]"),
          "has attached_collision_objects");
  refused(request_with(kJoint, "", "is_diff: false"), "has no key 'joint_state'");
  refused(request_with(kJoint, "", "is_diff: true, joint_state: {name: [j], position: [0]}"),
          "start_state.is_diff = true must be false: the state that it differs from is not known");
  refused(request_with(kJoint, "group_name: [arm]\n"), "group_name = [arm] must be");
}

TEST(MoveItRequest, ReadsTheGroupName) {
  MoveItRequest request;
  const auto read = [&](const std::string& path) { request = read_moveit_request(path); };
  EXPECT_EQ(
      refusal(request_with(kJoint, "group_name: arm\n", "is_diff: false, joint_state: {name: [j], position: [0]}"),
              read),
      "");
  EXPECT_EQ(request.group, "arm");
  EXPECT_EQ(refusal(request_with(kJoint, "group_name: ''\n"), read), "");
  EXPECT_EQ(request.group, "");
}

TEST(MoveItRequest, ReadsGroupsOfTheSrdf) {
  std::vector<std::string> groups;
  EXPECT_EQ(refusal("<robot name='r'><group name='arm'/><link/><group name='all'><group name='arm'/></group></robot>",
                    [&](const std::string& path) { groups = groups_of_srdf(path); }),
            "");
  EXPECT_EQ(groups, (std::vector<std::string>{"arm", "all"}));
}

}  // namespace
}  // namespace hecaton::config
