// A cell file that uses every key, each with a value that is not the default, arrives as it was written.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "planner/methods/boundary_following/boundary_following.hpp"
#include "planner/methods/potential_field/potential_field.hpp"
#include "planner/methods/registry.hpp"
#include "planner/methods/sensed_cspace/sensed_map.hpp"
#include "planner/methods/strategy/strategy.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/schema.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::config {
namespace {

using namespace std::chrono_literals;

const std::string kKeyFile = std::string(HECATON_SOURCE_DIR) + "/tests/data/bad/inline.yaml";

const std::string kText = R"(
name: everything
network: {domain: 7, transport: udp, interface: eth1, discovery: unicast, peers: [10.0.0.9, "10.0.0.8"], lease: 6s}
security: {keystore: keys}
hosts: {alpha: 10.0.0.1, beta: beta.local}
view: {host: alpha, listen: 10.0.0.1, port: 8099, control: true, no_stop: true, certificate: page.pem, key: page-key.pem}
record: {folder: bags, host: beta, keep: 2min, after_fault: 5s, limit: 20MB, split_size: 2MB, split_time: 30s, ros2: true}
world: {host: beta, floor_z: -0.5, gravity: [0, 0, -1.6]}
supervision: {host: alpha, standby_host: beta, heartbeat_period: 5ms, heartbeat_deadline: 25ms, host_lease: 0.2s, watchdog: 3s,
              memory_limit: 300MB,
              failover_timeout: 30000us,
              recovery: {driver_silent: automatic, world_silent: resume, node_missing: automatic, node_silent: automatic,
                         process_died: resume, node_failed: automatic, host_lost: automatic, contact: automatic,
                         device_not_ready: automatic, remote_control_off: automatic, program_stopped: automatic,
                         safeguard_stop: automatic, protective_stop: automatic, emergency_stop: automatic,
                         arm_failed: automatic}}
timing: {control_period: 8ms, driver_period: 1ms, world_period: 4ms, command_timeout: 40 ms, real_time: true}
geometry: exact
ros2: {domain: 3, distribution: humble, namespace: /cell/a, host: beta, interface: eth2, period: 50ms, control: false, enclave: ros/hecaton}
tasks: {frame: base, centre: [1, 2, 3], radius: 0.5, half_height: 0.25, posture: home, conflicting: all,
        time_limit: 0.5min,
        clutter: {count: 3, smallest: 0.1, largest: 0.2, inner: 0.4, outer: 0.8, lowest: -0.5, highest: 0.5}}
defaults:
  limits: {velocity: 1.25, acceleration: 7}
  damper: {influence_distance: 0.2, security_distance: 0.05}
  poses: {home: [0, 1], away: [0, -1]}
arms:
  - name: left
    base: {xyz: [1, 2, 3], rpy: [0, 0, 1.5707963267948966]}
    host: alpha
    standby_host: beta
    urdf: urdf/planar_2r.urdf
    srdf: urdf/planar_2r.srdf
    packages: {somewhere: urdf}
    xacro: {side: left}
    meshes: capsule
    allow_bare_links: true
    chain: [base, upper]
    tool_link: upper
    joints: {elbow: 0.5}
    tool: {xyz: [0.5, 0, 0]}
    limits: {lower: -1.5, upper: [1.5], velocity: [1.0], acceleration: [3]}
    poses: {home: [0.5], away: [-0.5]}
    start: away
    device: {type: simulated}
    signals: {lamp: digital_output 3, belt: digital_output}
    gripper: {width: 0.08, close: {lamp: 1}, open: {lamp: 0}, time: 300ms}
    method: local
    damper: {security_distance: 0.06, convergence_speed: 0.7, self_influence_distance: 0.3, self_security_distance: 0.02}
    follower: {deadlock_fraction: 0.2, exit_fraction: 0.7, resample_after: 2s, resample_growth: 1.5,
               resample_longest: 9s}
    yielding: {yield_request_delay: 3s, at_rest: false}
    replanning: {stall_timeout: 700ms}
    coordination: {stall_timeout: 3s}
    rollout: {candidates: 5, horizon: 1.5s, horizon_growth: 1.2, longest_horizon: 6s, interval: 300ms,
              ticks_per_period: 250}
    sensors:
      - {name: side, link: upper, position: [0, 0.1, 0], direction: [0, 2, 0], to_position: [0.8, 0.1, 0],
         to_direction: [1, 0, 0], rays: 5, range: 0.7, noise: 0.01, period: 20ms, simulated: false}
    sensed: {cells: 240, margin: 0.05, remember: until_nearer, mapper: published}
    potential: {attraction: joints, goal_distance: 0.4, repulsion: 0.002, influence_distance: 0.3, spacing: 0.07}
    strategy: {joints: 2, coefficients: [], direction: -1, distance: 0.07, step: 0.03}
    goal_tolerance: 0.01
    acceleration_of_obstacles: 6
    state_age_limit: 150ms
  - name: right
    host: beta
    urdf: urdf/planar_2r.urdf
    base: {xyz: [-5, 0, 0]}
obstacles:
  - name: still
    shapes:
      - {type: box, size: [0.2, 0.4, 0.6], pose: {xyz: [0, 0, 1]}}
      - {type: sphere, radius: 0.1}
      - {type: capsule, radius: 0.2, length: 0.8}
      - {type: cylinder, radius: 0.3, height: 1.0}
    pose: {xyz: [20, 0, 0]}
    motion: {type: static}
  - name: pyramid
    shapes: [{type: mesh, file: meshes/tetrahedron.stl, scale: [2, 2, 2]}]
    pose: {xyz: [22, 0, 0]}
  - name: scan
    shapes: [{type: points, file: clouds/good.xyz, radius: 0.02, pose: {xyz: [0, 0, 1]}}]
    pose: {xyz: [24, 0, 0]}
  - name: part
    shapes: [{type: sphere, radius: 0.01}]
    attached_to: {arm: left, pose: {xyz: [0.1, 0, 0]}}
  - name: cart
    shapes: [{type: sphere, radius: 0.1}]
    motion: {type: waypoints, poses: [{xyz: [20, 5, 0]}, {xyz: [21, 5, 0]}], speed: 0.3, loop: false}
  - name: moon
    shapes: [{type: sphere, radius: 0.1}]
    pose: {xyz: [20, 10, 0]}
    motion: {type: circle, centre: [20, 11, 0], axis: [0, 3, 4], angular_speed: -0.6, turn_with_motion: true}
  - name: shaker
    shapes: [{type: sphere, radius: 0.1}]
    pose: {xyz: [20, 15, 0]}
    motion: {type: sine, direction: [0, 0, -2], amplitude: 0.4, period: 3s, phase: 0.5}
  - name: belt
    shapes: [{type: sphere, radius: 0.1}]
    pose: {xyz: [20, 20, 0]}
    motion: {type: conveyor, direction: [0, 1, 0], speed: 0.2, length: 2}
  - name: ball
    shapes: [{type: sphere, radius: 0.1}]
    pose: {xyz: [20, 25, 0]}
    motion: {type: dynamic, mass: 2, friction: 0.6, rolling_friction: 0.02, restitution: 0.3,
             linear_velocity: [1, 0, 0], angular_velocity: [0, 0, 2]}
)";

class EveryKeyTest : public testing::Test {
 protected:
  const CellFile file_ = parse_cell_file(kText, kKeyFile);

  const world::Obstacle& obstacle(const std::string& name) const {
    const auto& all = file_.cell.scene.obstacles;
    return *std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == name; });
  }
};

TEST(EveryKeyTextTest, NamesEveryKeyOfTheSchema) {
  for (const Section* section : all_sections()) {
    for (const std::string_view key : section->keys) {
      if (key == "pose_sequence" || key == "file" || key == "areas" || key == "spread" || key == "mean_wait")
        continue;                                                          // see PoseSequenceTest, AreasTest
      if (key == "robot") continue;                                        // in place of urdf: see RobotCatalogue
      if (key == "joint" || key == "closed" || key == "opened") continue;  // need fingers: see ToolKeys
      EXPECT_NE(kText.find(std::string(key) + ":"), std::string::npos) << section->where << "." << key;
    }
  }
}

TEST_F(EveryKeyTest, Geometry) {
  for (const planner::PlannedArm& planned : file_.cell.arms) {
    EXPECT_EQ(planned.arm.shapes, planner::LinkShapes::kExact);
  }
}

TEST_F(EveryKeyTest, NetworkAndHosts) {
  EXPECT_EQ(file_.path, kKeyFile);
  EXPECT_EQ(file_.network.domain, 7);
  EXPECT_EQ(file_.network.transport, Transport::kUdp);
  EXPECT_EQ(file_.network.interface, "eth1");
  EXPECT_EQ(file_.network.discovery, Discovery::kUnicast);
  EXPECT_EQ(file_.network.lease, 6s);
  EXPECT_EQ(file_.network.peers, (std::vector<std::string>{"10.0.0.9", "10.0.0.8"}));
  ASSERT_TRUE(file_.record.has_value());
  EXPECT_EQ(file_.record->host, "beta");
  EXPECT_EQ(file_.record->after_fault, std::chrono::seconds(5));
  EXPECT_EQ(file_.record->limit, 20'000'000U);
  EXPECT_EQ(file_.record->split_size, 2'000'000U);
  EXPECT_EQ(file_.record->split_time, 30s);
  EXPECT_TRUE(file_.record->ros2);
  ASSERT_TRUE(file_.view.has_value());
  EXPECT_EQ(file_.view->host, "alpha");
  EXPECT_EQ(file_.view->listen, "10.0.0.1");
  EXPECT_EQ(file_.view->port, 8099);
  EXPECT_TRUE(file_.view->control);
  EXPECT_TRUE(file_.view->no_stop);
  EXPECT_EQ(std::filesystem::path(file_.view->certificate).filename(), "page.pem");
  EXPECT_EQ(std::filesystem::path(file_.view->key).filename(), "page-key.pem");
  ASSERT_EQ(file_.hosts.size(), 2U);
  EXPECT_EQ(file_.hosts[1].name, "beta");
  EXPECT_EQ(file_.hosts[1].address, "beta.local");
  EXPECT_EQ(file_.world_host, "beta");
  EXPECT_EQ(file_.arm_hosts[0].host, "alpha");
  EXPECT_EQ(file_.arm_hosts[0].standby_host, "beta");
  EXPECT_EQ(file_.arm_hosts[1].host, "beta");
  EXPECT_EQ(file_.arm_hosts[1].standby_host, "");
}

TEST_F(EveryKeyTest, Ros2) {
  ASSERT_TRUE(file_.ros2);
  EXPECT_EQ(file_.ros2->domain, 3);
  EXPECT_EQ(file_.ros2->distribution, Ros2Distribution::kHumble);
  EXPECT_EQ(file_.ros2->ns, "/cell/a");
  EXPECT_EQ(file_.ros2->host, "beta");
  EXPECT_EQ(file_.ros2->interface, "eth2");
  EXPECT_DOUBLE_EQ(file_.ros2->period, 0.05);
  EXPECT_FALSE(file_.ros2->control) << "see KeystoreTest";
  EXPECT_EQ(file_.ros2->enclave, std::string(HECATON_SOURCE_DIR) + "/tests/data/bad/ros/hecaton");
}

TEST_F(EveryKeyTest, SupervisionTimingAndTasks) {
  const Supervision& supervision = file_.supervision;
  EXPECT_EQ(supervision.host, "alpha");
  EXPECT_EQ(supervision.standby_host, "beta");
  EXPECT_EQ(supervision.heartbeat_period, 5ms);
  EXPECT_EQ(supervision.heartbeat_deadline, 25ms);
  EXPECT_EQ(supervision.host_lease, 200ms);
  EXPECT_EQ(supervision.watchdog, 3s);
  EXPECT_EQ(supervision.memory_limit, 300'000'000U);
  EXPECT_TRUE(file_.real_time);
  EXPECT_EQ(supervision.failover_timeout, 30ms);
  EXPECT_EQ(supervision.waits_for_resume, (std::set<std::string, std::less<>>{"process_died", "world_silent"}));
  const planner::Cell& cell = file_.cell;
  EXPECT_DOUBLE_EQ(cell.timing.control_period, 0.008);
  EXPECT_DOUBLE_EQ(cell.timing.driver_period, 0.001);
  EXPECT_DOUBLE_EQ(cell.timing.world_period, 0.004);
  EXPECT_DOUBLE_EQ(cell.timing.command_timeout, 0.040);
  EXPECT_TRUE(cell.tasks.of_each_arm);
  EXPECT_EQ(cell.tasks.centre, Eigen::Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(cell.tasks.radius, 0.5);
  EXPECT_DOUBLE_EQ(cell.tasks.half_height, 0.25);
  EXPECT_EQ(cell.tasks.posture, "home");
  EXPECT_TRUE(cell.tasks.all_conflict);
  EXPECT_DOUBLE_EQ(cell.tasks.time_limit, 30.0);
  EXPECT_DOUBLE_EQ(cell.scene.floor_z, -0.5);
  EXPECT_EQ(cell.scene.gravity, Eigen::Vector3d(0, 0, -1.6));
}

TEST_F(EveryKeyTest, ArmOverridesDefaultsEntryByEntry) {
  const planner::PlannedArm& left = file_.cell.arms[0];
  ASSERT_EQ(left.arm.model->joints(), 1);  // up to its tool link
  EXPECT_DOUBLE_EQ(left.arm.limits.lower[0], -1.5);
  EXPECT_DOUBLE_EQ(left.arm.limits.upper[0], 1.5);
  EXPECT_DOUBLE_EQ(left.arm.limits.velocity[0], 1.0);
  EXPECT_DOUBLE_EQ(left.arm.limits.acceleration[0], 3.0);
  EXPECT_DOUBLE_EQ(left.arm.home()[0], 0.5);
  EXPECT_DOUBLE_EQ(left.start[0], -0.5);
  // Base at (1, 2, 3), turned by 90°: its x axis is W's y.
  EXPECT_LT((left.arm.X_WB * Eigen::Vector3d::UnitX() - Eigen::Vector3d(1, 3, 3)).norm(), 1e-12);
  EXPECT_EQ(left.arm.model->X_LT.translation(), Eigen::Vector3d(0.5, 0, 0));
  const auto& notes = left.arm.model->notes;
  EXPECT_NE(std::find(notes.begin(), notes.end(),
                      "joints outside the chain to the tool are held (arms[0].joints sets them): 'elbow' at 0.5"),
            notes.end());
  const planner::LocalParameters& parameters = left.parameters;
  EXPECT_EQ(parameters.method->traits().name, "local");
  EXPECT_DOUBLE_EQ(parameters.damper.influence_distance, 0.2);  // from the defaults
  EXPECT_DOUBLE_EQ(parameters.damper.security_distance, 0.06);
  EXPECT_DOUBLE_EQ(parameters.damper.convergence_speed, 0.7);
  EXPECT_DOUBLE_EQ(parameters.damper.self_influence_distance, 0.3);
  EXPECT_DOUBLE_EQ(parameters.damper.self_security_distance, 0.02);
  const auto follower = planner::parameters_of<planner::FollowerParameters>(left.methods);
  EXPECT_DOUBLE_EQ(follower.deadlock_fraction, 0.2);
  EXPECT_DOUBLE_EQ(follower.exit_fraction, 0.7);
  EXPECT_DOUBLE_EQ(follower.resample_after, 2.0);
  EXPECT_DOUBLE_EQ(follower.resample_growth, 1.5);
  EXPECT_DOUBLE_EQ(follower.resample_longest, 9.0);
  EXPECT_DOUBLE_EQ(parameters.yielding.yield_request_delay, 3.0);
  EXPECT_FALSE(parameters.yielding.at_rest);
  EXPECT_EQ(parameters.rollout.candidates, 5);
  EXPECT_DOUBLE_EQ(parameters.rollout.horizon, 1.5);
  EXPECT_DOUBLE_EQ(parameters.rollout.horizon_growth, 1.2);
  EXPECT_DOUBLE_EQ(parameters.rollout.longest_horizon, 6.0);
  EXPECT_DOUBLE_EQ(parameters.rollout.interval, 0.3);
  EXPECT_EQ(parameters.rollout.ticks_per_period, 250);
  EXPECT_DOUBLE_EQ(parameters.replanning.stall_timeout, 0.7);
  EXPECT_DOUBLE_EQ(parameters.coordination.stall_timeout, 3.0);
  EXPECT_DOUBLE_EQ(parameters.goal_tolerance, 0.01);
  EXPECT_DOUBLE_EQ(parameters.acceleration_of_obstacles, 6.0);
  EXPECT_DOUBLE_EQ(parameters.state_age_limit, 0.15);
}

TEST_F(EveryKeyTest, ClutterAndSensors) {
  const planner::Clutter& clutter = file_.cell.tasks.clutter;
  EXPECT_EQ(clutter.count, 3);
  EXPECT_DOUBLE_EQ(clutter.smallest, 0.1);
  EXPECT_DOUBLE_EQ(clutter.largest, 0.2);
  EXPECT_DOUBLE_EQ(clutter.inner, 0.4);
  EXPECT_DOUBLE_EQ(clutter.outer, 0.8);
  EXPECT_DOUBLE_EQ(clutter.lowest, -0.5);
  EXPECT_DOUBLE_EQ(clutter.highest, 0.5);
  const planner::PlannedArm& left = file_.cell.arms[0];
  ASSERT_EQ(left.sensors.size(), 1U);
  const planner::RangeSensor& sensor = left.sensors[0];
  EXPECT_EQ(sensor.name, "side");
  EXPECT_EQ(left.arm.model->links[sensor.link].name, "upper");
  EXPECT_DOUBLE_EQ(sensor.range, 0.7);
  EXPECT_DOUBLE_EQ(sensor.noise, 0.01);
  EXPECT_DOUBLE_EQ(sensor.period, 0.02);
  EXPECT_FALSE(sensor.simulated);
  // Five beams from 90° to 0°, every 22.5° and every 0.2 m.
  ASSERT_EQ(sensor.rays.size(), 5U);
  EXPECT_TRUE(sensor.rays[1].origin_L.isApprox(Eigen::Vector3d(0.2, 0.1, 0)));
  EXPECT_TRUE(sensor.rays[2].direction_L.isApprox(Eigen::Vector3d(std::sqrt(0.5), std::sqrt(0.5), 0)));
  EXPECT_TRUE(sensor.rays[4].direction_L.isApprox(Eigen::Vector3d::UnitX()));
  const auto strategy = planner::parameters_of<planner::StrategyParameters>(left.methods);
  const auto sensed = planner::parameters_of<planner::SensedParameters>(left.methods);
  const auto potential = planner::parameters_of<planner::potential::PotentialParameters>(left.methods);
  EXPECT_EQ(strategy.joints, 2);
  EXPECT_EQ(strategy.coefficients, 0);
  EXPECT_EQ(strategy.strategy.direction, -1.0);
  EXPECT_DOUBLE_EQ(strategy.distance, 0.07);
  EXPECT_DOUBLE_EQ(strategy.step, 0.03);
  EXPECT_EQ(sensed.cells, 240);
  EXPECT_DOUBLE_EQ(sensed.margin, 0.05);
  EXPECT_EQ(sensed.remember, planner::Remember::kUntilNearer);
  EXPECT_EQ(sensed.mapper, planner::Mapper::kPublished);
  EXPECT_EQ(potential.attraction, planner::potential::Attraction::kJoints);
  EXPECT_DOUBLE_EQ(potential.goal_distance, 0.4);
  EXPECT_DOUBLE_EQ(potential.repulsion, 0.002);
  EXPECT_DOUBLE_EQ(potential.influence_distance, 0.3);
  EXPECT_DOUBLE_EQ(potential.spacing, 0.07);
  EXPECT_TRUE(file_.cell.arms[1].sensors.empty());
}

TEST_F(EveryKeyTest, SignalsAndGripper) {
  const ToolOptions& left = file_.tools[0];
  ASSERT_EQ(left.signals.size(), 2U);
  EXPECT_EQ(left.signals[1].name, "lamp");
  EXPECT_EQ(left.signals[1].port, "digital_output 3");
  ASSERT_TRUE(left.gripper);
  EXPECT_DOUBLE_EQ(left.gripper->width, 0.08);
  EXPECT_EQ(left.gripper->close.at("lamp"), 1.0);
  EXPECT_EQ(left.gripper->open.at("lamp"), 0.0);
  EXPECT_EQ(left.gripper->time, 300ms);
  EXPECT_FALSE(file_.tools[1].gripper);
}

TEST_F(EveryKeyTest, ArmTakesDefaults) {
  const planner::PlannedArm& right = file_.cell.arms[1];
  ASSERT_EQ(right.arm.model->joints(), 2);
  EXPECT_DOUBLE_EQ(right.arm.limits.velocity[1], 1.25);  // capped from the URDF's 2
  EXPECT_DOUBLE_EQ(right.arm.limits.acceleration[1], 7.0);
  EXPECT_DOUBLE_EQ(right.start[1], 1.0);
  EXPECT_DOUBLE_EQ(right.arm.named.at("away")[1], -1.0);
  EXPECT_DOUBLE_EQ(right.parameters.damper.security_distance, 0.05);
  EXPECT_EQ(right.parameters.method->traits().name, "boundary_following");
}

TEST_F(EveryKeyTest, Shapes) {
  const auto& shapes = obstacle("still").shapes;
  ASSERT_EQ(shapes.size(), 4U);
  EXPECT_TRUE(std::get<world::Box>(shapes[0].shape).half_extents.isApprox(Eigen::Vector3d(0.1, 0.2, 0.3)));
  EXPECT_EQ(shapes[0].X_BS.translation(), Eigen::Vector3d(0, 0, 1));
  EXPECT_DOUBLE_EQ(std::get<world::Sphere>(shapes[1].shape).radius, 0.1);
  EXPECT_DOUBLE_EQ(std::get<world::Capsule>(shapes[2].shape).half_length, 0.4);
  EXPECT_DOUBLE_EQ(std::get<world::Cylinder>(shapes[3].shape).half_length, 0.5);
  // The tetrahedron (0,0,0), (1,0,0), (0,1,0), (0,0,1), twice as large.
  const world::PlacedShape& mesh = obstacle("pyramid").shapes[0];
  const auto& vertices = std::get<world::Convex>(mesh.shape).hull->vertices;
  ASSERT_EQ(vertices.size(), 4U);
  for (const Eigen::Vector3d& vertex : vertices) {
    const Eigen::Vector3d p_O = mesh.X_BS * vertex;
    EXPECT_TRUE(p_O.norm() < 1e-6 || std::abs(p_O.lpNorm<1>() - 2.0) < 1e-6) << p_O.transpose();
  }
  const world::PlacedShape& scan = obstacle("scan").shapes[0];
  const world::PointCloud& cloud = *std::get<world::Points>(scan.shape).cloud;
  EXPECT_DOUBLE_EQ(cloud.radius(), 0.02);
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_EQ(cloud.points()[0], Eigen::Vector3f::Ones());
  EXPECT_EQ(scan.X_BS.translation(), Eigen::Vector3d(0, 0, 1));
}

TEST_F(EveryKeyTest, MotionsAndAttachment) {
  EXPECT_TRUE(std::holds_alternative<world::StaticMotion>(obstacle("still").motion));
  const auto& part = obstacle("part");
  ASSERT_TRUE(part.attachment.has_value());
  EXPECT_EQ(part.attachment->arm, "left");
  EXPECT_EQ(part.attachment->X_TO.translation(), Eigen::Vector3d(0.1, 0, 0));
  const auto& cart = obstacle("cart");
  const auto& waypoints = std::get<world::WaypointMotion>(cart.motion);
  EXPECT_EQ(cart.X_WO.translation(), Eigen::Vector3d(20, 5, 0));
  EXPECT_EQ(waypoints.poses_W[1].translation(), Eigen::Vector3d(21, 5, 0));
  EXPECT_DOUBLE_EQ(waypoints.speed, 0.3);
  EXPECT_FALSE(waypoints.loop);
  const auto& circle = std::get<world::CircleMotion>(obstacle("moon").motion);
  EXPECT_EQ(circle.centre_W, Eigen::Vector3d(20, 11, 0));
  EXPECT_TRUE(circle.axis_W.isApprox(Eigen::Vector3d(0, 0.6, 0.8)));
  EXPECT_DOUBLE_EQ(circle.angular_speed, -0.6);
  EXPECT_TRUE(circle.turn_with_motion);
  const auto& sine = std::get<world::SineMotion>(obstacle("shaker").motion);
  EXPECT_EQ(sine.direction_W, Eigen::Vector3d(0, 0, -1));
  EXPECT_DOUBLE_EQ(sine.amplitude, 0.4);
  EXPECT_DOUBLE_EQ(sine.period, 3.0);
  EXPECT_DOUBLE_EQ(sine.phase, 0.5);
  const auto& conveyor = std::get<world::ConveyorMotion>(obstacle("belt").motion);
  EXPECT_EQ(conveyor.direction_W, Eigen::Vector3d(0, 1, 0));
  EXPECT_DOUBLE_EQ(conveyor.speed, 0.2);
  EXPECT_DOUBLE_EQ(conveyor.length, 2.0);
  const auto& dynamic = std::get<world::DynamicMotion>(obstacle("ball").motion);
  EXPECT_DOUBLE_EQ(dynamic.mass, 2.0);
  EXPECT_DOUBLE_EQ(dynamic.friction, 0.6);
  EXPECT_DOUBLE_EQ(dynamic.rolling_friction, 0.02);
  EXPECT_DOUBLE_EQ(dynamic.restitution, 0.3);
  EXPECT_EQ(dynamic.initial_velocity.linear, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(dynamic.initial_velocity.angular, Eigen::Vector3d(0, 0, 2));
}

TEST(SmallestCellTest, DefaultsAreTheDocumentedOnes) {
  const CellFile file =
      parse_cell_file("name: tiny\narms: [{name: one, urdf: urdf/planar_2r.urdf, poses: {home: [0, 1]}}]\n", kKeyFile);
  EXPECT_EQ(file.network.domain, 42);
  EXPECT_EQ(file.network.transport, Transport::kUdp);
  EXPECT_FALSE(file.real_time);
  ASSERT_EQ(file.hosts.size(), 1U);
  EXPECT_EQ(file.hosts[0].name, "localhost");
  EXPECT_EQ(file.world_host, "localhost");
  EXPECT_EQ(file.supervision.host, "localhost");
  EXPECT_EQ(file.arm_hosts[0].host, "localhost");
  EXPECT_DOUBLE_EQ(file.cell.arms[0].arm.limits.velocity[0], 2.0);  // the URDF's
  EXPECT_DOUBLE_EQ(file.cell.arms[0].arm.limits.acceleration[0], 8.0);
  EXPECT_GT(file.cell.tasks.radius, 0.0);
}

TEST(PoseSequenceTest, NamesPosesInOrder) {
  const CellFile file = parse_cell_file(
      "name: tiny\ntasks: {pose_sequence: [there, home], time_limit: 9s}\n"
      "arms: [{name: one, urdf: urdf/planar_2r.urdf, poses: {home: [0, 1], there: [1, 1]}}]\n",
      kKeyFile);
  EXPECT_EQ(file.cell.tasks.pose_sequence, (std::vector<std::string>{"there", "home"}));
  EXPECT_DOUBLE_EQ(file.cell.tasks.time_limit, 9.0);
}

TEST(AreasTest, NamePosesOfArms) {
  const auto cell = [](const std::string& tasks) {
    return parse_cell_file(
               "name: tiny\ntasks: {" + tasks +
                   "}\narms: [{name: one, urdf: urdf/planar_2r.urdf, poses: {home: [0, 1], there: [1, 1]}}]\n",
               kKeyFile)
        .cell.tasks.problem;
  };
  const planner::MotionProblem problem = cell("areas: {one: [there, home]}, spread: 0.2, mean_wait: 3");
  EXPECT_EQ(problem.areas.at("one"), (std::vector<std::string>{"there", "home"}));
  EXPECT_DOUBLE_EQ(problem.spread, 0.2);
  EXPECT_DOUBLE_EQ(problem.mean_wait, 3.0);
  EXPECT_THROW(cell("areas: {two: [there, home]}"), ConfigError);
  EXPECT_THROW(cell("areas: {one: [there, nowhere]}"), ConfigError);
  EXPECT_THROW(cell("areas: {one: [there]}"), ConfigError);
  EXPECT_THROW(cell("areas: {one: [there, home]}, spread: 3"), ConfigError) << "they overlap";
  EXPECT_THROW(cell("areas: {one: [there, home, there]}"), ConfigError) << "the last and the first are the same";
  EXPECT_THROW(cell("areas: {one: [there, home]}, radius: 1"), ConfigError);
  EXPECT_THROW(cell("centre: [0, 0, 0], spread: 1"), ConfigError);
}

TEST(SrdfPosesTest, AreUsedWithoutPosesInTheCellFile) {
  const CellFile file = parse_cell_file(
      "name: tiny\narms: [{name: one, urdf: urdf/planar_2r.urdf, srdf: urdf/planar_2r.srdf, limits: {upper: [2, "
      "2]}}]\n",
      kKeyFile);
  EXPECT_DOUBLE_EQ(file.cell.arms[0].arm.home()[1], 1.25);
  EXPECT_FALSE(file.cell.arms[0].arm.named.contains("wide"));  // outside the cell file's limits
}

// folding_3r.urdf folds back onto itself in the pose "folded".
const std::string kFoldingArm =
    "name: tiny\narms:\n  - name: one\n    urdf: urdf/folding_3r.urdf\n"
    "    srdf: urdf/folding_3r.srdf\n    poses: {home: [0, 0, 0]}\n";

TEST(SrdfPosesTest, AreLeftOutIfTheArmOverlapsItselfAndNothingUsesThem) {
  const CellFile file = parse_cell_file(kFoldingArm, kKeyFile);
  EXPECT_FALSE(file.cell.arms[0].arm.named.contains("folded"));
  EXPECT_TRUE(file.cell.arms[0].arm.named.contains("bent"));
  EXPECT_EQ(std::count_if(file.notes.begin(), file.notes.end(),
                          [](const std::string& note) {
                            return note.starts_with("arms[0]: pose folded of the SRDF is left out, because one/");
                          }),
            1);
}

TEST(SrdfPosesTest, AreRefusedIfTheyAreUsed) {
  EXPECT_THROW(static_cast<void>(parse_cell_file(kFoldingArm + "    start: folded\n", kKeyFile)), ConfigError);
  EXPECT_THROW(static_cast<void>(parse_cell_file(kFoldingArm + "tasks: {pose_sequence: [home, folded]}\n", kKeyFile)),
               ConfigError);
}

/// A cell with both arms of two_arms.urdf, whose torso turns about z.
std::string two_arms(const std::string& of_left, const std::string& of_right) {
  return "name: dual\ndefaults: {urdf: ../robots/two_arms.urdf, poses: {home: [0.3, 0]}}\narms:\n  - {name: left, " +
         of_left + "}\n  - {name: right, " + of_right + "}\n";
}

TEST(ArmsOfOneRobotTest, ShareTheBodiesThatDoNotMove) {
  const CellFile file = parse_cell_file(
      two_arms("chain: [torso, left_tool]", "chain: [torso, right_tool], joints: {waist: 0}"), kKeyFile);
  const planner::Arm& left = file.cell.arms[0].arm;
  const planner::Arm& right = file.cell.arms[1].arm;
  EXPECT_TRUE(planner::same_robot(left, right));
  EXPECT_EQ(left.model->joint_names, (std::vector<std::string>{"left_joint1", "left_joint2"}));
  EXPECT_EQ(right.model->joint_names, (std::vector<std::string>{"right_joint1", "right_joint2"}));
  const auto has_link = [](const planner::Arm& arm, const std::string& name) {
    return std::any_of(arm.model->links.begin(), arm.model->links.end(),
                       [&](const planner::Link& link) { return link.name == name; });
  };
  EXPECT_TRUE(has_link(left, "torso"));
  EXPECT_TRUE(has_link(right, "torso"));
  EXPECT_TRUE(has_link(right, "head"));
  EXPECT_FALSE(has_link(right, "left_upper"));
  EXPECT_FALSE(has_link(left, "right_hand"));
}

/// A link with a ball at its origin, and the joint that carries it `xyz` from its parent.
std::string humanoid_part(const std::string& parent, const std::string& name, const std::string& type,
                          const std::string& xyz, const std::string& axis = "0 1 0") {
  return "<link name=\"" + name + "\"><collision><geometry><sphere radius=\"0.03\"/></geometry></collision></link>" +
         "<joint name=\"" + name + "_joint\" type=\"" + type + "\"><parent link=\"" + parent + "\"/><child link=\"" +
         name + "\"/><origin xyz=\"" + xyz + "\"/><axis xyz=\"" + axis +
         "\"/><limit lower=\"-0.5\" upper=\"0.5\" velocity=\"1\" effort=\"1\"/></joint>";
}

/// A humanoid: two legs and two arms with fingers, a waist and a head, and frames of sensors on everything.
std::string humanoid() {
  std::string text = "<robot name=\"humanoid\"><link name=\"pelvis\"/>";
  int frames = 0;
  const auto limb = [&](std::string parent, const std::string& name, int joints, const std::string& first,
                        const std::string& next) {
    for (int k = 1; k <= joints; ++k) {
      const std::string link = name + std::to_string(k);
      text += humanoid_part(parent, link, "revolute", k == 1 ? first : next, k % 2 == 0 ? "1 0 0" : "0 1 0");
      for (const char* sensor : {"_imu", "_camera", "_frame"}) {
        const std::string frame = link + sensor;
        text += "<link name=\"" + frame + "\"/><joint name=\"" + frame + "_joint\" type=\"fixed\"><parent link=\"" +
                link + "\"/><child link=\"" + frame + "\"/></joint>";
        ++frames;
      }
      parent = link;
    }
    return parent;
  };
  const std::string chest = limb("pelvis", "waist", 3, "0 0 0.2", "0 0 0.1");
  limb(chest, "head", 2, "0 0 0.3", "0 0 0.1");
  for (const std::string side : {"left", "right"}) {
    const std::string y = side == "left" ? "0.2" : "-0.2";
    limb("pelvis", side + "_leg", 6, "0 " + y + " -0.1", "0 0 -0.15");
    const std::string hand = limb(chest, side + "_arm", 7, "0.1 " + y + " 0.2", "0.12 0 0");
    for (int finger = 1; finger <= 5; ++finger) {
      limb(hand, side + "_finger" + std::to_string(finger) + "_", 3,
           "0.08 " + std::to_string(0.07 * (finger - 3)) + " 0", "0.04 0 0");
    }
  }
  EXPECT_GT(frames, 100);
  return text + "</robot>";
}

TEST(ArmsOfOneRobotTest, ShareAHumanoidOfHundredsOfLinks) {
  const test::TemporaryFolder folder;
  folder.write("humanoid.urdf", humanoid());
  const std::string text =
      "name: humanoid\ndefaults: {urdf: humanoid.urdf, joints: {waist1_joint: 0.1}}\narms:\n"
      "  - {name: left, chain: [waist3, left_arm7]}\n  - {name: right, chain: [waist3, right_arm7]}\n";
  const CellFile file = parse_cell_file(text, folder.path("cell.yaml"));
  for (const planner::PlannedArm& planned : file.cell.arms) {
    const planner::RobotModel& model = *planned.arm.model;
    EXPECT_EQ(model.joints(), 7);
    EXPECT_LE(static_cast<int>(model.links.size()), planner::kMaxLinks);
    EXPECT_EQ(model.links[model.tool_link].name, planned.arm.name + "_arm7");
    for (const planner::Link& link : model.links) {
      EXPECT_FALSE(link.name.starts_with((planned.arm.name == "left" ? "right" : "left") + std::string("_arm")))
          << link.name;
    }
    // 3 links of the waist, 2 of the head, 12 of the legs, 7 of the arm and 15 of its fingers have a ball each.
    EXPECT_EQ(model.geometry.size(), 39U);
  }
  EXPECT_TRUE(planner::same_robot(file.cell.arms[0].arm, file.cell.arms[1].arm));
}

// The other arm would take the head as one that stays where it is.
TEST(ArmsOfOneRobotTest, GiveAJointOfTheirBaseOneRange) {
  const test::TemporaryFolder folder;
  folder.write("humanoid.urdf", humanoid());
  const auto cell = [&](const std::string& left, const std::string& right) {
    const std::string text =
        "name: humanoid\ndefaults: {urdf: humanoid.urdf}\narms:\n  - {name: left, chain: [waist3, left_arm7]" + left +
        "}\n  - {name: right, chain: [waist3, right_arm7]" + right + "}\n";
    return parse_cell_file(text, folder.path("cell.yaml"));
  };
  const std::string head = ", joints: {head1_joint: [-0.2, 0.2]}";
  EXPECT_NO_THROW(static_cast<void>(cell(head, head)));
  EXPECT_NO_THROW(static_cast<void>(cell(", joints: {left_finger1_1_joint: [-0.2, 0.2]}", ""))) << "of its own hand";
  for (const std::string other : {"", ", joints: {head1_joint: [-0.2, 0.3]}", ", joints: {head1_joint: 0.1}"}) {
    try {
      static_cast<void>(cell(head, other));
      FAIL() << "was accepted: " << other;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what())
                    .find("arms[1]: arm left of the same robot has joint head1_joint within [-0.2, 0.2], arm right has "
                          "not; give both joints: {head1_joint: [-0.2, 0.2]}"),
                std::string::npos)
          << error.what();
    }
  }
}

// More than kMaxLinks links: the bare frame of the lift is merged with the chest, and the mast hangs on that.
TEST(ArmsOfOneRobotTest, NameAJointWhoseLinkIsMerged) {
  std::string urdf = humanoid();
  urdf.replace(urdf.find("</robot>"), std::string::npos,
               "<link name=\"lift\"/><joint name=\"lift_joint\" type=\"prismatic\"><parent link=\"waist3\"/><child "
               "link=\"lift\"/><origin xyz=\"-0.3 0 0\"/><axis xyz=\"0 0 1\"/>"
               "<limit lower=\"0\" upper=\"0.5\" velocity=\"1\" effort=\"1\"/></joint>" +
                   humanoid_part("lift", "mast", "fixed", "0 0 0.2") + "</robot>");
  const test::TemporaryFolder folder;
  folder.write("humanoid.urdf", urdf);
  const auto cell = [&](const std::string& left, const std::string& right) {
    const std::string text =
        "name: humanoid\ndefaults: {urdf: humanoid.urdf}\narms:\n  - {name: left, chain: [waist3, left_arm7], joints: "
        "{lift_joint: " +
        left + "}}\n  - {name: right, chain: [waist3, right_arm7], joints: {lift_joint: " + right + "}}\n";
    return parse_cell_file(text, folder.path("cell.yaml"));
  };
  EXPECT_NO_THROW(static_cast<void>(cell("0.1", "0.1")));
  try {
    static_cast<void>(cell("0.1", "0.2"));
    FAIL() << "was accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("arms[1]: arm right has joint lift_joint at another position"),
              std::string::npos)
        << error.what();
  }
}

TEST(ArmsOfOneRobotTest, NotePositionsOfJointsThatAnotherArmHas) {
  const test::TemporaryFolder folder;
  folder.write("humanoid.urdf", humanoid());
  const auto noted = [&](const std::string& defaults, const std::string& left) {
    const std::string text = "name: humanoid\ndefaults: {urdf: humanoid.urdf" + defaults +
                             "}\narms:\n  - {name: left, chain: [waist3, left_arm7]" + left +
                             "}\n  - {name: right, chain: [waist3, right_arm7]}\n";
    const CellFile file = parse_cell_file(text, folder.path("cell.yaml"));
    const std::vector<std::string>& notes = file.cell.arms[0].arm.model->notes;
    return std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.starts_with("arms[0].joints: positions of 'right_finger1_1_joint' have no effect here");
    });
  };
  const std::string finger = ", joints: {right_finger1_1_joint: 0.1}";
  EXPECT_TRUE(noted("", finger));
  EXPECT_FALSE(noted("", ", joints: {left_finger1_1_joint: 0.1}"));
  EXPECT_FALSE(noted(finger, "")) << "the defaults hold for both arms";
}

TEST(ArmsOfOneRobotTest, AreOneRobotHoweverThePathIsWritten) {
  const CellFile file = parse_cell_file(
      two_arms("chain: [torso, left_tool]", "urdf: ../robots/../robots/./two_arms.urdf, chain: [torso, right_tool]"),
      kKeyFile);
  EXPECT_TRUE(planner::same_robot(file.cell.arms[0].arm, file.cell.arms[1].arm));
}

TEST(ArmsOfOneRobotTest, AreOtherRobotsAtOtherPlaces) {
  const CellFile file = parse_cell_file(
      two_arms("chain: [torso, left_tool]", "chain: [torso, right_tool], base: {xyz: [5, 0, 0]}"), kKeyFile);
  EXPECT_FALSE(planner::same_robot(file.cell.arms[0].arm, file.cell.arms[1].arm));
}

TEST(ArmsOfOneRobotTest, AreRefusedIfOneMovesTheOther) {
  try {
    static_cast<void>(parse_cell_file(
        two_arms("tool_link: left_tool, poses: {home: [0, 0.3, 0]}", "chain: [torso, right_tool]"), kKeyFile));
    FAIL() << "was accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(
        std::string(error.what())
            .find("arms[0]: joint waist of arm left moves arm right, too, which no arm may do; hold it with chain: "
                  "[torso, left_tool] at arm left, and set its position with joints: {waist: 0} at both arms"),
        std::string::npos)
        << error.what();
  }
}

TEST(ArmsOfOneRobotTest, HoldASharedJointAtOnePosition) {
  const auto with_waist_at = [](const std::string& left, const std::string& right) {
    return two_arms("chain: [torso, left_tool], joints: {waist: " + left + "}",
                    "chain: [torso, right_tool], joints: {waist: " + right + "}");
  };
  EXPECT_NO_THROW(static_cast<void>(parse_cell_file(with_waist_at("0.4", "0.4"), kKeyFile)));
  try {
    static_cast<void>(parse_cell_file(with_waist_at("0.4", "0.5"), kKeyFile));
    FAIL() << "was accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(
        std::string(error.what())
            .find("arms[1]: arm right has joint waist at another position than arm left of the same robot; give both "
                  "the same position with joints"),
        std::string::npos)
        << error.what();
  }
}

TEST(ArmsOfOneRobotTest, MustNotOverlapEachOtherAtTheStart) {
  try {
    static_cast<void>(parse_cell_file(two_arms("chain: [torso, left_tool], poses: {home: [-1.2, 0]}",
                                               "chain: [torso, right_tool], poses: {home: [1.2, 0]}"),
                                      kKeyFile));
    FAIL() << "was accepted";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("must be clear of the other arms, but right/"), std::string::npos)
        << error.what();
  }
}

TEST(ChainTest, NamesTheToolLinkAlone) {
  EXPECT_THROW(static_cast<void>(parse_cell_file(
                   "name: tiny\narms: [{name: one, urdf: urdf/planar_2r.urdf, chain: [base, fore], tool_link: upper, "
                   "poses: {home: [0, 1]}}]\n",
                   kKeyFile)),
               ConfigError);
}

TEST(RecordTest, HasDefaultsAndRefusesBadValues) {
  const std::string text = "name: tiny\narms: [{name: one, urdf: urdf/planar_2r.urdf, poses: {home: [0, 1]}}]\n";
  EXPECT_FALSE(parse_cell_file(text, kKeyFile).record);
  const auto plain = parse_cell_file(text + "record: {folder: bags}\n", kKeyFile).record;
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->folder, std::string(HECATON_SOURCE_DIR) + "/tests/data/bad/bags");
  EXPECT_EQ(plain->host, "localhost");
  EXPECT_EQ(plain->keep, std::chrono::minutes(10));
  EXPECT_EQ(plain->limit, 5'000'000'000U);
  EXPECT_FALSE(plain->ros2);
  const auto all =
      parse_cell_file(text + "record: {folder: /var/bags, keep: 1min, after_fault: 0s, limit: 1.5 GB}\n", kKeyFile)
          .record;
  ASSERT_TRUE(all);
  EXPECT_EQ(all->folder, "/var/bags");
  EXPECT_EQ(all->keep, std::chrono::minutes(1));
  EXPECT_EQ(all->after_fault, std::chrono::seconds(0));
  EXPECT_EQ(all->limit, 1'500'000'000U);
  for (const char* bad :
       {"{}", "{folder: bags, keep: 5s}", "{folder: bags, limit: 5}", "{folder: bags, limit: 1kB}",
        "{folder: bags, limit: nanGB}", "{folder: bags, host: elsewhere}", "{folder: bags, ros2: maybe}"}) {
    EXPECT_THROW(static_cast<void>(parse_cell_file(text + "record: " + bad + "\n", kKeyFile)), ConfigError) << bad;
  }
  const std::vector<std::pair<std::string, std::string>> splits{
      {"split_size: 5", "must be a number with its unit ("},
      {"split_size: 99kB", ") from 100kB to 1000000GB, such as 500MB"},
      {"split_size: 3GB", "must be at most half of `limit`"},
      {"limit: 20MB, split_size: 11MB", "must be at most half of `limit`"},
      {"split_time: 0.5s", "split_time = 0.5s must be between 1 and"},
      {"split_time: 31d", "split_time"},
      {"split_time: 60", "split_time"}};
  for (const auto& [bad, phrase] : splits) {
    try {
      static_cast<void>(parse_cell_file(text + "record: {folder: bags, " + bad + "}\n", kKeyFile));
      ADD_FAILURE() << bad;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(phrase), std::string::npos) << error.what();
    }
  }
}

TEST(KeystoreTest, IsBesideTheCellFileAndExcludesOrdersOfOpenRos2) {
  const std::string text = "name: tiny\narms: [{name: one, urdf: urdf/planar_2r.urdf, poses: {home: [0, 1]}}]\n";
  const std::string keys = "security: {keystore: keys}\n";
  const std::string orders = "ros2: {control: true}\n";
  EXPECT_EQ(parse_cell_file(text, kKeyFile).keystore, "");
  EXPECT_EQ(parse_cell_file(text + keys, kKeyFile).keystore, std::string(HECATON_SOURCE_DIR) + "/tests/data/bad/keys");
  EXPECT_TRUE(parse_cell_file(text + orders, kKeyFile).ros2->control);
  EXPECT_THROW(static_cast<void>(parse_cell_file(text + keys + orders, kKeyFile)), ConfigError);
  const std::string locked = "ros2: {control: true, enclave: ros/hecaton}\n";
  EXPECT_TRUE(parse_cell_file(text + keys + locked, kKeyFile).ros2->control);
}

TEST(SharedMemoryTest, IsAllowedForOneHost) {
  const CellFile file = parse_cell_file(
      "name: tiny\nnetwork: {transport: shm}\n"
      "arms: [{name: one, urdf: urdf/planar_2r.urdf, poses: {home: [0, 1]}}]\n",
      kKeyFile);
  EXPECT_EQ(file.network.transport, Transport::kSharedMemory);
}

}  // namespace
}  // namespace hecaton::config
