#pragma once
/// The obstacles of a cell and their motions, as the cell file defines them.

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "world/model/pose.hpp"
#include "world/model/shape.hpp"

namespace hecaton::world {

/// Stays where it is put.
struct StaticMotion {};

/// Visits poses one after the other at constant speed on straight lines, orientation by slerp.
struct WaypointMotion {
  std::vector<Pose> poses_W;  ///< at least 2
  double speed = 0.1;         ///< along the line [m/s], > 0
  bool loop = true;           ///< last → first directly; otherwise back and forth
};

/// Circles around `centre_W` in the plane normal to `axis_W`, starting at the obstacle's own pose.
struct CircleMotion {
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d axis_W = Eigen::Vector3d::UnitZ();   ///< unit
  double angular_speed = 0.5;                          ///< [rad/s], sign by the right-hand rule
  bool turn_with_motion = false;                       ///< the body rotates with its path
};

/// p(t) = p₀ + direction · amplitude · sin(2π t / period + phase)
struct SineMotion {
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();  ///< unit
  double amplitude = 0.1;                                  ///< [m]
  double period = 4.0;                                     ///< [s], > 0
  double phase = 0.0;                                      ///< [rad]
};

/// Moves along `direction_W` at `speed` and starts again at its first pose after `length`.
struct ConveyorMotion {
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();  ///< unit
  double speed = 0.1;                                      ///< [m/s]
  double length = 1.0;                                     ///< [m], > 0
};

/// A rigid body under gravity that falls, rolls and is pushed.
struct DynamicMotion {
  double mass = 1.0;               ///< [kg], > 0
  double friction = 0.5;           ///< Coulomb coefficient, ≥ 0
  double rolling_friction = 0.01;  ///< coefficient, ≥ 0
  double restitution = 0.1;        ///< [0, 1]
  Twist initial_velocity;          ///< of the origin of O, in W
};

/// How an obstacle moves.
using Motion = std::variant<StaticMotion, WaypointMotion, CircleMotion, SineMotion, ConveyorMotion, DynamicMotion>;

/// Fixed to the tool of an arm.
struct Attachment {
  std::string arm;               ///< name in the cell file
  Pose X_TO = Pose::Identity();  ///< of the obstacle in the arm's tool frame T
};

/// An obstacle, as the cell file or an edit defines it.
struct Obstacle {
  std::string name;                      ///< unique in the cell
  std::vector<PlacedShape> shapes;       ///< at least one, in the obstacle's frame O
  Pose X_WO = Pose::Identity();          ///< at t = 0; ignored while attached
  Motion motion = StaticMotion{};        ///< ignored while attached
  std::optional<Attachment> attachment;  ///< nothing: no arm carries it
};

/// All obstacles and what surrounds them.
struct Scene {
  std::vector<Obstacle> obstacles;  ///< with unique names
  double floor_z = 0.0;             ///< dynamic bodies rest on this plane [m]; it is no obstacle for the planners
  Eigen::Vector3d gravity = {0.0, 0.0, -9.81};  ///< [m/s²]
};

}  // namespace hecaton::world
