#pragma once
/// The physical world of a cell on Bullet (double precision). It has static and scripted obstacles, rigid bodies that
/// fall and are pushed, and the arms as kinematic bodies at their measured poses.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/model/present_states.hpp"
#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"
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
  std::string subject{};  ///< the obstacle or arm concerned
  std::string reason{};   ///< one sentence for the user; empty when done
  [[nodiscard]] bool done() const { return refusal == EditRefusal::kNone; }
};

/// One period: set_arm() for every measured arm, step(), snapshot(). The same calls give the same states to the last
/// bit. Scripted motions run on the world's time. Physics is computed only while a free dynamic obstacle exists. A step
/// costs time for what moves, and hardly any for what stands or lies still. An edit costs time for all obstacles. Not
/// thread-safe; two worlds share nothing.
class BulletWorld {
 public:
  /// Throws std::invalid_argument, with one sentence, when a shape, pose or motion is impossible, when two arms or two
  /// obstacles share a name, or when an attachment names no arm.
  BulletWorld(const Scene& scene, std::vector<ArmBodies> arms);
  ~BulletWorld();
  BulletWorld(BulletWorld&&) noexcept;
  BulletWorld& operator=(BulletWorld&&) noexcept;

  /// Measured link poses (index = link) and tool frame of arm `arm`. Until the first call the arm is unknown: it pushes
  /// nothing and is not checked for contacts. During the next step the arm moves at constant velocity to these poses.
  /// Returns false and changes nothing when there is no such arm, when a link with a shape has no pose, or when a pose
  /// is not finite.
  bool set_arm(int arm, std::span<const Pose> X_WL, const Pose& X_WT);

  /// Advances by dt ≥ 0 [s], physics in equal substeps of at most 5 ms (ObstacleDynamics), then updates the contact
  /// monitor. Throws std::invalid_argument when dt is negative or not finite.
  void step(double dt);

  [[nodiscard]] double time() const;  ///< [s]
  /// Sets the time of scripted motions, between two steps. Dynamic obstacles keep their states. Throws
  /// std::invalid_argument when `seconds` is not finite.
  void set_time(double seconds);

  /// The obstacles from which another world can continue this one: carried and dynamic ones start at their present
  /// poses and velocities.
  [[nodiscard]] std::vector<Obstacle> obstacles_now() const;
  /// Continues a world whose obstacles_now() this one was made with. Must be called before the first step. Throws as
  /// set_time() does.
  void restore(double seconds, std::uint64_t edition, const ContactCheckpoint& contacts);

  /// The obstacles as edited, in the order of the snapshot. X_WO is the initial pose of a scripted motion, or where the
  /// obstacle was last put; the snapshot has the present pose.
  [[nodiscard]] const std::vector<Obstacle>& obstacles() const;
  /// The obstacle with this name; null: there is none. Valid until the next call that is not const.
  [[nodiscard]] const Obstacle* find(const std::string& name) const;
  /// Poses and velocities of all obstacles. Attached ones move with their arm at the velocity of the last step; while
  /// that arm is unknown, they rest at their own X_WO.
  [[nodiscard]] ObstacleSnapshot snapshot() const;
  /// The same without copies, for readers that look only at changes. Valid until the next call that is not const. An
  /// attached obstacle is where it was at the last step.
  [[nodiscard]] PresentStates present() const;
  [[nodiscard]] std::uint64_t edition() const;  ///< as in the snapshot

  /// Refuses a name that is taken, an impossible shape, pose or motion, and an attachment to an unknown arm.
  EditResult add(const Obstacle& obstacle);
  /// Puts the obstacle in the place of the one with its name, carried or not. Refuses an unknown name, and what add()
  /// refuses otherwise.
  EditResult replace(const Obstacle& obstacle);
  /// Ends a scripted motion. A dynamic obstacle starts there at rest. Refuses an attached obstacle.
  EditResult move(const std::string& name, const Pose& X_WO);
  EditResult remove(const std::string& name);  ///< attached or not
  /// Fixes the obstacle to the tool where it is now; ends a scripted motion. Refuses an attached obstacle and an
  /// unknown arm.
  EditResult attach(const std::string& name, const std::string& arm);
  /// A dynamic obstacle falls, with the velocity that it had; others stay where they are. Refuses while the arm is
  /// unknown.
  EditResult detach(const std::string& name);

  [[nodiscard]] const ContactMonitor& contact_monitor() const;
  [[nodiscard]] ContactMonitor& contact_monitor();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::world
