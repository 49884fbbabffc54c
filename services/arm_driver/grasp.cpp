#include "services/arm_driver/grasp.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "planner/collision/exact_distance.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/model/outside_joints.hpp"

namespace hecaton::services {
namespace {

constexpr int kSteps = 200;  ///< places of the fingers on their way that are compared

/// The fingers of an arm that stands.
class Fingers {
 public:
  Fingers(const planner::Arm& arm, const planner::JointVector& q, const std::vector<double>& from,
          const std::vector<double>& to)
      : model_(*arm.model), from_(from), to_(to) {
    planner::Kinematics kinematics;
    planner::forward_kinematics(model_, arm.X_WB, q, kinematics);
    X_WT_ = kinematics.X_WT;
  }

  /// Links that touch the obstacle at this share of their way.
  [[nodiscard]] std::set<std::string> touching(const world::Obstacle& obstacle, double share) const {
    std::set<std::string> links;
    const std::vector<planner::Pose> places = planner::outside_places(model_, at(share));
    for (std::size_t i = 0; i < places.size(); ++i) {
      const planner::OutsideBody& body = model_.outside->bodies[i];
      const planner::Pose X_WS = X_WT_ * places[i] * body.X_LS;
      if (moves(body) && touches(obstacle, body.shape, X_WS)) links.insert(body.link);
    }
    return links;
  }
  /// Links that move.
  [[nodiscard]] std::size_t count() const {
    std::set<std::string> links;
    for (const planner::OutsideBody& body : model_.outside->bodies) {
      if (moves(body)) links.insert(body.link);
    }
    return links.size();
  }
  [[nodiscard]] std::vector<double> at(double share) const {
    std::vector<double> positions = from_;
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += share * (to_[i] - from_[i]);
    return positions;
  }
  /// False: the obstacle is farther than the fingers reach.
  [[nodiscard]] bool is_near(const world::Obstacle& obstacle) const {
    constexpr double kFar = 1.0;  // from the tool [m]
    return std::any_of(obstacle.shapes.begin(), obstacle.shapes.end(), [&](const world::PlacedShape& placed) {
      const world::BoundingSphere ball = world::bounding_sphere(placed.shape);
      return (obstacle.X_WO * placed.X_BS * ball.centre - X_WT_.translation()).norm() < ball.radius + kFar;
    });
  }

 private:
  [[nodiscard]] bool moves(const planner::OutsideBody& body) const {
    return std::any_of(body.steps.begin(), body.steps.end(), [&](const planner::MechanismStep& step) {
      return step.moves && from_[static_cast<std::size_t>(step.joint)] != to_[static_cast<std::size_t>(step.joint)];
    });
  }
  /// Never true for points, which no gripper can hold.
  static bool touches(const world::Obstacle& obstacle, const world::Shape& shape, const planner::Pose& X_WS) {
    return std::any_of(obstacle.shapes.begin(), obstacle.shapes.end(), [&](const world::PlacedShape& placed) {
      if (std::holds_alternative<world::Points>(placed.shape)) return false;
      return planner::shape_distance(shape, X_WS, placed.shape, obstacle.X_WO * placed.X_BS).distance <= 0.0;
    });
  }

  const planner::RobotModel& model_;
  const std::vector<double>& from_;
  const std::vector<double>& to_;
  planner::Pose X_WT_;
};

}  // namespace

std::optional<Grasp> find_grasp(const planner::Arm& arm, const planner::JointVector& q, const std::vector<double>& from,
                                const std::vector<double>& to, std::span<const world::Obstacle> obstacles) {
  if (!arm.model->outside || arm.model->outside->bodies.empty()) return std::nullopt;
  const Fingers fingers(arm, q, from, to);
  const std::size_t needed = std::min<std::size_t>(2, fingers.count());
  if (needed == 0) return std::nullopt;
  std::optional<std::pair<int, std::string>> first;  // step before the touch, and the obstacle
  for (const world::Obstacle& obstacle : obstacles) {
    if (obstacle.attachment || !fingers.is_near(obstacle)) continue;
    std::set<std::string> touched;
    std::optional<int> stop;
    for (int step = 0; step <= kSteps && touched.size() < needed; ++step) {
      const auto now = fingers.touching(obstacle, static_cast<double>(step) / kSteps);
      if (!now.empty() && !stop) stop = std::max(0, step - 1);
      touched.insert(now.begin(), now.end());
    }
    if (touched.size() >= needed && (!first || *stop < first->first)) first = {*stop, obstacle.name};
  }
  if (!first) return std::nullopt;
  return Grasp{first->second, fingers.at(static_cast<double>(first->first) / kSteps)};
}

}  // namespace hecaton::services
