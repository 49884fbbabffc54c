/// hecaton-ros2 beside a running cell of three arms, seen and driven by peers that speak ROS 2 on the wire.

#include "tests/cell/ros2/ros2_cell.hpp"

#include <cmath>
#include <csignal>
#include <map>
#include <regex>
#include <set>

namespace hecaton::test {
namespace {

using Transforms = PeerReader<tf2_msgs::msg::TFMessagePubSubType>;
using Texts = PeerReader<std_msgs::msg::StringPubSubType>;
using Markers = PeerReader<visualization_msgs::msg::MarkerArrayPubSubType>;
using Diagnostics = PeerReader<diagnostic_msgs::msg::DiagnosticArrayPubSubType>;
using Trigger = PeerClient<std_srvs::srv::Trigger_RequestPubSubType, std_srvs::srv::Trigger_ResponsePubSubType>;
using Scenes = PeerWriter<moveit_msgs::msg::PlanningScenePubSubType>;

TEST_F(Ros2Cell, PublishesTheJointsOfAllArms) {
  JointStates states(*peer_, "rt/cell/joint_states");
  const auto state = states.next([](const auto& message) { return message.name().size() == 18; });
  ASSERT_TRUE(state);
  const std::set<std::string> names(state->name().begin(), state->name().end());
  EXPECT_EQ(names.size(), 18U);
  EXPECT_TRUE(names.contains("north_joint1") && names.contains("west_joint6") && names.contains("east_joint3"));
  EXPECT_EQ(state->position().size(), 18U);
  EXPECT_EQ(state->velocity().size(), 18U);
  EXPECT_TRUE(state->effort().empty());
  JointStates north(*peer_, "rt/cell/north/joint_states");
  const auto own = north.next();
  ASSERT_TRUE(own);
  EXPECT_EQ(own->name().front(), "joint1");
}

TEST_F(Ros2Cell, DescribesTheCellToLateJoiners) {
  Texts cell(*peer_, "rt/cell/robot_description", {true, true, 1});
  const auto description = cell.next();
  ASSERT_TRUE(description);
  EXPECT_NE(description->data().find("<link name=\"world\"/>"), std::string::npos);
  EXPECT_NE(description->data().find("east_joint6"), std::string::npos);
  Texts arm(*peer_, "rt/cell/west/robot_description", {true, true, 1});
  ASSERT_TRUE(arm.next());

  Transforms fixed(*peer_, "rt/tf_static", {true, true, 100});
  Transforms moving(*peer_, "rt/tf", {true, false, 100});
  const auto at_rest = fixed.next();
  const auto in_motion = moving.next([](const auto& message) { return message.transforms().size() == 18; });
  ASSERT_TRUE(at_rest && in_motion);
  // Every frame has one parent, and all lead to the world.
  std::map<std::string, std::string> parents;
  for (const auto* message : {&*at_rest, &*in_motion}) {
    for (const auto& transform : message->transforms()) {
      EXPECT_TRUE(parents.emplace(transform.child_frame_id(), transform.header().frame_id()).second);
    }
  }
  for (const auto& [child, parent] : parents) {
    std::string frame = child;
    for (int depth = 0; depth < 50 && parents.contains(frame); ++depth) frame = parents.at(frame);
    EXPECT_EQ(frame, "world") << child;
  }
  PeerReader<rosgraph_msgs::msg::ClockPubSubType> clock(*peer_, "rt/clock", {false, false, 1});
  EXPECT_TRUE(clock.next()) << "all arms are simulated";
}

TEST_F(Ros2Cell, ShowsObstaclesAndRemovesThem) {
  const Cell cell = connect();
  Markers markers(*peer_, "rt/cell/hecaton/obstacles");
  const auto ball = [](const auto& message) {
    return std::any_of(message.markers().begin(), message.markers().end(),
                       [](const auto& marker) { return marker.ns() == "ball" && marker.type() == 2; });
  };
  EXPECT_TRUE(markers.next(ball));
  cell.world().add("crate", Box{0.1, 0.2, 0.3}, Pose::xyz(3.0, 0.0, 0.5), Static{}, kLong);
  const auto crate = [](int action) {
    return [action](const auto& message) {
      return std::any_of(message.markers().begin(), message.markers().end(), [&](const auto& marker) {
        return marker.ns() == "crate" && marker.action() == action &&
               (action == 2 || (marker.scale().z() == 0.3 && marker.pose().position().x() == 3.0));
      });
    };
  };
  EXPECT_TRUE(markers.next(crate(0)));
  cell.world().remove("crate", kLong);
  EXPECT_TRUE(markers.next(crate(2)));
}

TEST_F(Ros2Cell, ReportsNodesAndArms) {
  Diagnostics diagnostics(*peer_, "rt/diagnostics");
  const auto message = diagnostics.next([](const auto& candidate) { return candidate.status().size() > 5; });
  ASSERT_TRUE(message);
  std::map<std::string, int> levels;
  for (const auto& status : message->status()) levels[status.name()] = status.level();
  EXPECT_TRUE(levels.contains("hecaton: planner/north")) << levels.size();
  EXPECT_EQ(levels["hecaton: world"], 0);
  PeerReader<diagnostic_msgs::msg::DiagnosticStatusPubSubType> status(*peer_, "rt/cell/north/status");
  const auto north = status.next();
  ASSERT_TRUE(north);
  EXPECT_EQ(north->values()[0].key(), "mode");
}

TEST_F(Ros2Cell, CarriesOutOrders) {
  const Cell cell = connect();
  Trigger hold(*peer_, "/cell/hecaton/hold");
  Trigger resume(*peer_, "/cell/hecaton/resume");
  Trigger stop_north(*peer_, "/cell/north/stop");
  Trigger resume_north(*peer_, "/cell/north/resume");
  ASSERT_TRUE(hold.wait_available() && resume.wait_available() && stop_north.wait_available());
  auto response = hold.call({});
  ASSERT_TRUE(response);
  EXPECT_TRUE(response->success()) << response->message();
  EXPECT_EQ(cell.status(kLong).mode, CellMode::kHold);
  ASSERT_TRUE((response = resume.call({})));
  EXPECT_EQ(cell.status(kLong).mode, CellMode::kRun);
  ASSERT_TRUE((response = stop_north.call({})));
  EXPECT_EQ(cell.status(kLong).stopped_arms, std::vector<std::string>{"north"});
  ASSERT_TRUE((response = resume.call({})));
  EXPECT_TRUE(response->success());
  EXPECT_EQ(response->message(), "north stays stopped: it was stopped by name; resume it by name");
  ASSERT_TRUE(resume_north.wait_available());
  ASSERT_TRUE((response = resume_north.call({})));
  EXPECT_TRUE(response->success()) << response->message();
  EXPECT_TRUE(cell.status(kLong).stopped_arms.empty());
  ASSERT_TRUE((response = resume.call({})));
  EXPECT_EQ(response->message(), "");
}

/// A diff with one object at a pose in a frame; `size` above zero: with a cube.
moveit_msgs::msg::PlanningScene scene_with(const std::string& id, int operation, const std::array<double, 3>& at,
                                           double size, const std::string& frame = "world") {
  moveit_msgs::msg::CollisionObject object;
  object.header().frame_id(frame);
  object.id(id);
  object.operation(static_cast<std::uint8_t>(operation));
  object.pose().position().x(at[0]);
  object.pose().position().y(at[1]);
  object.pose().position().z(at[2]);
  object.pose().orientation().w(1.0);
  if (size > 0.0) {
    object.primitives().resize(1);
    object.primitives()[0].type(1);
    object.primitives()[0].dimensions({size, size, size});
    object.primitive_poses().resize(1);
    object.primitive_poses()[0].orientation().w(1.0);
  }
  moveit_msgs::msg::PlanningScene scene;
  scene.world().collision_objects({object});
  scene.is_diff(true);
  return scene;
}

TEST_F(Ros2Cell, EditsObstaclesByPlanningScenes) {
  constexpr int kAdd = 0;
  constexpr int kRemove = 1;
  constexpr int kAppend = 2;
  constexpr int kMove = 3;
  const Cell cell = connect();
  Scenes scenes(*peer_, "rt/cell/planning_scene");
  Markers markers(*peer_, "rt/cell/hecaton/obstacles");
  Diagnostics diagnostics(*peer_, "rt/diagnostics");
  ASSERT_TRUE(scenes.wait_matched());
  const auto shown = [&](std::size_t shapes, double x, double size) {
    return markers.next([=](const auto& message) {
      std::size_t found = 0;
      for (const auto& marker : message.markers()) {
        if (marker.ns() != "box" || marker.action() != 0) continue;
        found += marker.pose().position().x() == x && marker.scale().x() == size ? 1 : 100;
      }
      return found == shapes;
    });
  };
  scenes.write(scene_with("box", kAdd, {3.0, 0.0, 0.5}, 0.2));
  EXPECT_TRUE(shown(1, 3.0, 0.2));
  scenes.write(scene_with("box", kMove, {3.5, 0.0, 0.5}, 0.0));
  EXPECT_TRUE(shown(1, 3.5, 0.2));
  scenes.write(scene_with("box", kAppend, {3.5, 0.0, 1.5}, 0.2));
  EXPECT_TRUE(shown(2, 3.5, 0.2));
  scenes.write(scene_with("box", kAdd, {3.0, 0.0, 0.5}, 0.4));
  EXPECT_TRUE(shown(1, 3.0, 0.4)) << "it replaces the former one";

  // In the shoulder of an arm: refused, and the former one stays.
  const double north_x = 0.7;
  scenes.write(scene_with("box", kAdd, {north_x, 0.0, 0.67}, 0.3));
  const auto refused = diagnostics.next([](const auto& message) {
    return std::any_of(message.status().begin(), message.status().end(), [](const auto& status) {
      return status.name() == "hecaton: planning scene" && status.level() == 1 &&
             status.message().find("object 'box'") != std::string::npos &&
             status.message().find("north") != std::string::npos;
    });
  });
  EXPECT_TRUE(refused);
  // MoveIt's scenes without objects say nothing of the refused one.
  moveit_msgs::msg::PlanningScene states_only;
  states_only.is_diff(true);
  scenes.write(states_only);
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(diagnostics.next([](const auto& message) {
      const auto& all = message.status();
      const auto scene =
          std::find_if(all.begin(), all.end(), [](const auto& one) { return one.name() == "hecaton: planning scene"; });
      EXPECT_TRUE(scene != all.end() && scene->level() == 1);
      return true;
    }));
  }
  markers.clear();
  EXPECT_TRUE(shown(1, 3.0, 0.4));
  const auto box_removed = [&] {
    return markers.next([](const auto& message) {
      return std::any_of(message.markers().begin(), message.markers().end(),
                         [](const auto& marker) { return marker.ns() == "box" && marker.action() == 2; });
    });
  };
  scenes.write(scene_with("box", kRemove, {}, 0.0));
  EXPECT_TRUE(box_removed());

  // MoveIt's request to remove all objects spares those of other clients.
  static_cast<void>(cell.world().add("probe", Sphere{0.05}, Pose{.position = {3.0, 3.0, 0.5}}, Static{}, kLong));
  scenes.write(scene_with("box", kAdd, {3.0, 0.0, 0.5}, 0.2));
  EXPECT_TRUE(shown(1, 3.0, 0.2));
  markers.clear();
  scenes.write(scene_with("", kRemove, {}, 0.0));
  EXPECT_TRUE(box_removed());
  EXPECT_NO_THROW(cell.world().remove("probe", kLong)) << "it is there";
}

TEST_F(Ros2Cell, AttachesObjectsOfThePlanningSceneOfAnArm) {
  const Cell cell = connect();
  static_cast<void>(home(cell, "west"));
  Scenes scenes(*peer_, "rt/cell/west/planning_scene");
  ASSERT_TRUE(scenes.wait_matched());
  const auto carrier = [&](const std::string& wanted) {
    std::string last = "no obstacle";
    const auto until = std::chrono::steady_clock::now() + kLong;
    while (last != wanted && std::chrono::steady_clock::now() < until) {
      last = "no obstacle";
      for (const ObstacleState& obstacle : cell.world().obstacles(kLong)) {
        if (obstacle.name == "part") last = obstacle.attached_to.value_or("none");
      }
    }
    return last;
  };
  moveit_msgs::msg::PlanningScene scene = scene_with("part", 0, {0.0, 0.0, 0.08}, 0.06, "flange");
  scene.robot_state().attached_collision_objects().resize(1);
  auto& attached = scene.robot_state().attached_collision_objects()[0];
  attached.link_name("flange");  // as the URDF of the arm has it, without a prefix
  attached.object(scene.world().collision_objects()[0]);
  scene.world().collision_objects().clear();
  scenes.write(scene);
  EXPECT_EQ(carrier("west"), "west");
  const auto edited =
      cell.world().add("probe", Sphere{0.05}, Pose{.position = {3.0, 3.0, 0.5}}, Static{}, kLong).edition;
  // MoveIt repeats what an arm carries, and removes it from the world in the same message. Planners go on knowing it.
  moveit_msgs::msg::PlanningScene again = scene;
  again.world().collision_objects() = {attached.object()};
  again.world().collision_objects()[0].operation(1);
  scenes.write(again);
  attached.object().operation(1);
  scenes.write(scene);
  EXPECT_EQ(carrier("none"), "none");
  EXPECT_EQ(cell.world().remove("part", kLong).edition, edited + 2) << "the detachment, and this one";
  cell.world().remove("probe", kLong);
}

/// The newest goal of an arm is reached there.
bool reaches(const Cell& cell, const std::string& arm, const std::vector<double>& q) {
  return cell.wait_until(
      [&] {
        const auto goal = cell.arm(arm).goal();
        if (!goal || goal->state != GoalState::kReached) return false;
        return std::equal(q.begin(), q.end(), goal->q_goal.begin(), goal->q_goal.end(),
                          [](double a, double b) { return std::abs(a - b) < 1e-6; });
      },
      kLong);
}

TEST_F(Ros2Cell, TakesJointPositionsAndPosesAsGoals) {
  const Cell cell = connect();
  std::vector<double> q = home(cell, "north");
  PeerWriter<sensor_msgs::msg::JointStatePubSubType> positions(*peer_, "rt/cell/north/goal_joints");
  ASSERT_TRUE(positions.wait_matched());
  const std::vector<double> step{0.3, 0.1, -0.1, 0.2, 0.0, 0.0};
  for (std::size_t j = 0; j < q.size(); ++j) q[j] += step[j];
  sensor_msgs::msg::JointState joints;
  for (std::size_t j = q.size(); j-- > 0;) {  // in any order, with or without the prefix
    joints.name().push_back((j % 2 == 0 ? "north_joint" : "joint") + std::to_string(j + 1));
    joints.position().push_back(q[j]);
  }
  sensor_msgs::msg::JointState wrong = joints;
  wrong.name()[0] = "elbow";
  wrong.position().assign(q.size(), 0.0);
  positions.write(wrong);
  positions.write(joints);
  EXPECT_TRUE(reaches(cell, "north", q));

  PeerWriter<geometry_msgs::msg::PoseStampedPubSubType> poses(*peer_, "rt/cell/north/goal_pose");
  Markers goals(*peer_, "rt/cell/hecaton/goals");
  Markers plans(*peer_, "rt/cell/hecaton/plans");
  Diagnostics diagnostics(*peer_, "rt/diagnostics");
  ASSERT_TRUE(poses.wait_matched() && goals.wait_matched() && plans.wait_matched() && diagnostics.wait_matched());
  q[0] -= 0.6;
  const Pose tool = tool_at("north", q);
  geometry_msgs::msg::PoseStamped pose;
  pose.pose().position().x(tool.position.x);
  pose.pose().position().y(tool.position.y);
  pose.pose().position().z(tool.position.z);
  pose.pose().orientation().w(tool.rotation[0]);
  pose.pose().orientation().x(tool.rotation[1]);
  pose.pose().orientation().y(tool.rotation[2]);
  pose.pose().orientation().z(tool.rotation[3]);
  pose.header().frame_id("camera");
  const auto before = cell.arm("north").goal();
  const auto refused = [&](const std::string& reason) {
    return diagnostics.next([&](const auto& message) {
      return std::any_of(message.status().begin(), message.status().end(), [&](const auto& entry) {
        return entry.name() == "hecaton: goals" && entry.message() == "arm north: goal_pose: " + reason;
      });
    });
  };
  poses.write(pose);
  EXPECT_TRUE(refused("frame_id = 'camera' must be world"));
  pose.header().frame_id("world");
  pose.pose().position().x(1e9);
  poses.write(pose);
  EXPECT_TRUE(refused("pose.position.x = 1e+09 must be from -1e+06 to 1e+06"));
  pose.pose().position().x(tool.position.x);
  poses.write(pose);
  EXPECT_TRUE(goals.next([](const auto& message) {
    return std::any_of(message.markers().begin(), message.markers().end(),
                       [](const auto& marker) { return marker.ns() == "north" && marker.type() == 9; });
  })) << "the name at the goal";
  EXPECT_TRUE(plans.next([&](const auto& message) {
    return std::any_of(message.markers().begin(), message.markers().end(), [&](const auto& marker) {
      if (marker.ns() != "north" || marker.points().size() < 2) return false;
      const auto& end = marker.points().back();
      return std::hypot(end.x() - tool.position.x, end.y() - tool.position.y, end.z() - tool.position.z) < 0.005;
    });
  })) << "the way to the goal";
  const auto arrived = [&] {
    const auto goal = cell.arm("north").goal();
    return goal && goal->goal != before->goal && goal->state == GoalState::kReached;
  };
  ASSERT_TRUE(cell.wait_until(arrived, kLong));
  const Pose there = tool_at("north", cell.arm("north").state(kLong).q);
  EXPECT_NEAR(there.position.x, tool.position.x, 0.005);
  EXPECT_NEAR(there.position.y, tool.position.y, 0.005);
  EXPECT_NEAR(there.position.z, tool.position.z, 0.005);

  PeerReader<diagnostic_msgs::msg::DiagnosticStatusPubSubType> status(*peer_, "rt/cell/north/status");
  ASSERT_TRUE(status.wait_matched());
  pose.pose().position().x(9.0);
  poses.write(pose);
  EXPECT_TRUE(status.next([](const auto& message) {
    return message.level() == 1 && std::any_of(message.values().begin(), message.values().end(), [](const auto& value) {
             return value.key() == "goal_state" && value.value() == "rejected";
           });
  })) << "its planner rejects what is out of reach";
  EXPECT_TRUE(diagnostics.next([](const auto& message) {
    return std::any_of(message.status().begin(), message.status().end(), [](const auto& entry) {
      return entry.name() == "hecaton: goals" && entry.level() == 1 &&
             entry.message().starts_with("arm north: the planner rejects the goal: ");
    });
  })) << "it was sent, but not applied";
}

TEST_F(Ros2Cell, ReportsAFaultAsAnErrorUntilItIsOver) {
  const Cell cell = connect();
  Diagnostics diagnostics(*peer_, "rt/diagnostics");
  // The text becomes more exact, and the level higher, while a silence lasts.
  const auto shows = [&](const std::string& fault, bool over) {
    return diagnostics.next([&](const auto& message) {
      return std::any_of(message.status().begin(), message.status().end(), [&](const auto& status) {
        return status.name() == "hecaton: fault " + fault && (status.level() == 0) == over &&
               status.hardware_id() == "planner/east" && status.message().find("planner/east") != std::string::npos;
      });
    });
  };
  const pid_t planner = planner_of("east");
  ASSERT_EQ(kill(planner, SIGSTOP), 0);
  std::optional<Fault> fault;
  const auto raised = [&] {
    for (const Fault& candidate : cell.status(kLong).faults) {
      if (candidate.cause.subject == "planner/east" && !candidate.cleared) fault = candidate;
    }
    return fault.has_value();
  };
  const bool seen = cell.wait_until(raised, kLong);
  const bool shown = seen && shows(fault->id, false);
  static_cast<void>(kill(planner, SIGCONT));  // its agent may have replaced it
  ASSERT_TRUE(seen);
  EXPECT_TRUE(shown) << fault->cause.text;
  EXPECT_EQ(fault->cause.kind, CauseKind::kNodeSilent);
  EXPECT_FALSE(fault->cause.text.empty());
  EXPECT_TRUE(shows(fault->id, true)) << fault->cause.text;
  ASSERT_TRUE(cell.wait_until([&] { return cell.status(kLong).mode == CellMode::kRun; }, kLong));
}

// One trajectory ends while the service does not run, one after it, and one is cancelled after it.
}  // namespace
}  // namespace hecaton::test
