#pragma once
/// An obstacle as options of the command line describe it.

#include <optional>
#include <string>
#include <vector>

#include "services/config/shape_types.hpp"
#include "world/model/scene.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace hecaton::services::cli {

struct ObstacleOptions {
  std::string name;
  std::vector<double> box;                  ///< full sizes along x, y, z [m]
  const config::ShapeType* type = nullptr;  ///< null: a box
  std::vector<double> sizes;                ///< of the type [m]
  std::vector<std::string> points;          ///< a file of points, and their radius [m]; empty: another shape
  std::vector<double> pose;                 ///< x y z [m] roll pitch yaw [rad]
  std::optional<double> mass;               ///< [kg]; empty: not dynamic
  std::vector<double> conveyor;             ///< velocity [m/s], length [m]; empty: none
  std::vector<double> sine;                 ///< amplitude along x, y, z [m], period [s]; empty: none
  std::vector<double> circle;               ///< centre [m], angular speed about z [rad/s]; empty: none
};

void add_obstacle_options(CLI::App& app, ObstacleOptions& options);

/// Throws Failure (bad input) for values that the rules for obstacles of cell files forbid.
[[nodiscard]] world::Obstacle make_obstacle(const ObstacleOptions& options);

}  // namespace hecaton::services::cli
