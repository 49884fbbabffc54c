/// hecaton robots: the robots that cell files and commands know by name.

#include <memory>

#include <CLI/CLI.hpp>

#include "planner/model/urdf_loader.hpp"
#include "services/cli/commands.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/robot_catalogue.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

using config::NamedRobot;
using config::number_text;

/// The arm that ends in the tool.
std::shared_ptr<const planner::RobotModel> model_of(const NamedRobot& robot, const config::RobotTool& tool) {
  planner::UrdfOptions options;
  options.tool_link = tool.link;
  return planner::load_urdf(robot.urdf, options);
}

bool slides(const planner::RobotModel& model, int joint) {
  return planner::joint_type(model, joint) == planner::JointType::kPrismatic;
}

Json tool_json(const NamedRobot& robot, const config::RobotTool& tool) {
  const auto model = model_of(robot, tool);
  Json joints = Json::array();
  for (int j = 0; j < model->joints(); ++j) {
    joints.push_back({{"name", model->joint_names[j]},
                      {"unit", slides(*model, j) ? "m" : "rad"},
                      {"lower", model->limits.lower[j]},
                      {"upper", model->limits.upper[j]},
                      {"velocity", model->limits.velocity[j]},
                      {"acceleration", robot.acceleration[j]}});
  }
  Json poses = Json::object();
  for (const auto& [name, q] : tool.poses) poses[name] = q;
  return {{"link", tool.link}, {"joints", joints}, {"poses", poses}};
}

Json robot_json(const NamedRobot& robot) {
  Json tools = Json::array();
  for (const config::RobotTool& tool : robot.tools) tools.push_back(tool_json(robot, tool));
  return {{"name", robot.name}, {"title", robot.title}, {"reach_m", robot.reach},   {"payload_kg", robot.payload},
          {"urdf", robot.urdf}, {"tools", tools},       {"sources", robot.sources}, {"approximate", robot.approximate}};
}

/// "6", or "7 + 7" for two arms.
std::string joints_text(const NamedRobot& robot) {
  std::string text;
  for (const config::RobotTool& tool : robot.tools) {
    text.append(text.empty() ? "" : " + ").append(std::to_string(tool.poses.at("home").size()));
  }
  return text;
}

std::string robots_table(const std::vector<NamedRobot>& robots, const Palette& palette) {
  Table table({{"robot"},
               {"product"},
               {"joints", Align::kRight},
               {"reach [m]", Align::kRight},
               {"payload [kg]", Align::kRight}});
  for (const NamedRobot& robot : robots) {
    table.add({robot.name, robot.title, joints_text(robot), number_text(robot.reach), number_text(robot.payload)});
  }
  return table.text(palette) +
         "\njoints, limits, poses, sources and what is approximate: hecaton robots NAME\n"
         "another robot: every command takes the path of its URDF in place of a name\n";
}

std::string robot_text(const NamedRobot& robot, const Palette& palette) {
  std::string out = palette.bold(robot.name) + ": " + robot.title + ", reach " + number_text(robot.reach) +
                    " m, payload " + number_text(robot.payload) + " kg\n";
  for (const config::RobotTool& tool : robot.tools) {
    const auto model = model_of(robot, tool);
    Table table({{"joint"},
                 {"lower", Align::kRight},
                 {"upper", Align::kRight},
                 {"velocity", Align::kRight},
                 {"acceleration", Align::kRight},
                 {"unit"},
                 {"home", Align::kRight}});
    for (int j = 0; j < model->joints(); ++j) {
      table.add({model->joint_names[j], number_text(model->limits.lower[j]), number_text(model->limits.upper[j]),
                 number_text(model->limits.velocity[j]), number_text(robot.acceleration[j]),
                 slides(*model, j) ? "m" : "rad", number_text(tool.poses.at("home")[j])});
    }
    out += "\ntool link " + tool.link + ", poses";
    for (const auto& [name, q] : tool.poses) out += " " + name;
    out += "\n" + table.text(palette);
  }
  out += "\n";
  for (const std::string& sentence : robot.sources) out += "source: " + sentence + "\n";
  for (const std::string& sentence : robot.approximate) out += palette.yellow("approximate") + ": " + sentence + "\n";
  return out + "URDF: " + robot.urdf + "\n";
}

ExitCode run_robots(const Settings& settings, const std::string& name) {
  planner::SourceFiles sources;
  std::vector<NamedRobot> robots;
  const bool all = name.empty();
  for (const std::string& one : all ? config::robot_names() : std::vector<std::string>{name}) {
    robots.push_back(config::read_named_robot(one, sources));
  }
  if (robots.empty()) throw Failure(ExitCode::kBadInput, config::robot_suggestion(name));
  Json json{{"robots", Json::array()}};
  for (const NamedRobot& robot : robots) json["robots"].push_back(robot_json(robot));
  const Palette palette = Palette::for_stream(stdout);
  print(settings, json, all ? robots_table(robots, palette) : robot_text(robots.front(), palette));
  return ExitCode::kDone;
}

}  // namespace

void add_robots(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand(
      "robots", "Lists the robots that `robot:` in a cell file, and commands in place of a URDF, know by name");
  auto name = std::make_shared<std::string>();
  command->add_option("ROBOT", *name, "only this one, with joints, home pose, sources and what is approximate");
  command->footer("The environment variable HECATON_ROBOTS names another folder of robots.");
  command->callback(
      [&session, name] { session.action = [&session, name] { return run_robots(session.settings, *name); }; });
}

}  // namespace hecaton::services::cli
