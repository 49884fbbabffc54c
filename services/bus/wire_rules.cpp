#include "services/bus/wire_rules.hpp"

#include <algorithm>
#include <array>

#include <idl/device.h>
#include <idl/planner.h>
#include <idl/recorder.h>
#include <idl/supervisor.h>

// The table. Fields stand in the order of the idl files; the test wire_rules_test compares both.

namespace hecaton::bus {
namespace {

using enum FieldKind;

constexpr double kLargestCount = 4.6e18;  ///< numbers of samples, stamps [ns]
constexpr double kLargestPosition = 1e6;  ///< [rad | m]
constexpr double kLargestVelocity = 1e4;  ///< [rad/s | m/s]
constexpr double kLongestTime = 1e9;      ///< [s]; in nanoseconds it fits into 64 bits
constexpr double kLastDate = 8e12;        ///< of the wall clock [ms]: the year 2223; likewise
constexpr std::uint32_t kLongestText = 16384;
constexpr std::uint32_t kLongestBody = 512;  ///< "arm1/link4"
constexpr std::uint32_t kMostArms = 256;
constexpr std::uint32_t kMostMotionPoints = 64;
constexpr std::uint32_t kMostObstacles = 4096;
constexpr std::uint32_t kMostCloudPoints = 100'000;  ///< of one obstacle: the sample stays below kLargest

constexpr FieldRule boolean(std::string_view name) {
  return {.name = name, .kind = kBool, .low = 0, .high = 1};
}
constexpr FieldRule int32(std::string_view name, double low, double high) {
  return {.name = name, .kind = kInt32, .low = low, .high = high};
}
/// Linux counts to 2²² at most.
constexpr FieldRule process_id(std::string_view name) {
  return int32(name, 0, 4194304.0);
}
constexpr FieldRule uint32(std::string_view name, double high = 4294967295.0) {
  return {.name = name, .kind = kUint32, .low = 0, .high = high};
}
constexpr FieldRule count(std::string_view name) {
  return {.name = name, .kind = kUint64, .low = 0, .high = kLargestCount};
}
constexpr FieldRule stamp(std::string_view name) {
  return {.name = name, .kind = kInt64, .low = -kLargestCount, .high = kLargestCount};
}
constexpr FieldRule date(std::string_view name) {
  return {.name = name, .kind = kInt64, .low = -kLastDate, .high = kLastDate};
}
constexpr FieldRule term(std::string_view name) {
  return {.name = name, .kind = kTerm};
}
constexpr FieldRule number(std::string_view name, double low, double high) {
  return {.name = name, .kind = kDouble, .low = low, .high = high};
}
/// Signed: negative ages and distances mean "none" in some fields.
constexpr FieldRule time(std::string_view name) {
  return number(name, -kLongestTime, kLongestTime);
}
constexpr FieldRule position(std::string_view name) {
  return number(name, -kLargestPosition, kLargestPosition);
}
constexpr FieldRule positions(std::string_view name, std::uint32_t most) {
  return {.name = name, .kind = kDoubles, .low = -kLargestPosition, .high = kLargestPosition, .most = most};
}
constexpr FieldRule velocities(std::string_view name, std::uint32_t most) {
  return {.name = name, .kind = kDoubles, .low = -kLargestVelocity, .high = kLargestVelocity, .most = most};
}
constexpr FieldRule name_of(std::string_view name, std::uint32_t most = kLongestName) {
  return {.name = name, .kind = kName, .most = most};
}
constexpr FieldRule text(std::string_view name, std::uint32_t most = kLongestText) {
  return {.name = name, .kind = kText, .most = most};
}
constexpr FieldRule names(std::string_view name, std::uint32_t most) {
  return {.name = name, .kind = kNames, .most = most};
}
template <class Enum>
constexpr FieldRule choice(std::string_view name, Enum last) {
  return {.name = name, .kind = kEnum, .low = 0, .high = static_cast<double>(last)};
}
constexpr FieldRule nested(std::string_view name, const StructRule& of) {
  return {.name = name, .kind = kStruct, .of = &of};
}
constexpr FieldRule list(std::string_view name, const StructRule& of, std::uint32_t most) {
  return {.name = name, .kind = kStructs, .most = most, .of = &of};
}

constexpr FieldRule kSchema{.name = "schema", .kind = kUint32, .low = msg::SCHEMA_VERSION, .high = msg::SCHEMA_VERSION};
constexpr FieldRule kMode = choice("mode", msg::Mode::MODE_STOP);
constexpr FieldRule kOrdered = choice("ordered", msg::Mode::MODE_STOP);

// common.idl
constexpr std::array kPointFields{position("x"), position("y"), position("z")};
constexpr StructRule kPoint{"Vec3", kPointFields};
constexpr std::array kPoseFields{nested("position", kPoint), number("qw", -1.001, 1.001), number("qx", -1.001, 1.001),
                                 number("qy", -1.001, 1.001), number("qz", -1.001, 1.001)};
constexpr StructRule kPose{"Pose", kPoseFields};
constexpr std::array kTwistFields{nested("linear", kPoint), nested("angular", kPoint)};
constexpr StructRule kTwist{"Twist", kTwistFields};

// cause.idl
constexpr std::array kCauseFields{choice("kind", msg::CauseKind::CAUSE_NOT_PERSISTED), name_of("subject", kLongestBody),
                                  text("text")};
constexpr StructRule kCause{"Cause", kCauseFields};

// arm.idl
constexpr std::array kArmStateFields{kSchema,
                                     name_of("arm"),
                                     term("term"),
                                     count("sequence_number"),
                                     stamp("stamp_ns"),
                                     choice("mode", msg::ArmMode::ARM_OBSERVED),
                                     positions("q", msg::MAX_JOINTS),
                                     velocities("qd", msg::MAX_JOINTS),
                                     number("speed_scaling", 0.0, 1.0),
                                     time("tracking_delay"),
                                     text("carried"),
                                     count("command_sequence_number"),
                                     time("command_age"),
                                     term("newest_term"),
                                     name_of("planner"),
                                     count("stale_rejected"),
                                     nested("cause", kCause),
                                     positions("outside", msg::MAX_JOINTS),
                                     positions("outside_lower", msg::MAX_JOINTS),
                                     positions("outside_upper", msg::MAX_JOINTS)};
constexpr StructRule kArmState{"ArmState", kArmStateFields};
/// No arm has a longer control period than 10 s; its driver bounds the period by `command_timeout`.
constexpr std::array kArmCommandFields{kSchema,
                                       name_of("arm"),
                                       term("term"),
                                       count("sequence_number"),
                                       stamp("stamp_ns"),
                                       name_of("node"),
                                       number("period", 0.0, 10.0),
                                       positions("q", msg::MAX_JOINTS),
                                       velocities("qd", msg::MAX_JOINTS)};
constexpr StructRule kArmCommand{"ArmCommand", kArmCommandFields};
constexpr std::array kDeviceRequestFields{kSchema,
                                          name_of("client"),
                                          count("request_id"),
                                          name_of("arm"),
                                          choice("order", msg::DeviceOrder::DEVICE_PLACE_JOINT),
                                          name_of("name"),
                                          position("value"),
                                          number("width", -1.0, 100.0),
                                          number("force", -1.0, 1e6)};
constexpr StructRule kDeviceRequest{"DeviceRequest", kDeviceRequestFields};
constexpr std::array kDeviceCommandFields{kSchema,
                                          name_of("arm"),
                                          count("session"),
                                          count("sequence_number"),
                                          choice("task", msg::DeviceTask::DEVICE_STOP),
                                          number("valid_for", 0.0, 10.0),
                                          positions("q", msg::MAX_JOINTS),
                                          velocities("qd", msg::MAX_JOINTS),
                                          text("reason")};
constexpr StructRule kDeviceCommand{"DeviceCommand", kDeviceCommandFields};
constexpr std::array kDeviceStateFields{kSchema,
                                        name_of("arm"),
                                        count("session"),
                                        count("sequence_number"),
                                        number("age", 0.0, kLongestTime),
                                        positions("q", msg::MAX_JOINTS),
                                        velocities("qd", msg::MAX_JOINTS),
                                        number("speed_scaling", 0.0, 1.0),
                                        number("tracking_delay", 0.0, 1.0),
                                        choice("mode", msg::DeviceMode::DEVICE_FAILED),
                                        text("text")};
constexpr StructRule kDeviceState{"DeviceState", kDeviceStateFields};
constexpr std::array kDeviceReplyFields{kSchema,        name_of("client"), count("request_id"),
                                        name_of("arm"), boolean("done"),   nested("cause", kCause)};
constexpr StructRule kDeviceReply{"DeviceReply", kDeviceReplyFields};
constexpr std::array kSignalFields{name_of("name"), choice("kind", msg::SignalKind::SIGNAL_ANALOG_OUTPUT),
                                   boolean("known"), position("value")};
constexpr StructRule kSignal{"Signal", kSignalFields};
constexpr std::array kToolStateFields{kSchema,
                                      name_of("arm"),
                                      count("sequence_number"),
                                      stamp("stamp_ns"),
                                      boolean("has_gripper"),
                                      boolean("moving"),
                                      number("width", -1.0, 100.0),
                                      name_of("grasping"),
                                      name_of("holding"),
                                      name_of("releasing"),
                                      list("signals", kSignal, 64)};
constexpr StructRule kToolState{"ToolState", kToolStateFields};

// goal.idl
constexpr std::array kToolGoalFields{nested("X_WT", kPose), choice("free_rotation", msg::FreeRotation::FREE_ALL),
                                     number("position_tolerance", 0.0, kLargestPosition),
                                     number("orientation_tolerance", 0.0, 10.0)};
constexpr StructRule kToolGoal{"ToolGoal", kToolGoalFields};
constexpr std::uint32_t kMostTrajectoryPoints = 4096;
constexpr std::uint32_t kMostTrajectoryValues = 32768;  ///< of each kind: the sample stays below kLarge
constexpr std::array kTrajectoryFields{
    FieldRule{.name = "time", .kind = kDoubles, .low = 0.0, .high = kLongestTime, .most = kMostTrajectoryPoints},
    positions("q", kMostTrajectoryValues), velocities("qd", kMostTrajectoryValues),
    positions("qdd", kMostTrajectoryValues),
    FieldRule{
        .name = "path_tolerance", .kind = kDoubles, .low = 0.0, .high = kLargestPosition, .most = msg::MAX_JOINTS}};
constexpr StructRule kTrajectory{"TimedTrajectory", kTrajectoryFields};
constexpr std::array kGoalFields{kSchema,
                                 name_of("arm"),
                                 name_of("goal"),
                                 count("sequence_number"),
                                 stamp("stamp_ns"),
                                 name_of("client"),
                                 boolean("cancel"),
                                 choice("kind", msg::GoalKind::GOAL_TRAJECTORY),
                                 positions("q", msg::MAX_JOINTS),
                                 name_of("named"),
                                 nested("tool", kToolGoal),
                                 nested("trajectory", kTrajectory),
                                 time("time_limit")};
constexpr StructRule kGoal{"Goal", kGoalFields};
constexpr std::array kGoalStatusFields{kSchema,
                                       name_of("arm"),
                                       name_of("goal"),
                                       term("term"),
                                       count("sequence_number"),
                                       stamp("stamp_ns"),
                                       name_of("node"),
                                       choice("state", msg::GoalState::GOAL_TIMED_OUT),
                                       nested("cause", kCause),
                                       boolean("has_binding"),
                                       name_of("binding_own", kLongestBody),
                                       name_of("binding_other", kLongestBody),
                                       position("binding_distance"),
                                       text("recovery_action"),
                                       time("blocked_duration"),
                                       uint32("priority"),
                                       position("distance_to_goal"),
                                       time("elapsed"),
                                       text("note"),
                                       boolean("has_tool"),
                                       nested("tool", kToolGoal),
                                       position("position_error"),
                                       position("orientation_error"),
                                       boolean("has_nearest"),
                                       nested("X_WT_nearest", kPose),
                                       position("nearest_angle"),
                                       positions("q_goal", msg::MAX_JOINTS),
                                       time("trajectory_time"),
                                       number("trajectory_rate", 0.0, 1.0)};
constexpr StructRule kGoalStatus{"GoalStatus", kGoalStatusFields};
constexpr std::array kCoupledPlanFields{
    kSchema,          name_of("arm"),           stamp("stamp_ns"),     name_of("node"),
    uint32("number"), names("arms", kMostArms), uint32("points", 1e5), positions("q", 1U << 19U)};
constexpr StructRule kCoupledPlan{"CoupledPlan", kCoupledPlanFields};
constexpr std::array kCoupledPlanProgressFields{
    kSchema,          name_of("arm"),           stamp("stamp_ns"), name_of("node"), name_of("proposer"),
    uint32("number"), int32("reached", -1, 1e5)};
constexpr StructRule kCoupledPlanProgress{"CoupledPlanProgress", kCoupledPlanProgressFields};

// health.idl
constexpr std::array kLeaseFields{name_of("arm"), name_of("planner"), term("term")};
constexpr StructRule kLease{"ArmLease", kLeaseFields};
constexpr std::array kModeNumberFields{term("term"), count("sequence_number")};
constexpr StructRule kModeNumber{"ModeNumber", kModeNumberFields};
constexpr std::array kRefusalFields{nested("cause", kCause), name_of("topic"), name_of("sender"), name_of("address"),
                                    count("count")};
constexpr StructRule kRefusal{"Refusal", kRefusalFields};
constexpr std::array kHeartbeatFields{kSchema,
                                      name_of("node"),
                                      choice("kind", msg::NodeKind::NODE_OTHER),
                                      name_of("subject"),
                                      name_of("host"),
                                      process_id("pid"),
                                      choice("state", msg::NodeState::NODE_FAILED),
                                      nested("cause", kCause),
                                      term("term"),
                                      nested("lease", kLease),
                                      nested("acknowledged_mode", kModeNumber),
                                      count("newest_event"),
                                      count("sequence_number"),
                                      stamp("stamp_ns"),
                                      count("ticks"),
                                      number("tick_p50_us", 0.0, 1e15),
                                      number("tick_p99_us", 0.0, 1e15),
                                      number("tick_max_us", 0.0, 1e15),
                                      number("lateness_max_us", 0.0, 1e15),
                                      time("oldest_input_age"),
                                      name_of("oldest_input", kLongestBody),
                                      count("rss_bytes"),
                                      date("keys_expire_unix_ms"),
                                      list("refusals", kRefusal, 4)};
constexpr StructRule kHeartbeat{"Heartbeat", kHeartbeatFields};
constexpr std::array kHostAgeFields{
    name_of("host"), FieldRule{.name = "age", .kind = kFloat, .low = -kLongestTime, .high = kLongestTime}};
constexpr StructRule kHostAge{"HostAge", kHostAgeFields};
constexpr std::array kReachabilityFields{kSchema, name_of("host"), count("sequence_number"), stamp("stamp_ns"),
                                         list("heard", kHostAge, kMostArms)};
constexpr StructRule kReachability{"Reachability", kReachabilityFields};
constexpr std::array kProcessEventFields{kSchema,
                                         name_of("process", kLongestBody),
                                         name_of("host"),
                                         name_of("name"),
                                         name_of("node"),
                                         process_id("pid"),
                                         choice("kind", msg::ProcessEventKind::PROCESS_EXITED),
                                         boolean("wanted"),
                                         int32("exit_code", -1, 255),
                                         int32("signal_number", 0, 64),
                                         uint32("restarts"),
                                         count("sequence_number"),
                                         stamp("stamp_ns"),
                                         nested("cause", kCause)};
constexpr StructRule kProcessEvent{"ProcessEvent", kProcessEventFields};
constexpr std::array kLostArmFields{name_of("arm"), stamp("stamp_ns"), positions("q", msg::MAX_JOINTS),
                                    velocities("qd", msg::MAX_JOINTS), time("braking_delay_bound")};
constexpr StructRule kLostArm{"LostArm", kLostArmFields};
constexpr std::array kArmOrderFields{name_of("arm"), kMode, kOrdered, nested("cause", kCause)};
constexpr StructRule kArmOrder{"ArmOrder", kArmOrderFields};
constexpr FieldRule kSpeed = number("speed", 0.01, 1.0);
constexpr std::array kArmSpeedFields{name_of("arm"), kSpeed};
constexpr StructRule kArmSpeed{"ArmSpeed", kArmSpeedFields};
constexpr std::array kCellModeFields{kSchema,
                                     term("term"),
                                     count("sequence_number"),
                                     stamp("stamp_ns"),
                                     name_of("node"),
                                     kMode,
                                     kOrdered,
                                     nested("cause", kCause),
                                     list("arms", kArmOrder, kMostArms),
                                     kSpeed,
                                     list("speeds", kArmSpeed, kMostArms),
                                     list("lost_arms", kLostArm, kMostArms),
                                     list("leases", kLease, kMostArms)};
constexpr StructRule kCellMode{"CellMode", kCellModeFields};
constexpr std::array kFaultFields{kSchema,
                                  name_of("id"),
                                  term("term"),
                                  count("sequence_number"),
                                  stamp("stamp_ns"),
                                  choice("severity", msg::Severity::SEVERITY_CRITICAL),
                                  nested("cause", kCause),
                                  stamp("since_ns"),
                                  date("since_unix_ms"),
                                  time("detection_latency_bound"),
                                  boolean("cleared"),
                                  stamp("cleared_ns")};
constexpr StructRule kFault{"Fault", kFaultFields};

// world.idl
constexpr std::array kShapeFields{
    choice("kind", msg::ShapeKind::SHAPE_POINTS),
    nested("dimensions", kPoint),
    nested("X_OS", kPose),
    list("vertices", kPoint, 4096),
    FieldRule{.name = "face_sizes", .kind = kUint32s, .low = 0, .high = 4096, .most = 8192},
    FieldRule{.name = "face_corners", .kind = kUint32s, .low = 0, .high = 4096, .most = 32768},
    positions("points", 3 * kMostCloudPoints)};
constexpr StructRule kShape{"PlacedShape", kShapeFields};
constexpr std::array kMotionFields{choice("kind", msg::MotionKind::MOTION_DYNAMIC),
                                   list("poses_W", kPose, 4096),
                                   position("speed"),
                                   boolean("loop"),
                                   nested("centre_W", kPoint),
                                   nested("direction_W", kPoint),
                                   position("angular_speed"),
                                   boolean("turn_with_motion"),
                                   position("amplitude"),
                                   number("period", -kLongestTime, kLongestTime),
                                   position("phase"),
                                   position("length"),
                                   number("mass", -1e9, 1e9),
                                   position("friction"),
                                   position("rolling_friction"),
                                   position("restitution"),
                                   nested("initial_velocity", kTwist)};
constexpr StructRule kMotion{"Motion", kMotionFields};
constexpr std::array kObstacleFields{name_of("name"),           list("shapes", kShape, 256), nested("X_WO", kPose),
                                     nested("motion", kMotion), name_of("attached_to"),      nested("X_TO", kPose)};
constexpr StructRule kObstacle{"Obstacle", kObstacleFields};
constexpr std::array kObstacleShapesFields{kSchema,          name_of("name"),   term("term"),
                                           count("edition"), stamp("stamp_ns"), nested("obstacle", kObstacle)};
constexpr StructRule kObstacleShapes{"ObstacleShapes", kObstacleShapesFields};
constexpr std::array kObstacleStateFields{name_of("name"), nested("X_WO", kPose), nested("velocity", kTwist)};
constexpr StructRule kObstacleState{"ObstacleState", kObstacleStateFields};
constexpr std::array kObstacleStatesFields{kSchema,
                                           term("term"),
                                           count("edition"),
                                           count("sequence_number"),
                                           stamp("stamp_ns"),
                                           time("time"),
                                           list("states", kObstacleState, kMostObstacles)};
constexpr StructRule kObstacleStates{"ObstacleStates", kObstacleStatesFields};
constexpr std::array kEditRequestFields{kSchema,
                                        name_of("client"),
                                        count("request_id"),
                                        choice("kind", msg::EditKind::EDIT_REPLACE),
                                        name_of("name"),
                                        nested("obstacle", kObstacle),
                                        nested("X_WO", kPose),
                                        name_of("arm")};
constexpr StructRule kEditRequest{"WorldEditRequest", kEditRequestFields};
constexpr std::array kEditReplyFields{kSchema,         name_of("client"),       count("request_id"),
                                      boolean("done"), nested("cause", kCause), count("edition")};
constexpr StructRule kEditReply{"WorldEditReply", kEditReplyFields};
constexpr std::array kRayFields{nested("origin_L", kPoint), nested("direction_L", kPoint), position("distance"),
                                boolean("hit")};
constexpr StructRule kRay{"RangeRay", kRayFields};
constexpr std::array kRangeScanFields{kSchema,
                                      name_of("sensor", kLongestBody),
                                      name_of("arm"),
                                      name_of("link", kLongestBody),
                                      count("sequence_number"),
                                      stamp("stamp_ns"),
                                      position("min_range"),
                                      position("max_range"),
                                      list("rays", kRay, 4096)};
constexpr StructRule kRangeScan{"RangeScan", kRangeScanFields};
constexpr std::array kSeparationFields{position("distance"), choice("kind", msg::ContactKind::CONTACT_ARM_SELF),
                                       name_of("a", kLongestBody), name_of("b", kLongestBody), time("time")};
constexpr StructRule kSeparation{"Separation", kSeparationFields};
constexpr std::array kKindSummaryFields{choice("kind", msg::ContactKind::CONTACT_ARM_SELF), boolean("has_smallest"),
                                        count("contacts"), nested("smallest", kSeparation)};
constexpr StructRule kKindSummary{"KindSummary", kKindSummaryFields};
constexpr std::array kContactReportFields{kSchema,
                                          term("term"),
                                          count("sequence_number"),
                                          stamp("stamp_ns"),
                                          boolean("running"),
                                          time("time"),
                                          count("contacts"),
                                          boolean("has_smallest"),
                                          nested("smallest", kSeparation),
                                          list("kinds", kKindSummary, 16),
                                          list("events", kSeparation, 4096)};
constexpr StructRule kContactReport{"ContactReport", kContactReportFields};

// planner.idl
constexpr std::uint32_t kMostPoints = 100000;
constexpr std::uint32_t kMostWords = 1U << 18U;
/// Lists that have none or one element.
constexpr std::uint32_t kFew = 4;
constexpr FieldRule words(std::string_view name, std::uint32_t most) {
  return {.name = name, .kind = kUint32s, .low = 0, .high = 4294967295.0, .most = most};
}
constexpr FieldRule index(std::string_view name, std::uint32_t most) {
  return uint32(name, most - 1.0);
}
constexpr FieldRule indices(std::string_view name, std::uint32_t most) {
  return {.name = name, .kind = kUint32s, .low = 0, .high = most - 1.0, .most = most};
}
constexpr std::array kTickFeedbackFields{positions("q", msg::MAX_JOINTS),
                                         velocities("qd", msg::MAX_JOINTS),
                                         time("age"),
                                         boolean("follows"),
                                         count("setpoint"),
                                         time("setpoint_age"),
                                         time("tracking_delay"),
                                         number("speed_scaling", 0.0, 1.0)};
constexpr StructRule kTickFeedback{"TickFeedback", kTickFeedbackFields};
constexpr std::array kTickArmFields{index("arm", kMostArms),
                                    boolean("known"),
                                    boolean("plans"),
                                    boolean("foreign"),
                                    boolean("has_goal"),
                                    positions("q", msg::MAX_JOINTS),
                                    velocities("qd", msg::MAX_JOINTS),
                                    time("age"),
                                    positions("q_goal", msg::MAX_JOINTS),
                                    uint32("priority"),
                                    positions("position_uncertainty", msg::MAX_JOINTS),
                                    int32("proposer", -1, kMostArms - 1.0),
                                    uint32("number"),
                                    int32("reached", -1, 1e5),
                                    number("speed", 0.0, 1.0)};
constexpr StructRule kTickArm{"TickArm", kTickArmFields};
constexpr std::array kTickPlanFields{index("arm", kMostArms), uint32("number"), indices("arms", kMostArms),
                                     uint32("points", kMostPoints), positions("q", 1U << 19U)};
constexpr StructRule kTickPlan{"TickPlan", kTickPlanFields};
constexpr std::array kTickObstacleFields{index("obstacle", kMostObstacles), positions("X_WO", 12),
                                         nested("velocity", kTwist)};
constexpr StructRule kTickObstacle{"TickObstacle", kTickObstacleFields};
constexpr std::array kTickScanFields{index("sensor", 4096), index("link", 4096), positions("q", msg::MAX_JOINTS),
                                     list("rays", kRay, 4096)};
constexpr StructRule kTickScan{"TickScan", kTickScanFields};
constexpr std::array kTickManoeuvreFields{choice("kind", msg::TickManoeuvreKind::MANOEUVRE_EVADE), uint32("seed_high"),
                                          uint32("seed_low"), positions("q", msg::MAX_JOINTS), time("time_limit")};
constexpr StructRule kTickManoeuvre{"TickManoeuvre", kTickManoeuvreFields};
constexpr std::array kTickRouteFields{choice("kind", msg::TickRouteKind::ROUTE_NONE), indices("joints", kMostArms),
                                      uint32("points", kMostPoints), positions("q", 1U << 19U)};
constexpr StructRule kTickRoute{"TickRoute", kTickRouteFields};
constexpr std::array kPlannerTickFields{
    kSchema,
    name_of("arm"),
    name_of("node"),
    count("sequence_number"),
    stamp("stamp_ns"),
    boolean("snapshot"),
    name_of("program"),
    words("options", 64),
    words("memory", kMostWords),
    time("missed"),
    boolean("drops_setpoint"),
    boolean("has_obstacles"),
    list("obstacles", kObstacle, kMostObstacles),
    positions("obstacle_frames", 1U << 18U),
    boolean("changes_goal"),
    positions("q_goal", msg::MAX_JOINTS),
    list("trajectory", kTrajectory, kFew),
    time("trajectory_time"),
    list("scans", kTickScan, 4096),
    boolean("planned"),
    nested("own", kTickFeedback),
    list("arms", kTickArm, kMostArms),
    list("proposals", kTickPlan, kMostArms),
    list("obstacle_states", kTickObstacle, kMostObstacles),
    FieldRule{
        .name = "obstacle_ages", .kind = kDoubles, .low = -kLongestTime, .high = kLongestTime, .most = kMostObstacles},
    boolean("hold"),
    number("speed", 0.0, 1.0),
    boolean("commands"),
    count("number"),
    list("rollout", kTickManoeuvre, kFew),
    list("route", kTickRoute, kFew),
    list("coupled_plan", kTickRoute, kFew),
    positions("q", msg::MAX_JOINTS),
    velocities("qd", msg::MAX_JOINTS)};
constexpr StructRule kPlannerTick{"PlannerTick", kPlannerTickFields};
constexpr std::array kPlannedMotionFields{kSchema,
                                          name_of("arm"),
                                          name_of("node"),
                                          stamp("stamp_ns"),
                                          positions("way", kMostMotionPoints* msg::MAX_JOINTS),
                                          positions("foreseen", kMostMotionPoints* msg::MAX_JOINTS),
                                          time("foreseen_period")};
constexpr StructRule kPlannedMotion{"PlannedMotion", kPlannedMotionFields};

// recorder.idl
constexpr std::array kRecorderRequestFields{kSchema, name_of("client"), count("request_id")};
constexpr StructRule kRecorderRequest{"RecorderRequest", kRecorderRequestFields};
constexpr std::array kRecorderReplyFields{kSchema,         name_of("client"), count("request_id"),    name_of("host"),
                                          boolean("done"), text("file"),      nested("cause", kCause)};
constexpr StructRule kRecorderReply{"RecorderReply", kRecorderReplyFields};

// supervisor.idl
/// The supervisor refuses a speed beyond the limits with a sentence, so that the client gets a reply.
constexpr std::array kSupervisorRequestFields{kSchema,
                                              name_of("client"),
                                              count("request_id"),
                                              choice("kind", msg::RequestKind::REQUEST_SLOWER),
                                              names("arms", kMostArms),
                                              position("speed")};
constexpr StructRule kSupervisorRequest{"SupervisorRequest", kSupervisorRequestFields};
constexpr std::array kArmStatusFields{name_of("arm"),
                                      kMode,
                                      kSpeed,
                                      boolean("driver_alive"),
                                      boolean("planner_alive"),
                                      name_of("planner"),
                                      term("term"),
                                      name_of("standby"),
                                      nested("state", kArmState),
                                      time("state_age"),
                                      boolean("has_goal"),
                                      nested("goal", kGoalStatus),
                                      time("goal_age"),
                                      nested("waiting_for", kCause)};
constexpr StructRule kArmStatus{"ArmStatus", kArmStatusFields};
constexpr std::array kNodeStatusFields{nested("heartbeat", kHeartbeat), time("age"), boolean("alive")};
constexpr StructRule kNodeStatus{"NodeStatus", kNodeStatusFields};
constexpr std::array kHostStatusFields{name_of("host"), boolean("agent_alive"), time("age"),
                                       list("processes", kProcessEvent, 4096)};
constexpr StructRule kHostStatus{"HostStatus", kHostStatusFields};
constexpr std::array kObstacleStatusFields{name_of("name"),
                                           text("shape"),
                                           text("motion"),
                                           name_of("attached_to"),
                                           nested("X_WO", kPose),
                                           nested("velocity", kTwist),
                                           time("age")};
constexpr StructRule kObstacleStatus{"ObstacleStatus", kObstacleStatusFields};
constexpr std::array kCellStatusFields{name_of("cell"),
                                       nested("mode", kCellMode),
                                       name_of("supervisor"),
                                       name_of("standby"),
                                       time("uptime"),
                                       list("arms", kArmStatus, kMostArms),
                                       list("nodes", kNodeStatus, 4096),
                                       list("hosts", kHostStatus, kMostArms),
                                       list("faults", kFault, 4096),
                                       boolean("has_contact_report"),
                                       nested("contact_report", kContactReport),
                                       time("contact_report_age"),
                                       list("obstacles", kObstacleStatus, kMostObstacles)};
constexpr StructRule kCellStatus{"CellStatus", kCellStatusFields};
constexpr std::array kSupervisorReplyFields{kSchema,         name_of("client"),       count("request_id"),
                                            boolean("done"), nested("cause", kCause), nested("status", kCellStatus)};
constexpr StructRule kSupervisorReply{"SupervisorReply", kSupervisorReplyFields};

constexpr std::uint32_t kSmall = 1U << 16U;
constexpr std::uint32_t kLarge = 1U << 20U;
constexpr std::uint32_t kLargest = 1U << 22U;

// Most samples a second: ten times what the fastest configuration sends, bursts of late joiners included.
constexpr std::array kRules{TopicRule{kArmState, kSmall, 5000},
                            TopicRule{kArmCommand, kSmall, 5000},
                            TopicRule{kDeviceRequest, kSmall, 500},
                            TopicRule{kDeviceCommand, kSmall, 5000},
                            TopicRule{kDeviceState, kSmall, 5000},
                            TopicRule{kDeviceReply, kSmall, 2000},
                            TopicRule{kToolState, kSmall, 20000},
                            TopicRule{kObstacleShapes, kLargest, 20000},
                            TopicRule{kObstacleStates, kLarge, 5000},
                            TopicRule{kEditRequest, kLargest, 1000},
                            TopicRule{kEditReply, kSmall, 5000},
                            TopicRule{kRangeScan, kLarge, 50000},
                            TopicRule{kContactReport, kLarge, 1000},
                            TopicRule{kGoal, kLarge, 5000},
                            TopicRule{kGoalStatus, kSmall, 5000},
                            TopicRule{kCoupledPlan, kLargest, 1000},
                            TopicRule{kCoupledPlanProgress, kSmall, 5000},
                            TopicRule{kHeartbeat, kSmall, 2000},
                            TopicRule{kReachability, kSmall, 2000},
                            TopicRule{kProcessEvent, kSmall, 10000},
                            TopicRule{kCellMode, kLarge, 2000},
                            TopicRule{kFault, kSmall, 10000},
                            TopicRule{kSupervisorRequest, kSmall, 500},
                            TopicRule{kSupervisorReply, kLargest, 2000},
                            TopicRule{kRecorderRequest, kSmall, 500},
                            TopicRule{kRecorderReply, kSmall, 2000},
                            TopicRule{kPlannerTick, kLargest, 5000},
                            TopicRule{kPlannedMotion, kSmall, 5000}};

}  // namespace

const TopicRule* topic_rule(std::string_view type) {
  const auto found =
      std::find_if(kRules.begin(), kRules.end(), [&](const auto& rule) { return rule.sample.name == type; });
  return found == kRules.end() ? nullptr : &*found;
}

std::span<const TopicRule> topic_rules() {
  return kRules;
}

}  // namespace hecaton::bus
