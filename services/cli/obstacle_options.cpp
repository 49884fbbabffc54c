#include "services/cli/obstacle_options.hpp"

#include <CLI/CLI.hpp>

#include "services/command_line/failure.hpp"
#include "services/command_line/quantities.hpp"
#include "services/config/obstacle_rules.hpp"

namespace hecaton::services::cli {
namespace {

world::Shape make_shape(const ObstacleOptions& options) {
  if (!options.box.empty()) return world::Box{{0.5 * options.box[0], 0.5 * options.box[1], 0.5 * options.box[2]}};
  if (!options.cylinder.empty()) return world::Cylinder{options.cylinder[0], 0.5 * options.cylinder[1]};
  if (!options.capsule.empty()) return world::Capsule{options.capsule[0], 0.5 * options.capsule[1]};
  return world::Sphere{options.sphere};
}

/// Length and direction; any direction when the vector has no length, which the rules then refuse.
std::pair<double, Eigen::Vector3d> polar(const std::vector<double>& numbers) {
  const Eigen::Vector3d vector(numbers[0], numbers[1], numbers[2]);
  const double length = vector.stableNorm();
  return {length, length > 0.0 ? Eigen::Vector3d(vector / length) : Eigen::Vector3d::UnitX()};
}

world::Motion make_motion(const ObstacleOptions& options) {
  if (options.mass) {
    world::DynamicMotion motion;
    motion.mass = *options.mass;
    return motion;
  }
  if (!options.conveyor.empty()) {
    const auto [speed, direction_W] = polar(options.conveyor);
    return world::ConveyorMotion{direction_W, speed, options.conveyor[3]};
  }
  if (!options.sine.empty()) {
    const auto [amplitude, direction_W] = polar(options.sine);
    return world::SineMotion{direction_W, amplitude, options.sine[3], 0.0};
  }
  if (!options.circle.empty()) {
    world::CircleMotion motion;
    motion.centre_W = {options.circle[0], options.circle[1], options.circle[2]};
    motion.angular_speed = options.circle[3];
    return motion;
  }
  return world::StaticMotion{};
}

/// The option that a key of the cell file's obstacles comes from, and what of it: "--box size[1]".
std::string option_of(const std::string& key, const ObstacleOptions& options) {
  const std::string shape = !options.box.empty()        ? "--box"
                            : !options.cylinder.empty() ? "--cylinder"
                            : !options.capsule.empty()  ? "--capsule"
                                                        : "--sphere";
  const std::string motion = options.mass                ? "--mass"
                             : !options.conveyor.empty() ? "--conveyor"
                             : !options.sine.empty()     ? "--sine"
                                                         : "--circle";
  constexpr std::string_view kShape = "shapes[0].";
  constexpr std::string_view kMotion = "motion.";
  if (key == "name") return "NAME";
  if (key == "motion.mass" || (shape == "--sphere" && key.starts_with(kShape)))
    return key == "motion.mass" ? motion : shape;
  if (key.starts_with(kShape)) return shape + " " + key.substr(kShape.size());
  if (key.starts_with(kMotion)) return motion + " " + key.substr(kMotion.size());
  return "--" + key;
}

}  // namespace

void add_obstacle_options(CLI::App& app, ObstacleOptions& options) {
  app.add_option("NAME", options.name, "a name that no other obstacle has")->required();
  CLI::Option_group* shape = app.add_option_group("shape", "one of");
  add_numbers(*shape, "--box", options.box, 3, "sizes along x y z [m]");
  add_number(
      *shape, "--sphere", [&options](double radius) { options.sphere = radius; }, "radius [m]");
  add_numbers(*shape, "--cylinder", options.cylinder, 2, "radius and height [m], axis along z");
  add_numbers(*shape, "--capsule", options.capsule, 2, "radius and length between the caps' centres [m], axis along z");
  shape->require_option(1);
  add_pose(app, "--pose", options.pose, kPoseHelp)->required();
  CLI::Option_group* motion = app.add_option_group("motion", "at most one of; otherwise it stands still");
  add_number(
      *motion, "--mass", [&options](double mass) { options.mass = mass; }, "falls and is pushed, with this mass [kg]");
  add_numbers(*motion, "--conveyor", options.conveyor, 4,
              "velocity vx vy vz [m/s], and the length [m] after which it starts again");
  add_numbers(*motion, "--sine", options.sine, 4, "amplitude ax ay az [m] and period [s]");
  add_numbers(*motion, "--circle", options.circle, 4, "centre x y z [m] and angular speed about z [rad/s]");
  motion->require_option(0, 1);
}

world::Obstacle make_obstacle(const ObstacleOptions& options) {
  world::Obstacle obstacle;
  obstacle.name = options.name;
  obstacle.shapes.push_back({make_shape(options), world::Pose::Identity()});
  obstacle.X_WO = pose_of(options.pose);
  obstacle.motion = make_motion(options);
  if (const auto complaint = config::complain(obstacle)) {
    throw Failure(ExitCode::kBadInput,
                  option_of(complaint->key, options) + " = " + complaint->value + " must be " + complaint->must_be);
  }
  return obstacle;
}

}  // namespace hecaton::services::cli
