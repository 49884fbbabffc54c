#pragma once
/// Dynamic obstacles through one step of the world: they fall, roll, and are pushed by arms and by other obstacles.

#include <memory>
#include <span>
#include <vector>

#include "world/sim/arm_bodies.hpp"
#include "world/sim/arm_track.hpp"
#include "world/sim/rigid_body.hpp"

namespace hecaton::world {

/// Neither fixed, nor scripted, nor carried.
[[nodiscard]] bool is_free(const Obstacle& obstacle);

/// What takes part in a step. `carriers[i]` is the arm that carries obstacle i; null: none.
struct Surroundings {
  const Scene& scene;
  std::span<const ArmBodies> arms;
  std::span<const ArmTrack> tracks;           ///< one per arm
  std::span<const ArmTrack* const> carriers;  ///< one per obstacle
  double time = 0.0;                          ///< at the beginning of the step [s]
};

/// Bullet's bodies of a scene, made when the first free body moves.
class Pushing {
 public:
  /// Obstacle i is not what or where it was: its body is made anew in the next step.
  void renew(int obstacle) { bodies_[obstacle].reset(); }
  void append() { bodies_.emplace_back(); }
  void erase(int obstacle) { bodies_.erase(bodies_.begin() + obstacle); }

  /// Equal substeps of at most 5 ms. Reads and writes the states of free obstacles; does nothing when there are none.
  void advance(const Surroundings& around, std::span<MotionState> states, double dt);

 private:
  void make_missing(const Surroundings& around, std::span<const MotionState> states);
  void place(const Surroundings& around, double dt, double elapsed, double h);

  std::unique_ptr<PhysicsSpace> space_;                              ///< outlives the bodies
  std::vector<std::unique_ptr<RigidBody>> bodies_;                   ///< of the obstacles
  std::vector<std::vector<std::unique_ptr<RigidBody>>> arm_bodies_;  ///< of each arm's parts
};

}  // namespace hecaton::world
