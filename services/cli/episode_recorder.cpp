#include "services/cli/episode_recorder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/model/kinematics.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/program.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton::services::cli {
namespace {

using planner::Pose;

constexpr double kLineInterval = 0.05;      // [s]
constexpr std::size_t kMostCentres = 1000;  ///< of a cloud: each moment has them

/// A point to a tenth of a millimetre.
Json point_json(const Eigen::Vector3d& p) {
  const auto rounded = [](double x) { return std::round(1e4 * x) / 1e4; };
  return {rounded(p.x()), rounded(p.y()), rounded(p.z())};
}

/// A shape by its corners, or by its axis and radius.
struct ShapeJson {
  const Pose& X_WS;

  [[nodiscard]] Json round(const char* kind, double radius, double half_length) const {
    const Eigen::Vector3d half(0.0, 0.0, half_length);
    return {{"kind", kind}, {"radius", radius}, {"from", point_json(X_WS * half)}, {"to", point_json(X_WS * -half)}};
  }
  Json operator()(const world::Sphere& sphere) const { return round("capsule", sphere.radius, 0.0); }
  Json operator()(const world::Capsule& capsule) const { return round("capsule", capsule.radius, capsule.half_length); }
  Json operator()(const world::Cylinder& cylinder) const {
    return round("cylinder", cylinder.radius, cylinder.half_length);
  }
  Json operator()(const world::Box& box) const {
    Json corners = Json::array();
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
      corners.push_back(point_json(X_WS * box.half_extents.cwiseProduct(sign)));
    }
    return {{"kind", "box"}, {"corners", std::move(corners)}};
  }
  Json operator()(const world::Convex& convex) const {
    Json corners = Json::array();
    for (const Eigen::Vector3d& vertex : convex.hull->vertices) corners.push_back(point_json(X_WS * vertex));
    return {{"kind", "convex"}, {"corners", std::move(corners)}};
  }
  Json operator()(const world::Points& points) const {
    Json centres = Json::array();
    const auto all = points.cloud->points();
    const std::size_t every = (all.size() + kMostCentres - 1) / kMostCentres;
    for (std::size_t i = 0; i < all.size(); i += every) centres.push_back(point_json(X_WS * all[i].cast<double>()));
    return {{"kind", "points"}, {"radius", points.cloud->radius()}, {"centres", std::move(centres)}};
  }
};

Json shape_json(const world::Shape& shape, const Pose& X_WS) {
  return std::visit(ShapeJson{X_WS}, shape);
}

planner::Kinematics kinematics_of(const planner::Arm& arm, const planner::JointVector& q) {
  planner::Kinematics kinematics;
  planner::forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
  return kinematics;
}

Json arm_json(const planner::Arm& arm, const planner::JointVector& q, const planner::JointVector& goal) {
  const planner::Kinematics kinematics = kinematics_of(arm, q);
  Json shapes = Json::array();
  for (const planner::LinkGeometry& geometry : arm.model->geometry) {
    shapes.push_back(shape_json(geometry.shape, kinematics.X_WL[geometry.link] * geometry.X_LS));
  }
  return {{"name", arm.name},
          {"tool", point_json(kinematics.X_WT.translation())},
          {"goal", point_json(kinematics_of(arm, goal).X_WT.translation())},
          {"shapes", std::move(shapes)}};
}

Pose pose_of(const world::Obstacle& obstacle, const planner::EpisodeMoment& moment) {
  if (obstacle.attachment) {
    const auto& arms = moment.cell.arms;
    const auto carrier = std::find_if(
        arms.begin(), arms.end(), [&](const auto& planned) { return planned.arm.name == obstacle.attachment->arm; });
    const auto index = static_cast<std::size_t>(carrier - arms.begin());
    return kinematics_of(carrier->arm, moment.measured[index]).X_WT * obstacle.attachment->X_TO;
  }
  return world::motion_at(obstacle, world::is_scripted(obstacle.motion) ? moment.world_time : 0.0).X_WO;
}

Json moment_json(const planner::EpisodeMoment& moment) {
  Json arms = Json::array();
  for (std::size_t i = 0; i < moment.cell.arms.size(); ++i) {
    arms.push_back(arm_json(moment.cell.arms[i].arm, moment.measured[i], moment.goals[i]));
  }
  Json obstacles = Json::array();
  for (const world::Obstacle& obstacle : moment.cell.scene.obstacles) {
    const Pose X_WO = pose_of(obstacle, moment);
    Json shapes = Json::array();
    for (const world::PlacedShape& placed : obstacle.shapes) {
      shapes.push_back(shape_json(placed.shape, X_WO * placed.X_BS));
    }
    obstacles.push_back({{"name", obstacle.name}, {"shapes", std::move(shapes)}});
  }
  return {
      {"time", std::round(1e6 * moment.time) / 1e6}, {"arms", std::move(arms)}, {"obstacles", std::move(obstacles)}};
}

}  // namespace

EpisodeRecorder::EpisodeRecorder(std::string path) : path_(std::move(path)), file_(path_) {
  if (!file_) throw Failure(ExitCode::kBadInput, "--record: " + path_ + " cannot be written");
}

void EpisodeRecorder::record(const planner::EpisodeMoment& moment) {
  constexpr double kRounding = 1e-9;  // [s]
  if (moment.time < due_ - kRounding) return;
  due_ += kLineInterval;
  file_ << moment_json(moment).dump() << '\n';
}

void EpisodeRecorder::finish() {
  file_.close();
  if (!file_) throw Failure(ExitCode::kBadInput, "--record: " + path_ + " cannot be written");
}

}  // namespace hecaton::services::cli
