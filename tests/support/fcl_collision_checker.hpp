#pragma once
/// Collision checks by FCL, the reference for Validity.

#include <vector>

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>

#include "planner/global/validity.hpp"
#include "tests/support/fcl_shape.hpp"

namespace hecaton::test {

class FclCollisionChecker {
 public:
  FclCollisionChecker(const planner::global::Validity& validity, std::span<const planner::global::WorldBody> world)
      : validity_(validity) {
    for (const planner::CellGeometry& geometry : validity.planned()) {
      for (const planner::Body& body : geometry.own_bodies()) {
        own_.emplace_back(fcl_shape(body.shape));
        moves_.push_back(body.moves);
      }
    }
    for (const auto& body : world) {
      world_.emplace_back(fcl_shape(body.shape));
      world_.back().setTransform(body.X_WS);
      world_.back().computeAABB();
    }
  }

  /// True if a pair that Validity checks collides, or a moving body collides with the world.
  [[nodiscard]] bool collides(const double* q) {
    place(q);
    for (const auto& pair : validity_.robot().pairs) {
      if (touch(own_[pair.a], own_[pair.b])) return true;
    }
    for (std::size_t i = 0; i < own_.size(); ++i) {
      if (!moves_[i]) continue;
      for (auto& other : world_) {
        if (touch(own_[i], other)) return true;
      }
    }
    return false;
  }
  [[nodiscard]] bool collides(const float* q) {
    const std::vector<double> exact(q, q + validity_.dimensions());
    return collides(exact.data());
  }

  /// Number of colliding configurations on the path, at most `step` apart in joint space [rad | m].
  [[nodiscard]] int collisions_on(const std::vector<std::vector<double>>& path, double step) {
    int count = 0;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      const auto& a = path[i];
      const auto& b = path[i + 1];
      double length2 = 0.0;
      for (std::size_t j = 0; j < a.size(); ++j) length2 += (b[j] - a[j]) * (b[j] - a[j]);
      const int steps = 1 + static_cast<int>(std::sqrt(length2) / step);
      std::vector<double> q(a.size());
      for (int k = 0; k <= steps; ++k) {
        for (std::size_t j = 0; j < a.size(); ++j) q[j] = a[j] + (b[j] - a[j]) * k / steps;
        count += collides(q.data()) ? 1 : 0;
      }
    }
    return count;
  }

 private:
  void place(const double* q) {
    std::size_t body = 0;
    for (const planner::CellGeometry& geometry : validity_.planned()) {
      const planner::Arm& arm = geometry.own_arm();
      const planner::JointVector own = Eigen::Map<const Eigen::VectorXd>(q, arm.model->joints());
      q += arm.model->joints();
      planner::Kinematics kinematics;
      planner::forward_kinematics(*arm.model, arm.X_WB, own, kinematics);
      for (const planner::Body& part : geometry.own_bodies()) {
        own_[body].setTransform(kinematics.X_WL[part.link] * part.X_CS);
        own_[body++].computeAABB();
      }
    }
  }
  static bool touch(fcl::CollisionObjectd& a, fcl::CollisionObjectd& b) {
    if (!a.getAABB().overlap(b.getAABB())) return false;
    fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    return fcl::collide(&a, &b, request, result) > 0;
  }

  const planner::global::Validity& validity_;
  std::vector<fcl::CollisionObjectd> own_;
  std::vector<bool> moves_;
  std::vector<fcl::CollisionObjectd> world_;
};

}  // namespace hecaton::test
