#include "world/sim/ray_caster.hpp"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "world/sim/bullet_shape.hpp"
#include "world/sim/cloud_balls.hpp"
#include "world/sim/shape_tree.hpp"

namespace hecaton::world {
namespace {

/// A shape of an obstacle.
struct Target {
  int obstacle = 0;
  Pose X_OS = Pose::Identity();
  BoundingSphere bound;                     ///< in S
  std::unique_ptr<btConvexShape> shape;     ///< around the balls, if there are any
  std::shared_ptr<const CloudBalls> balls;  ///< null: of a convex shape
  Pose X_WS = Pose::Identity();
};

/// A ray that passes a box at this distance may end on its shape, by the tolerances below [m].
constexpr double kBoxMargin = 1e-4;
/// Moving obstacles change the tree only when they leave their boxes, larger by this [m].
constexpr double kBoxSlack = 0.02;

bool intersects_sphere(const Eigen::Vector3d& p, const Eigen::Vector3d& d, double length, const Eigen::Vector3d& centre,
                       double radius) {
  const Eigen::Vector3d to_centre = centre - p;
  const double along = std::clamp(to_centre.dot(d), 0.0, length);
  return (to_centre - along * d).squaredNorm() <= radius * radius;
}

/// A point this close to a surface is on it [m].
constexpr double kOnSurface = 1e-6;
constexpr int kMostSteps = 60;

double distance(const btConvexShape& shape, const btTransform& X_WS, const btVector3& p_W) {
  btSphereShape point(0.0);
  return signed_distance(shape, X_WS, point, btTransform(btQuaternion::getIdentity(), p_W)).distance;
}

/// Where the ray p_W + t d_W meets the surface first [m], by sphere tracing: t grows by the distance to the shape.
/// Bullet's own ray cast is off by 6 mm along a capsule's side, and by more where a ray grazes.
std::optional<double> trace(const btConvexShape& shape, const btTransform& X_WS, const btVector3& p_W,
                            const btVector3& d_W, double range) {
  double t = 0.0;
  for (int step = 0; step < kMostSteps && t < range; ++step) {
    const double free = distance(shape, X_WS, p_W + t * d_W);
    if (free < kOnSurface) return t;
    t += free;
  }
  return std::nullopt;  // the ray misses or grazes the surface
}

}  // namespace

struct RayCaster::Impl {
  std::vector<Target> targets;  ///< ascending by obstacle
  std::vector<int> first;       ///< target of each obstacle, and their number
  ShapeTree tree;
  std::uint64_t seen = 0;  ///< greatest number of a change of a state
};

RayCaster::RayCaster() : impl_(std::make_unique<Impl>()) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

void RayCaster::set_obstacles(std::span<const Obstacle> obstacles) {
  *impl_ = Impl();
  for (int i = 0; i < static_cast<int>(obstacles.size()); ++i) {
    impl_->first.push_back(static_cast<int>(impl_->targets.size()));
    if (obstacles[i].attachment) continue;
    for (const PlacedShape& placed : obstacles[i].shapes) {
      Target& target = impl_->targets.emplace_back();
      target.obstacle = i;
      target.X_OS = placed.X_BS;
      target.bound = bounding_sphere(placed.shape);
      target.shape = make_bullet_shape(placed.shape);
      if (const auto* points = std::get_if<Points>(&placed.shape)) target.balls = cloud_balls(points->cloud);
    }
  }
  impl_->first.push_back(static_cast<int>(impl_->targets.size()));
}

void RayCaster::place(const PresentStates& states) {
  const std::size_t count = impl_->first.empty() ? 0 : impl_->first.size() - 1;
  if (states.states.size() != count || (!states.changes.empty() && states.changes.size() != count)) {
    throw std::invalid_argument("the ray caster needs one state per obstacle");
  }
  std::uint64_t latest = impl_->seen;
  for (std::size_t i = 0; i < count; ++i) {
    if (!states.changes.empty()) {
      if (states.changes[i] <= impl_->seen) continue;
      latest = std::max(latest, states.changes[i]);
    }
    for (int number = impl_->first[i]; number < impl_->first[i + 1]; ++number) {
      Target& target = impl_->targets[static_cast<std::size_t>(number)];
      target.X_WS = states.states[i].X_WO * target.X_OS;
      impl_->tree.put(number, bounding_box(*target.shape, to_bullet(target.X_WS)).grown(kBoxMargin), kBoxSlack);
    }
  }
  impl_->seen = latest;
}

std::optional<double> RayCaster::cast(const Eigen::Vector3d& p_W, const Eigen::Vector3d& d_W, double range) const {
  const btVector3 from = to_bullet(p_W);
  const btVector3 along = to_bullet(d_W);
  const btVector3 to = from + range * along;
  const btTransform X_from(btQuaternion::getIdentity(), from);
  const btTransform X_to(btQuaternion::getIdentity(), to);
  std::optional<double> nearest;
  btCollisionObject body;
  impl_->tree.crossed(from, to, [&](int number) {
    const Target& target = impl_->targets[static_cast<std::size_t>(number)];
    if (!intersects_sphere(p_W, d_W, range, target.X_WS * target.bound.centre, target.bound.radius)) return;
    if (target.balls) {
      const Pose X_SW = target.X_WS.inverse(Eigen::Isometry);
      const auto t = target.balls->cast(X_SW * p_W, X_SW.linear() * d_W, range);
      if (t) nearest = std::min(nearest.value_or(range), *t);
      return;
    }
    const btTransform X = to_bullet(target.X_WS);
    btCollisionWorld::ClosestRayResultCallback hit(from, to);
    btCollisionWorld::rayTestSingle(X_from, X_to, &body, target.shape.get(), X, hit);
    // Bullet's ray cast misses a shape in which the ray begins.
    if (!hit.hasHit() && distance(*target.shape, X, from) > 0.0) return;
    const auto t = trace(*target.shape, X, from, along, range);
    if (t) nearest = std::min(nearest.value_or(range), *t);
  });
  return nearest;
}

}  // namespace hecaton::world
