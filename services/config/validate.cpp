#include "services/config/validate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "planner/model/inverse_kinematics.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "services/config/findings.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

// The centre and two rings of eight points at three heights, in W, for an arm with its base at X_WB.
std::vector<Eigen::Vector3d> sample_points(const planner::TaskArea& area, const planner::Pose& X_WB) {
  const planner::Pose X_WA = area.frame(X_WB);
  std::vector<Eigen::Vector3d> points;
  for (const double height : {-area.half_height, 0.0, area.half_height}) {
    const Eigen::Vector3d middle = area.centre + Eigen::Vector3d(0.0, 0.0, height);
    points.push_back(X_WA * middle);
    for (const double radius : {0.5 * area.radius, area.radius}) {
      for (int k = 0; k < 8; ++k) {
        const double angle = std::numbers::pi / 4.0 * k;
        points.push_back(X_WA * (middle + radius * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0)));
      }
    }
  }
  return points;
}

bool reaches(const planner::Arm& arm, const Eigen::Vector3d& p_W) {
  planner::IkOptions options;
  options.free_rotation = planner::FreeRotation::kAll;
  options.seeds = 24;
  options.iterations = 100;
  options.position_tolerance = 1e-3;
  planner::Pose X_WT = planner::Pose::Identity();
  X_WT.translation() = p_W;
  return planner::inverse_kinematics(arm, X_WT, arm.home(), options).has_value();
}

/// True if the tool lies in the task area in one of many random postures.
bool enters(const planner::Arm& arm, const planner::TaskArea& area) {
  constexpr int kPostures = 5000;
  std::mt19937_64 random(1);
  planner::Kinematics kinematics;
  const planner::Pose X_AW = area.frame(arm.X_WB).inverse();
  for (int k = 0; k < kPostures; ++k) {
    planner::forward_kinematics(*arm.model, arm.X_WB, planner::random_configuration(arm.limits, random), kinematics);
    const Eigen::Vector3d offset = X_AW * kinematics.X_WT.translation() - area.centre;
    if (offset.head<2>().norm() <= area.radius && std::abs(offset.z()) <= area.half_height) return true;
  }
  return false;
}

void check_reach(const planner::Cell& cell, Findings& findings) {
  if (!cell.tasks.pose_sequence.empty() || !cell.tasks.problem.areas.empty()) return;
  if (cell.tasks.radius <= 0.0) {
    findings.push_back(
        {Severity::kNote,
         "tasks is missing, and the arms have no volume within reach in common: no random goals can be drawn"});
    return;
  }
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    // A tool that stays on a surface reaches few points of any volume.
    const bool on_surface = planner::tool_stays_on_surface(cell.arms[arm].arm);
    if (on_surface && cell.tasks.half_height > 0.0 && enters(cell.arms[arm].arm, cell.tasks)) continue;
    const auto points = sample_points(cell.tasks, cell.arms[arm].arm.X_WB);
    std::size_t reached = 0;
    for (const Eigen::Vector3d& point : points) reached += reaches(cell.arms[arm].arm, point) ? 1U : 0U;
    if (reached == points.size()) continue;
    const std::string arm_reaches = "tasks: " + arm_key(arm) + " (" + cell.arms[arm].arm.name + ") reaches ";
    if (reached == 0) {
      findings.push_back({Severity::kError, arm_reaches + "no part of the task area"});
      continue;
    }
    const std::string share = std::to_string(reached) + " of " + std::to_string(points.size());
    findings.push_back({2 * reached < points.size() ? Severity::kWarning : Severity::kNote,
                        arm_reaches + share + " sample points of the task area"});
  }
}

// Relative. Both rules are of first order, and cell files have rounded decimals.
constexpr double kRelativeTolerance = 0.02;

// The arm knows an obstacle's motion a world step late and reacts in the next tick. Until then it approaches at most at
// the speed that the dampers allow: dₛ must exceed that distance.
void check_latency(const planner::Cell& cell, int arm, Findings& findings) {
  const planner::PlannedArm& planned = cell.arms[arm];
  const planner::DamperParameters& damper = planned.parameters.damper;
  const double latency = cell.timing.world_period + cell.timing.control_period;
  const double speed = std::min(damper.convergence_speed, top_tool_speed(planned.arm));
  const double needed = speed * latency;
  if (damper.security_distance >= needed * (1.0 - kRelativeTolerance)) return;
  warn(findings, arm_key(arm) + ".damper.security_distance = " + number_text(damper.security_distance) +
                     " should be at least " + number_text(needed) + " m: an approach at " + number_text(speed) +
                     " m/s continues for " + number_text(latency * 1e3) + " ms before the arm reacts");
}

// docs/explanation/0001-braking.md: an arm can brake along a damper's line only when k = ξ/(dᵢ − dₛ) ≤ 1/(T + dt).
void check_slope(const planner::Cell& cell, int arm, const char* kind, double security, double influence,
                 Findings& findings) {
  const planner::PlannedArm& planned = cell.arms[arm];
  const double speed = planned.parameters.damper.convergence_speed;
  const double response = planner::longest_stop_time(planned.arm.limits) + cell.timing.control_period;
  const double braking_distance = speed * response;
  if (influence - security >= braking_distance * (1.0 - kRelativeTolerance)) return;
  warn(findings, arm_key(arm) + ".damper." + kind + "influence_distance = " + number_text(influence) +
                     " should be at least " + number_text(security + braking_distance) +
                     " m: braking from convergence_speed = " + number_text(speed) + " m/s, with stops that take " +
                     number_text(response * 1e3) + " ms, needs " + number_text(braking_distance) + " m before " + kind +
                     "security_distance = " + number_text(security));
}

void check_dampers(const planner::Cell& cell, Findings& findings) {
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    const planner::DamperParameters& damper = cell.arms[arm].parameters.damper;
    check_latency(cell, arm, findings);
    check_slope(cell, arm, "", damper.security_distance, damper.influence_distance, findings);
    check_slope(cell, arm, "self_", damper.self_security_distance, damper.self_influence_distance, findings);
  }
}

constexpr double kParallel = 1e-6;  // beams are parallel up to this change of direction
constexpr double kRounding = 1e-4;  // of decimals in cell files [m]

/// The widest gap between two neighbouring parallel beams [m].
double widest_gap(const planner::RangeSensor& sensor) {
  double widest = 0.0;
  for (std::size_t i = 1; i < sensor.rays.size(); ++i) {
    const planner::SensorRay& one = sensor.rays[i - 1];
    const planner::SensorRay& other = sensor.rays[i];
    if ((one.direction_L - other.direction_L).norm() > kParallel) continue;
    widest = std::max(widest, one.direction_L.cross(other.origin_L - one.origin_L).norm());
  }
  return widest;
}

// docs/explanation/0011-sensed-cspace.md: an obstacle protrudes between two beams by at most half of their distance.
void check_sensors(const planner::Cell& cell, Findings& findings) {
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    const planner::PlannedArm& planned = cell.arms[arm];
    const auto sensing_margin = planned.parameters.method->sensing_margin();
    if (!sensing_margin) continue;
    const double margin = sensing_margin->value;
    const planner::RangeSensor* worst = nullptr;
    double needed = margin + kRounding;
    for (const planner::RangeSensor& sensor : planned.sensors) {
      const double of_sensor = 0.5 * widest_gap(sensor) + 3.0 * sensor.noise;
      if (of_sensor <= needed) continue;
      needed = of_sensor;
      worst = &sensor;
    }
    if (worst == nullptr) continue;
    warn(findings, arm_key(arm) + "." + std::string(sensing_margin->key) + " = " + number_text(margin) +
                       " should be at least " + number_text(needed) +
                       " m: half of the distance between two beams of sensor " + worst->name +
                       ", and three times its noise");
  }
}

void check_methods(const planner::Cell& cell, Findings& findings) {
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    if (const auto risk = cell.arms[arm].parameters.method->contact_risk()) warn(findings, arm_key(arm) + "." + *risk);
  }
}

void note_standbys(const CellFile& file, Findings& findings) {
  if (file.hosts.size() < 2) return;
  for (int arm = 0; arm < static_cast<int>(file.arm_hosts.size()); ++arm) {
    if (!file.arm_hosts[arm].standby_host.empty()) continue;
    findings.push_back({Severity::kNote, arm_key(arm) + ".standby_host is missing: after the loss of its planner's "
                                                        "host the arm stands still until that host is back"});
  }
  if (file.supervision.standby_host.empty()) {
    findings.push_back({Severity::kNote,
                        "supervision.standby_host is missing: after the loss of the supervisor's host "
                        "no supervisor monitors the cell until that host is back"});
  }
}

void check_network(const CellFile& file, Findings& findings) {
  if (file.ros2 && file.ros2->domain == file.network.domain) {
    warn(findings, "ros2.domain and network.domain are " + std::to_string(file.ros2->domain) +
                       ": ROS 2 nodes join the domain of the cell; choose another network.domain");
  }
  if (file.hosts.size() < 2 || !file.keystore.empty()) return;
  warn(
      findings,
      "the cell spans hosts and is open: every program on their network can move its arms; security.keystore locks it");
}

}  // namespace

std::string arm_key(int arm) {
  return "arms[" + std::to_string(arm) + "]";
}

const char* name_of(Severity severity) {
  switch (severity) {
    case Severity::kError:
      return "error";
    case Severity::kWarning:
      return "warning";
    case Severity::kNote:
      break;
  }
  return "note";
}

std::vector<Finding> validate(const CellFile& file) {
  Findings findings;
  check_reach(file.cell, findings);
  check_clearances(file.cell, findings);
  check_dampers(file.cell, findings);
  check_obstacles(file.cell, findings);
  check_sensors(file.cell, findings);
  check_methods(file.cell, findings);
  note_standbys(file, findings);
  check_network(file, findings);
  for (const std::string& note : file.notes) findings.push_back({Severity::kNote, note});
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  return findings;
}

}  // namespace hecaton::config
