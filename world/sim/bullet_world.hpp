#pragma once
/// The physical world of a cell on Bullet (double precision): static obstacles, obstacles on scripted motions, rigid
/// bodies that fall and are pushed, and the arms as kinematic bodies set from *measured* joint states.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"
#include "world/sim/arm_bodies.hpp"
#include "world/sim/contact_monitor.hpp"

namespace hecaton::world {

/// Why an edit was refused.
enum class EditRefusal {
  kNone,          ///< it was done
  kUnknownName,   ///< of an obstacle or an arm
  kNameTaken,     ///< by another obstacle, or by an arm
  kInvalidValue,  ///< a shape, pose, motion or carrier that is impossible
  kNotNow,        ///< the obstacle or the arm is in a state that forbids it
};

/// The outcome of an edit. A refused edit changes nothing.
struct EditResult {
  EditRefusal refusal = EditRefusal::kNone;
  std::string subject{};  ///< the obstacle or arm that the refusal is about
  std::string reason{};   ///< one sentence for people; empty only when done
  [[nodiscard]] bool done() const { return refusal == EditRefusal::kNone; }
};

/// One period: set_arm() for every arm that was measured, step(), snapshot(). Not thread-safe; worlds share nothing, so
/// each thread may have its own. Creating one costs well below a millisecond and a megabyte.
///
/// Same construction, same calls: same states to the last bit. Scripts run on the world's time: an obstacle added at
/// time t begins at that instant of its script. As long as no free dynamic body exists, no physics is computed.
class BulletWorld {
 public:
  /// Throws std::invalid_argument, with one sentence, when a shape, pose or motion is impossible, when two arms or two
  /// obstacles share a name, or an attachment names no arm.
  BulletWorld(const Scene& scene, std::vector<ArmBodies> arms);
  ~BulletWorld();
  BulletWorld(BulletWorld&&) noexcept;
  BulletWorld& operator=(BulletWorld&&) noexcept;

  /// Measured link poses (index = link) and tool frame of an arm. Until the first, the arm is unknown: it pushes
  /// nothing and is not judged. In the next step it moves evenly from where it was at the last. False, and nothing
  /// changed, when there is no such arm, a link with a shape has no pose, or a pose is not finite.
  bool set_arm(int arm, std::span<const Pose> X_WL, const Pose& X_WT);

  /// Advances by dt ≥ 0 [s] (equal internal steps of at most 5 ms), then lets the contact monitor judge.
  /// Throws std::invalid_argument when dt is negative or not finite.
  void step(double dt);

  [[nodiscard]] double time() const;  ///< [s]
  /// Moves scripted obstacles to another instant of their script (between steps); dynamic ones stay where they are.
  /// Throws std::invalid_argument when it is not finite.
  void set_time(double seconds);

  /// What a new world must begin with to go on where this one is: obstacles that are carried or left to physics begin
  /// where they are now, at their velocity.
  [[nodiscard]] std::vector<Obstacle> obstacles_now() const;
  /// To be called before the first step of a world that begins with another's obstacles_now(): goes on at its time
  /// and edition and with its contact monitor's account. Throws as set_time() does.
  void restore(double seconds, std::uint64_t edition, const ContactCheckpoint& account);

  /// Current obstacles; attachments and motions as edited. Index order = snapshot order. X_WO is where a scripted
  /// motion starts from or where the obstacle was last put; where it is now, the snapshot says.
  [[nodiscard]] const std::vector<Obstacle>& obstacles() const;
  /// Poses and velocities of all obstacles; those attached move with their arm, their velocity being that of the last
  /// step. While the arm is unknown, what is attached to it rests at its own X_WO.
  [[nodiscard]] ObstacleSnapshot snapshot() const;

  /// Refused when its name is taken, its shapes, pose or motion are impossible, or an attachment names no arm.
  EditResult add(const Obstacle& obstacle);
  /// Ends a scripted motion; a dynamic body keeps its mass and starts there at rest. Refused while it is attached.
  EditResult move(const std::string& name, const Pose& X_WO);
  EditResult remove(const std::string& name);  ///< also what an arm carries
  /// Where it is now, relative to the tool; ends a scripted motion. Refused while attached or the arm unknown.
  EditResult attach(const std::string& name, const std::string& arm);
  /// Dynamic bodies fall, with the velocity they had; others stay where they are. Refused while the arm is unknown.
  EditResult detach(const std::string& name);

  [[nodiscard]] const ContactMonitor& contact_monitor() const;
  [[nodiscard]] ContactMonitor& contact_monitor();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::world
