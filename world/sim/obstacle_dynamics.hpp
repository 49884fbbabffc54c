#pragma once
/// Rigid body dynamics of a cell's obstacles on Bullet: free bodies fall, roll, and are pushed by arms and obstacles.

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "world/model/obstacle_motion.hpp"
#include "world/model/scene.hpp"
#include "world/sim/contact_monitor.hpp"

namespace hecaton::world {

/// An arm as measured. Between two steps it moves at constant velocity.
class ArmTrack {
 public:
  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] std::span<const Pose> X_WL() const { return X_WL_; }
  [[nodiscard]] const Pose& X_WT() const { return X_WT_; }
  /// Over the last step.
  [[nodiscard]] const Twist& tool_velocity() const { return tool_velocity_; }

  void measure(std::span<const Pose> X_WL, const Pose& X_WT);

  /// State at `elapsed` [s] of a step of dt > 0 [s] that ends at the last measurement.
  [[nodiscard]] MotionState link_at(int link, double dt, double elapsed) const {
    return between(X_WL_before_[link], X_WL_[link], dt, elapsed);
  }
  [[nodiscard]] MotionState tool_at(double dt, double elapsed) const {
    return between(X_WT_before_, X_WT_, dt, elapsed);
  }

  void end_step(double dt);

 private:
  static MotionState between(const Pose& from, const Pose& to, double dt, double elapsed) {
    const Twist velocity = twist_between(from, to, dt);
    return {extrapolate(from, velocity, elapsed), velocity};
  }

  bool known_ = false;
  std::vector<Pose> X_WL_;
  Pose X_WT_ = Pose::Identity();
  std::vector<Pose> X_WL_before_;  ///< at the last step
  Pose X_WT_before_ = Pose::Identity();
  Twist tool_velocity_;
};

/// State of an obstacle that a tool holds at X_TO.
[[nodiscard]] MotionState carried(const MotionState& tool, const Pose& X_TO);

/// True: the obstacle is dynamic and no arm carries it.
[[nodiscard]] bool is_free(const Obstacle& obstacle);

/// A Bullet world with a floor. About 100 kB; single-threaded and deterministic.
class PhysicsSpace {
 public:
  PhysicsSpace(double floor_z, const Eigen::Vector3d& gravity);
  ~PhysicsSpace();
  PhysicsSpace(const PhysicsSpace&) = delete;
  PhysicsSpace& operator=(const PhysicsSpace&) = delete;

  /// One substep of h [s].
  void step(double h);
  [[nodiscard]] btDiscreteDynamicsWorld& bullet() { return *world_; }
  /// Wakes the dynamic bodies at `body`, which comes or goes.
  void wake_at(const btRigidBody& body);

 private:
  std::unique_ptr<btDefaultCollisionConfiguration> configuration_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btBroadphaseInterface> broadphase_;
  std::unique_ptr<btSequentialImpulseConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  std::unique_ptr<btCollisionShape> floor_shape_;
  std::unique_ptr<btRigidBody> floor_;
};

/// A body in a space; the space must outlive it. Frame O is that of the obstacle or link. Bullet's frame M has its
/// origin at the centre of mass and lies along the principal axes.
class RigidBody {
 public:
  /// Pushes other bodies, is never pushed. `guided`: place() moves it; else it stands.
  RigidBody(PhysicsSpace& space, std::span<const PlacedShape> shapes, const Pose& X_WO, bool guided);
  /// Dynamic, of uniform density. Sleeps once it and all bodies that it touches have rested for 2 s. Rolling friction
  /// acts on bodies with a round shape only; a hull has the inertia of its bounding box.
  RigidBody(PhysicsSpace& space, std::span<const PlacedShape> shapes, const DynamicMotion& motion,
            const MotionState& start);
  ~RigidBody();
  RigidBody(const RigidBody&) = delete;
  RigidBody& operator=(const RigidBody&) = delete;

  /// Guided bodies only: state at the beginning of the next substep of h [s].
  void place(const MotionState& state, double h);
  [[nodiscard]] MotionState state() const;
  [[nodiscard]] bool awake() const { return body_->isActive(); }
  /// True at most once after the body has fallen asleep: its state stays the same until it wakes.
  [[nodiscard]] bool may_have_moved() { return std::exchange(read_awake_, awake()) || read_awake_; }
  /// Distance that the body may move in a substep without passing through a plate [m].
  [[nodiscard]] double safe_motion() const { return safe_motion_; }
  [[nodiscard]] double speed() const { return body_->getLinearVelocity().length(); }  ///< of the centre [m/s]

 private:
  void build_shape(std::span<const PlacedShape> shapes);
  btVector3 centre_on_mass(std::span<const PlacedShape> shapes, double mass);

  PhysicsSpace& space_;
  Pose X_OM_ = Pose::Identity();
  std::vector<std::unique_ptr<btConvexShape>> parts_;
  std::unique_ptr<btCompoundShape> compound_;
  std::unique_ptr<btRigidBody> body_;
  bool read_awake_ = true;
  double safe_motion_ = 0.0;
};

/// The input of one step.
struct DynamicsInput {
  const Scene& scene;
  std::span<const ArmBodies> arms;
  std::span<const ArmTrack> tracks;           ///< one per arm
  std::span<const ArmTrack* const> carriers;  ///< one per obstacle: the arm that carries it, or null
  std::span<const int> guided;                ///< obstacles that follow a script or an arm
  std::span<const int> free;                  ///< obstacles that are free
  double time = 0.0;                          ///< at the beginning of the step [s]
};

/// Bullet's bodies of a scene. They are made when the first free obstacle moves.
class ObstacleDynamics {
 public:
  /// Obstacle i has changed: the next step makes its body again.
  void renew(int obstacle) {
    bodies_[obstacle].reset();
    complete_ = false;
  }
  void append() {
    bodies_.emplace_back();
    complete_ = false;
  }
  void erase(int obstacle) { bodies_.erase(bodies_.begin() + obstacle); }

  /// Advances the states of free obstacles by dt [s], in equal substeps of at most 5 ms. A free obstacle that would
  /// move farther than half its thickness in one makes them shorter, to 0.5 ms at least. Does nothing without free
  /// obstacles. Returns the obstacles that may have moved; valid until the next call.
  std::span<const int> advance(const DynamicsInput& input, std::span<ObstacleState> states, double dt);

 private:
  void make_missing(const DynamicsInput& input, std::span<const ObstacleState> states);
  void place(const DynamicsInput& input, double dt, double elapsed, double h);
  [[nodiscard]] int substeps(const DynamicsInput& input, double dt) const;

  std::unique_ptr<PhysicsSpace> space_;                              ///< outlives the bodies
  std::vector<std::unique_ptr<RigidBody>> bodies_;                   ///< of the obstacles
  std::vector<std::vector<std::unique_ptr<RigidBody>>> arm_bodies_;  ///< of each arm's parts
  bool complete_ = false;                                            ///< no body is missing
  std::vector<int> moved_;
};

}  // namespace hecaton::world
