#include "services/cli/obstacle_options.hpp"

#include <CLI/CLI.hpp>

#include "services/cli/quantities.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

double positive(const std::string& what, double value) {
  if (value > 0.0 && value <= 100.0) return value;
  throw CLI::ValidationError(what + " = " + config::number_text(value) + " must be above 0 and at most 100");
}

world::Shape make_shape(const ObstacleOptions& options) {
  if (!options.box.empty()) {
    const auto half = [&](std::size_t axis) { return 0.5 * positive("--box: size", options.box[axis]); };
    return world::Box{{half(0), half(1), half(2)}};
  }
  if (!options.cylinder.empty()) {
    return world::Cylinder{positive("--cylinder: radius", options.cylinder[0]),
                           0.5 * positive("--cylinder: height", options.cylinder[1])};
  }
  if (!options.capsule.empty()) {
    return world::Capsule{positive("--capsule: radius", options.capsule[0]),
                          0.5 * positive("--capsule: segment", options.capsule[1])};
  }
  return world::Sphere{positive("--sphere: radius", options.sphere)};
}

world::Motion make_motion(const ObstacleOptions& options) {
  if (options.mass > 0.0) {
    world::DynamicMotion motion;
    motion.mass = options.mass;
    return motion;
  }
  if (!options.conveyor.empty()) {
    const Eigen::Vector3d velocity(options.conveyor[0], options.conveyor[1], options.conveyor[2]);
    const double speed = positive("--conveyor: speed", velocity.norm());
    return world::ConveyorMotion{velocity / speed, speed, positive("--conveyor: length", options.conveyor[3])};
  }
  if (!options.sine.empty()) {
    const Eigen::Vector3d amplitude(options.sine[0], options.sine[1], options.sine[2]);
    const double size = positive("--sine: amplitude", amplitude.norm());
    return world::SineMotion{amplitude / size, size, positive("--sine: period", options.sine[3]), 0.0};
  }
  if (!options.circle.empty()) {
    world::CircleMotion motion;
    motion.centre_W = {options.circle[0], options.circle[1], options.circle[2]};
    motion.angular_speed = options.circle[3];
    return motion;
  }
  return world::StaticMotion{};
}

}  // namespace

CLI::Option* add_pose(CLI::App& app, std::vector<double>& xyz_rpy) {
  return add_numbers(app, "--pose", xyz_rpy, 6, "x y z [m] roll pitch yaw [rad] in the cell's frame");
}

void add_obstacle_options(CLI::App& app, ObstacleOptions& options) {
  app.add_option("NAME", options.name, "a name that no other obstacle has")->required();
  CLI::Option_group* shape = app.add_option_group("shape", "one of");
  add_numbers(*shape, "--box", options.box, 3, "sizes along x y z [m]");
  shape->add_option("--sphere", options.sphere, "radius [m]")->type_name("R");
  add_numbers(*shape, "--cylinder", options.cylinder, 2, "radius and height [m], axis along z");
  add_numbers(*shape, "--capsule", options.capsule, 2, "radius and length between the caps' centres [m], axis along z");
  shape->require_option(1);
  add_pose(app, options.pose)->required();
  CLI::Option_group* motion = app.add_option_group("motion", "at most one of; otherwise it stands still");
  motion->add_option("--mass", options.mass, "falls and is pushed, with this mass [kg]")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("M");
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
  return obstacle;
}

}  // namespace hecaton::services::cli
