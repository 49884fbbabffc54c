#include "planner/collision/near_pairs.hpp"

#include <algorithm>

namespace hecaton::planner {
namespace {

using Eigen::Vector3d;

/// Rounding in a bound may not lose a pair that sits on its limit.
constexpr double kSlack = 1e-9;

Eigen::AlignedBox3d bounding_box(const world::Shape& shape) {
  struct Visitor {
    static Eigen::AlignedBox3d around_origin(const Vector3d& half) { return {-half, half}; }
    Eigen::AlignedBox3d operator()(const world::Box& box) const { return around_origin(box.half_extents); }
    Eigen::AlignedBox3d operator()(const world::Sphere& sphere) const {
      return around_origin(Vector3d::Constant(sphere.radius));
    }
    Eigen::AlignedBox3d operator()(const world::Capsule& capsule) const {
      return around_origin({capsule.radius, capsule.radius, capsule.half_length + capsule.radius});
    }
    Eigen::AlignedBox3d operator()(const world::Cylinder& cylinder) const {
      return around_origin({cylinder.radius, cylinder.radius, cylinder.half_length});
    }
    Eigen::AlignedBox3d operator()(const world::Convex& convex) const {
      Eigen::AlignedBox3d box;
      for (const auto& vertex : convex.hull->vertices) box.extend(vertex);
      return box;
    }
  };
  return std::visit(Visitor{}, shape);
}

const Pose& carrier_pose(const CellBody& body, const CellPoses& poses) {
  switch (body.counterpart) {
    case Counterpart::kSelf:
      return poses.own->X_WL[body.link];
    case Counterpart::kArm:
      return poses.arms[body.owner].X_WL[body.link];
    case Counterpart::kObstacle:
      break;
  }
  return poses.obstacles[body.owner].X_WO;
}

}  // namespace

NearPairs::NearPairs(const CellGeometry& geometry) : self_pairs_(geometry.self_pairs()) {
  const auto add = [&](Counterpart counterpart, int owner, const std::vector<Body>& bodies) {
    for (int i = 0; i < static_cast<int>(bodies.size()); ++i) {
      const Body& body = bodies[i];
      const Eigen::AlignedBox3d box = bounding_box(body.shape);
      bodies_.push_back(
          {counterpart, owner, i, body.link, body.moves, body.X_CS, body.bound, box.center(), 0.5 * box.sizes()});
    }
  };
  add(Counterpart::kSelf, geometry.self(), geometry.own_bodies());
  own_count_ = static_cast<int>(bodies_.size());
  for (int arm = 0; arm < static_cast<int>(geometry.arms().size()); ++arm) {
    if (arm != geometry.self()) add(Counterpart::kArm, arm, geometry.arm_bodies(arm));
  }
  for (int obstacle = 0; obstacle < geometry.obstacle_count(); ++obstacle) {
    add(Counterpart::kObstacle, obstacle, geometry.obstacle_bodies(obstacle));
  }
  X_WS_.resize(bodies_.size());
  centre_W_.resize(bodies_.size());
  pairs_.reserve(self_pairs_.size() + own_count_ * (bodies_.size() - own_count_));
}

void NearPairs::place(int body, const CellPoses& poses) {
  X_WS_[body] = carrier_pose(bodies_[body], poses) * bodies_[body].X_CS;
}

/// Whether each body's bounding ball comes near the other's bounding box: catches what is long or flat.
bool NearPairs::boxes_are_near(int a, int b, double limit) const {
  const auto ball_is_near_box = [&](int ball, int box) {
    const Vector3d centre_S = X_WS_[box].linear().transpose() * (centre_W_[ball] - X_WS_[box].translation());
    const Vector3d out =
        ((centre_S - bodies_[box].box_centre).cwiseAbs() - bodies_[box].box_half).cwiseMax(Vector3d::Zero());
    const double reach = limit + bodies_[ball].bound.radius;
    return out.squaredNorm() <= reach * reach;
  };
  return ball_is_near_box(a, b) && ball_is_near_box(b, a);
}

void NearPairs::consider(int own, int other, double limit) {
  const double reach = limit + kSlack;
  const double centres = reach + bodies_[own].bound.radius + bodies_[other].bound.radius;
  if ((centre_W_[own] - centre_W_[other]).squaredNorm() > centres * centres) return;
  if (boxes_are_near(own, other, reach)) pairs_.push_back({own, other, limit});
}

std::span<const NearPair> NearPairs::find(const CellPoses& poses, const InfluenceDistances& influence) {
  pairs_.clear();
  Eigen::AlignedBox3d own_box;
  for (int own = 0; own < own_count_; ++own) {
    place(own, poses);
    const auto& bound = bodies_[own].bound;
    centre_W_[own] = poses.own->X_WL[bodies_[own].link] * bound.centre;
    const Vector3d radius = Vector3d::Constant(bound.radius);
    own_box.extend(centre_W_[own] - radius).extend(centre_W_[own] + radius);
  }
  for (const auto& [first, second] : self_pairs_) consider(first, second, influence.against_self(first, second));

  const int fastest = static_cast<int>(std::max_element(influence.own_speed.begin(), influence.own_speed.end()) -
                                       influence.own_speed.begin());
  for (int other = own_count_; other < static_cast<int>(bodies_.size()); ++other) {
    const CellBody& body = bodies_[other];
    const bool of_arm = body.counterpart == Counterpart::kArm;
    const auto limit = [&](int own) {
      return of_arm ? influence.against_arm(own, body.owner) : influence.against_obstacle(own, body.owner);
    };
    centre_W_[other] = carrier_pose(body, poses) * body.bound.centre;
    const double reach = limit(fastest) + body.bound.radius + kSlack;
    if (own_box.squaredExteriorDistance(centre_W_[other]) > reach * reach) continue;
    place(other, poses);
    for (int own = 0; own < own_count_; ++own) {
      const bool matters = bodies_[own].moves || (of_arm && body.moves);
      if (matters) consider(own, other, limit(own));
    }
  }
  return pairs_;
}

}  // namespace hecaton::planner
