/// hecaton obstacle add|replace|move|remove, attach, detach: edits of the world of a running cell.

#include "services/cli/command_obstacle.hpp"

#include <cstdio>
#include <memory>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/client/convert.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/config/cloud_file.hpp"
#include "services/config/obstacle_rules.hpp"
#include "services/config/text.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::services::cli {
namespace {

world::Shape make_points(const ObstacleOptions& options) {
  const auto radius = config::parse_number(options.points[1]);
  if (!radius) throw Failure(ExitCode::kBadInput, "--points " + options.points[1] + " must be a radius [m]");
  try {
    auto points = config::read_cloud_file(options.points[0], config::printable_path(options.points[0]));
    return world::Points{std::make_shared<const world::PointCloud>(std::move(points), *radius)};
  } catch (const std::invalid_argument& error) {
    throw Failure(ExitCode::kBadInput, std::string("--points ") + error.what());
  }
}

world::Shape make_shape(const ObstacleOptions& options) {
  if (!options.points.empty()) return make_points(options);
  if (options.type == nullptr) return world::Box{{0.5 * options.box[0], 0.5 * options.box[1], 0.5 * options.box[2]}};
  try {
    return config::make_shape(*options.type, options.sizes);
  } catch (const std::invalid_argument& error) {
    throw Failure(ExitCode::kBadInput, "--" + std::string(options.type->name) + " " + error.what());
  }
}

/// Length and direction; an arbitrary direction for a vector of length 0, which the rules forbid.
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

/// The option (and its part) for a key of the cell file's obstacles: "--box size[1]".
std::string option_of(const std::string& key, const ObstacleOptions& options) {
  const std::string shape = !options.points.empty()   ? "--points"
                            : options.type == nullptr ? "--box"
                                                      : "--" + std::string(options.type->name);
  const std::string motion = options.mass                ? "--mass"
                             : !options.conveyor.empty() ? "--conveyor"
                             : !options.sine.empty()     ? "--sine"
                                                         : "--circle";
  constexpr std::string_view kShape = "shapes[0].";
  constexpr std::string_view kMotion = "motion.";
  if (key == "name") return "NAME";
  if (key == "motion.mass") return motion;
  if (key == "shapes[0]") return shape;
  if (key.starts_with(kShape)) return shape + " " + key.substr(kShape.size());
  if (key.starts_with(kMotion)) return motion + " " + key.substr(kMotion.size());
  return "--" + key;
}

void add_shape(CLI::App& app, const config::ShapeType& type, ObstacleOptions& options) {
  const std::string option = "--" + std::string(type.name);
  const std::string description(type.description);
  if (type.sizes.size() == 1) {
    add_number(
        app, option,
        [&options, &type](double size) {
          options.type = &type;
          options.sizes = {size};
        },
        description);
  } else {
    add_numbers(app, option, options.sizes, type.sizes.size(), description)
        ->each([&options, &type](const std::string&) { options.type = &type; });
  }
}

constexpr const char* kPoseHelp = "x y z [m] roll pitch yaw [rad] in the cell's frame";
constexpr const char* kRejections =
    "The rules are those of the cell file: sizes, names, no obstacle in contact with an arm, no carried object far "
    "from "
    "the tool. Exit code 1: the world service rejects the edit, and nothing changes.";

/// The world service alone checks and applies edits: no supervisor is needed.
ExitCode edit(const Settings& settings, const msg::WorldEditRequest& request, const std::string& done) {
  const msg::WorldEditReply reply = connect(settings)->edit(request, answer_limit(settings));
  const Cause cause = client::to_public(reply.cause());
  if (!reply.done()) throw Rejected(cause);
  if (cause) std::fprintf(stderr, "done, but %s\n", cause.text.c_str());
  print(settings, {{"done", true}, {"name", request.name()}, {"edition", reply.edition()}}, done + "\n");
  return ExitCode::kDone;
}

msg::WorldEditRequest request_for(msg::EditKind kind, const std::string& name) {
  msg::WorldEditRequest request;
  request.kind(kind);
  request.name(name);
  return request;
}

/// `add` or `replace`: edits with the same options.
void add_obstacle_put(CLI::App& app, Session& session, const char* command_name, const char* description,
                      msg::EditKind kind) {
  CLI::App* command = app.add_subcommand(command_name, description);
  auto options = std::make_shared<ObstacleOptions>();
  add_obstacle_options(*command, *options);
  command->callback([&session, options, kind] {
    const world::Obstacle obstacle = make_obstacle(*options);
    session.action = on_cell([&session, obstacle, kind] {
      msg::WorldEditRequest request = request_for(kind, obstacle.name);
      request.obstacle(messages::to_message(obstacle));
      const bool replaces = kind == msg::EditKind::EDIT_REPLACE;
      return edit(session.settings, request, (replaces ? "put " : "added ") + obstacle.name);
    });
  });
}

void add_obstacle_move(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("move", "Moves an obstacle to a pose and ends its scripted motion");
  auto name = std::make_shared<std::string>();
  auto pose = std::make_shared<std::vector<double>>();
  command->add_option("NAME", *name, "the obstacle")->required();
  add_pose(*command, "--pose", *pose, kPoseHelp)->required();
  command->callback([&session, name, pose] {
    session.action = on_cell([&session, name, pose] {
      msg::WorldEditRequest request = request_for(msg::EditKind::EDIT_MOVE, *name);
      request.X_WO(messages::to_message(pose_of(*pose)));
      return edit(session.settings, request, "moved " + *name);
    });
  });
}

void add_obstacle_remove(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("remove", "Removes an obstacle");
  auto name = std::make_shared<std::string>();
  command->add_option("NAME", *name, "the obstacle")->required();
  command->callback([&session, name] {
    session.action = on_cell([&session, name] {
      return edit(session.settings, request_for(msg::EditKind::EDIT_REMOVE, *name), "removed " + *name);
    });
  });
}

void add_carry(CLI::App& app, Session& session, const char* command_name, const char* description, msg::EditKind kind) {
  CLI::App* command = app.add_subcommand(command_name, description);
  auto arm = std::make_shared<std::string>();
  auto object = std::make_shared<std::string>();
  command->add_option("ARM", *arm, "name of the arm")->required();
  command->add_option("OBJECT", *object, "name of the obstacle")->required();
  command->footer(kRejections);
  command->callback([&session, arm, object, kind] {
    session.action = on_cell([&session, arm, object, kind] {
      msg::WorldEditRequest request = request_for(kind, *object);
      request.arm(*arm);
      const bool attach = kind == msg::EditKind::EDIT_ATTACH;
      return edit(session.settings, request, *arm + (attach ? " carries " : " has released ") + *object);
    });
  });
}

}  // namespace

void add_obstacle_options(CLI::App& app, ObstacleOptions& options) {
  app.add_option("NAME", options.name, "name of the obstacle")->required();
  CLI::Option_group* shape = app.add_option_group("shape", "one of");
  add_numbers(*shape, "--box", options.box, 3, "sizes along x y z [m]");
  for (const config::ShapeType& type : config::shape_types()) add_shape(*shape, type, options);
  shape
      ->add_option("--points", options.points,
                   "a file of points (.xyz, .pcd) and the radius of the balls about them [m]")
      ->expected(2)
      ->type_name("FILE RADIUS");
  shape->require_option(1);
  add_pose(app, "--pose", options.pose, kPoseHelp)->required();
  CLI::Option_group* motion = app.add_option_group("motion", "at most one of; none: static");
  add_number(
      *motion, "--mass", [&options](double mass) { options.mass = mass; }, "dynamic, with this mass [kg]");
  add_numbers(*motion, "--conveyor", options.conveyor, 4,
              "velocity vx vy vz [m/s] and length [m] of the path, which repeats");
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

void add_obstacle(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("obstacle", "Adds, replaces, moves or removes obstacles while the cell runs");
  command->require_subcommand(1);
  add_obstacle_put(*command, session, "add", "Adds an obstacle with a new name", msg::EditKind::EDIT_ADD);
  add_obstacle_put(
      *command, session, "replace",
      "Adds an obstacle in the place of the one with its name, if there is one: arms see either, never none",
      msg::EditKind::EDIT_REPLACE);
  add_obstacle_move(*command, session);
  add_obstacle_remove(*command, session);
  command->footer(kRejections);
}

void add_carry_commands(CLI::App& app, Session& session) {
  add_carry(app, session, "attach",
            "Attaches an object to the tool of an arm at its present pose: it becomes part of the arm",
            msg::EditKind::EDIT_ATTACH);
  add_carry(app, session, "detach",
            "Detaches a carried object: dynamic objects fall, others stay at their present pose",
            msg::EditKind::EDIT_DETACH);
}

}  // namespace hecaton::services::cli
