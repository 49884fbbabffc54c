#pragma once
/// Bullet's side of the physical world: the space in which bodies fall and push, and one body in it.

#include <memory>
#include <span>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "world/model/obstacle_motion.hpp"
#include "world/model/scene.hpp"

namespace hecaton::world {

/// A Bullet world with a floor. Light (some 100 kB), single-threaded and deterministic.
class PhysicsSpace {
 public:
  PhysicsSpace(double floor_z, const Eigen::Vector3d& gravity);
  ~PhysicsSpace();
  PhysicsSpace(const PhysicsSpace&) = delete;
  PhysicsSpace& operator=(const PhysicsSpace&) = delete;

  /// One substep of h [s].
  void step(double h);
  [[nodiscard]] btDiscreteDynamicsWorld& bullet() { return *world_; }

 private:
  std::unique_ptr<btDefaultCollisionConfiguration> configuration_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btBroadphaseInterface> broadphase_;
  std::unique_ptr<btSequentialImpulseConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  std::unique_ptr<btCollisionShape> floor_shape_;
  std::unique_ptr<btRigidBody> floor_;
};

/// A body in a space, there as long as this object lives. Frame O is the obstacle's (or link's) own; Bullet's own body
/// frame M is at the centre of mass, along the principal axes.
class RigidBody {
 public:
  /// Moved from outside, pushes others, is never pushed.
  RigidBody(PhysicsSpace& space, std::span<const PlacedShape> shapes, const Pose& X_WO);
  /// Falls, rolls and is pushed. Rolling friction acts on bodies with a round shape only. Uniform density; a hull's
  /// inertia is that of its bounding box.
  RigidBody(PhysicsSpace& space, std::span<const PlacedShape> shapes, const DynamicMotion& motion,
            const MotionState& start);
  ~RigidBody();
  RigidBody(const RigidBody&) = delete;
  RigidBody& operator=(const RigidBody&) = delete;

  /// Of a body moved from outside: where it is at the beginning of the next substep of h [s], and how it moves.
  void place(const MotionState& state, double h);
  [[nodiscard]] MotionState state() const;

 private:
  void build_shape(std::span<const PlacedShape> shapes);
  btVector3 centre_on_mass(std::span<const PlacedShape> shapes, double mass);

  PhysicsSpace& space_;
  Pose X_OM_ = Pose::Identity();
  std::vector<std::unique_ptr<btConvexShape>> parts_;
  std::unique_ptr<btCompoundShape> compound_;
  std::unique_ptr<btRigidBody> body_;
};

}  // namespace hecaton::world
