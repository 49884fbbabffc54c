#include "planner/collision/cell_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planner/model/arm.hpp"

namespace hecaton::planner {
namespace {

Body make_body(int link, int obstacle, bool moves, const world::Shape& shape, const Pose& X_CS) {
  Body body{link, obstacle, moves, shape, X_CS, {}, world::bounding_sphere(shape)};
  body.bound.centre = X_CS * body.bound.centre;
  return body;
}

/// Carried shapes are cut into pieces no longer than this [m].
constexpr double kLongestPiece = 0.12;

/// Cuts a shape along its longest axis; the pieces together are the shape. A long shape has one nearest point only, but
/// when the arm rotates about that point the far end can collide: every piece has a nearest point of its own.
std::vector<world::PlacedShape> pieces(const world::PlacedShape& whole) {
  int axis = 2;
  double half_length = 0.0;
  if (const auto* box = std::get_if<world::Box>(&whole.shape)) half_length = box->half_extents.maxCoeff(&axis);
  if (const auto* capsule = std::get_if<world::Capsule>(&whole.shape)) half_length = capsule->half_length;
  if (const auto* cylinder = std::get_if<world::Cylinder>(&whole.shape)) half_length = cylinder->half_length;
  const int count = std::max(1, static_cast<int>(std::ceil(2.0 * half_length / kLongestPiece)));
  std::vector<world::PlacedShape> cut(count, whole);
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d centre_S = Eigen::Vector3d::Zero();
    centre_S[axis] = half_length * ((2.0 * i + 1.0) / count - 1.0);
    cut[i].X_BS.translate(centre_S);
    if (auto* box = std::get_if<world::Box>(&cut[i].shape)) box->half_extents[axis] /= count;
    if (auto* capsule = std::get_if<world::Capsule>(&cut[i].shape)) capsule->half_length /= count;
    if (auto* cylinder = std::get_if<world::Cylinder>(&cut[i].shape)) cylinder->half_length /= count;
  }
  return cut;
}

std::vector<Body> link_bodies(const Arm& arm) {
  std::vector<Body> bodies;
  for (const LinkGeometry& geometry : arm.model->geometry) {
    Body& body = bodies.emplace_back(
        make_body(geometry.link, -1, axes_before(*arm.model, geometry.link) > 0, geometry.shape, geometry.X_LS));
    if (arm.shapes == LinkShapes::kExact || !geometry.capsule) continue;
    const PlacedCapsule& placed = geometry.capsule->placed;
    body.capsule = {placed.capsule, geometry.X_LS * placed.X_FS};
    body.bound = {body.capsule->X_FS.translation(), placed.capsule.radius + placed.capsule.half_length};
  }
  return bodies;
}

world::BoundingSphere reach_of(const Arm& arm, const std::vector<Body>& bodies) {
  const ArmReach reach = arm_reach(arm);
  world::BoundingSphere ball{reach.centre, 0.0};
  for (const Body& body : bodies) {
    ball.radius = std::max(ball.radius, reach.links[body.link] + body.bound.centre.norm() + body.bound.radius);
  }
  return ball;
}

}  // namespace

std::vector<int> grasp_links(const RobotModel& model) {
  // The nearest link from the tool towards the root that a joint moves: all links beyond it are rigid with the tool.
  const int moved = moved_link(model, model.tool_link);
  const int before = moved < 0 ? -1 : moved_link(model, model.links[moved].parent);
  std::vector<int> links;
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link) {
    const int root = moved_link(model, link);
    if (root == moved || root == before) links.push_back(link);
  }
  return links;
}

CellGeometry::CellGeometry(std::vector<Arm> arms, int self) : arms_(std::move(arms)), self_(self) {
  set_obstacles({});
}

void CellGeometry::set_obstacles(std::span<const world::Obstacle> obstacles) {
  arm_bodies_.clear();
  for (const Arm& arm : arms_) arm_bodies_.push_back(link_bodies(arm));
  for (int i = 0; i < static_cast<int>(arms_.size()); ++i) {
    if (i == self_ || !same_robot(arms_[i], own_arm())) continue;
    std::erase_if(arm_bodies_[i], [](const Body& body) { return !body.moves; });
  }
  self_pairs_ = own_arm().model->self_pairs;
  obstacle_names_.clear();
  obstacle_bodies_.clear();

  const std::vector<int> may_touch = grasp_links(*own_arm().model);
  for (int i = 0; i < static_cast<int>(obstacles.size()); ++i) {
    const world::Obstacle& obstacle = obstacles[i];
    obstacle_names_.push_back(obstacle.name);
    auto& free_bodies = obstacle_bodies_.emplace_back();
    if (!obstacle.attachment) {
      for (const auto& placed : obstacle.shapes) {
        free_bodies.push_back(make_body(-1, i, true, placed.shape, placed.X_BS));
      }
      continue;
    }
    const auto carrier =
        std::find_if(arms_.begin(), arms_.end(), [&](const Arm& arm) { return arm.name == obstacle.attachment->arm; });
    if (carrier == arms_.end()) {
      throw std::invalid_argument("obstacle '" + obstacle.name + "' is attached to '" + obstacle.attachment->arm +
                                  "', which is no arm of this cell");
    }
    const int arm = static_cast<int>(carrier - arms_.begin());
    const RobotModel& model = *carrier->model;
    std::vector<world::PlacedShape> carried;
    for (const auto& placed : obstacle.shapes) {
      const auto cut = pieces(placed);
      carried.insert(carried.end(), cut.begin(), cut.end());
    }
    for (const auto& placed : carried) {
      const Pose X_LS = model.X_LT * obstacle.attachment->X_TO * placed.X_BS;
      const int body = static_cast<int>(arm_bodies_[arm].size());
      arm_bodies_[arm].push_back(
          make_body(model.tool_link, i, axes_before(model, model.tool_link) > 0, placed.shape, X_LS));
      if (arm != self_) continue;
      for (int other = 0; other < static_cast<int>(model.geometry.size()); ++other) {
        const bool touches =
            std::find(may_touch.begin(), may_touch.end(), model.geometry[other].link) != may_touch.end();
        if (!touches) self_pairs_.emplace_back(other, body);
      }
    }
  }
  arm_reach_.clear();
  for (std::size_t i = 0; i < arms_.size(); ++i) arm_reach_.push_back(reach_of(arms_[i], arm_bodies_[i]));
}

double CellGeometry::widest(int first, int second) const {
  for (const ClosePair& pair : own_arm().model->close_pairs) {
    if (pair.first == first && pair.second == second) return pair.widest;
  }
  return std::numeric_limits<double>::infinity();
}

double CellGeometry::gap_to_arm(int arm) const {
  const world::BoundingSphere& own = arm_reach_[self_];
  const world::BoundingSphere& other = arm_reach_[arm];
  return (own.centre - other.centre).norm() - own.radius - other.radius;
}

std::vector<int> CellGeometry::neighbourhood(double distance) const {
  std::vector<int> near;
  for (int arm = 0; arm < static_cast<int>(arms_.size()); ++arm) {
    if (arm == self_ || gap_to_arm(arm) < distance) near.push_back(arm);
  }
  return near;
}

CellGeometry CellGeometry::without_moving_others() const {
  CellGeometry rest = *this;
  for (int arm = 0; arm < static_cast<int>(arms_.size()); ++arm) {
    if (arm != self_) std::erase_if(rest.arm_bodies_[arm], [](const Body& body) { return body.moves; });
  }
  return rest;
}

std::string CellGeometry::body_name(int arm, const Body& body) const {
  const std::string part =
      body.obstacle >= 0 ? obstacle_names_[body.obstacle] : arms_[arm].model->links[body.link].name;
  return arms_[arm].name + "/" + part;
}

std::string CellGeometry::own_name(const Clearance& clearance) const {
  return body_name(self_, own_bodies()[clearance.own_body]);
}

std::string CellGeometry::other_name(const Clearance& clearance) const {
  switch (clearance.counterpart) {
    case Counterpart::kSelf:
      return body_name(self_, own_bodies()[clearance.other_body]);
    case Counterpart::kArm:
      return body_name(clearance.other, arm_bodies_[clearance.other][clearance.other_body]);
    case Counterpart::kObstacle:
      return obstacle_names_[clearance.other];
  }
  return {};
}

}  // namespace hecaton::planner
