#pragma once
/// An obstacle as the command line describes it.

#include <string>
#include <vector>

#include "world/model/scene.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace hecaton::services::cli {

struct ObstacleOptions {
  std::string name;
  std::vector<double> box;       ///< full sizes along x, y, z [m]
  double sphere = 0.0;           ///< radius [m]
  std::vector<double> cylinder;  ///< radius, height [m]
  std::vector<double> capsule;   ///< radius, length of the segment [m]
  std::vector<double> pose;      ///< x y z [m] roll pitch yaw [rad]
  double mass = 0.0;             ///< [kg]; 0: static
  std::vector<double> conveyor;  ///< velocity [m/s], length [m]; empty: none
  std::vector<double> sine;      ///< amplitude along x, y, z [m], period [s]; empty: none
  std::vector<double> circle;    ///< centre [m], angular speed about z [rad/s]; empty: none
};

void add_obstacle_options(CLI::App& app, ObstacleOptions& options);

/// --pose "x y z roll pitch yaw"
CLI::Option* add_pose(CLI::App& app, std::vector<double>& xyz_rpy);

/// Throws CLI::ValidationError for sizes that are not positive.
[[nodiscard]] world::Obstacle make_obstacle(const ObstacleOptions& options);

}  // namespace hecaton::services::cli
