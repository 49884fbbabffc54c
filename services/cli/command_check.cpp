/// hecaton check: validates a cell file or a URDF and explains it.

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "planner/model/collision_filter.hpp"
#include "planner/model/robot_model.hpp"
#include "planner/model/urdf_loader.hpp"
#include "planner/simulation/batch.hpp"
#include "services/arm_driver/device_choice.hpp"
#include "services/arm_driver/taken_ports.hpp"
#include "services/cli/cell_draft.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/robot_options.hpp"
#include "services/cli/task_report.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/robot_catalogue.hpp"
#include "services/config/text.hpp"
#include "services/config/this_machine.hpp"
#include "services/config/validate.hpp"
#include "services/runtime/join.hpp"
#include "services/security/keystore.hpp"
#include "services/security/ros2_enclave.hpp"

namespace hecaton::services::cli {
namespace {

using config::number_text;
using Findings = std::vector<config::Finding>;

/// "box 0.4 × 0.4 × 0.2 m" (full sizes), "convex hull, 24 vertices"
std::string shape_text(const world::Shape& shape) {
  struct Visitor {
    std::string operator()(const world::Box& box) const {
      const Eigen::Vector3d size = 2.0 * box.half_extents;
      return "box " + number_text(size.x()) + " × " + number_text(size.y()) + " × " + number_text(size.z()) + " m";
    }
    std::string operator()(const world::Sphere& sphere) const {
      return "sphere, radius " + number_text(sphere.radius) + " m";
    }
    std::string operator()(const world::Capsule& capsule) const {
      if (capsule.half_length < 1e-9) return operator()(world::Sphere{capsule.radius});
      return "capsule, radius " + number_text(capsule.radius) + " m, segment " +
             number_text(2.0 * capsule.half_length) + " m";
    }
    std::string operator()(const world::Cylinder& cylinder) const {
      return "cylinder, radius " + number_text(cylinder.radius) + " m, height " +
             number_text(2.0 * cylinder.half_length) + " m";
    }
    std::string operator()(const world::Convex& convex) const {
      return "convex hull, " + std::to_string(convex.hull->vertices.size()) + " vertices";
    }
    std::string operator()(const world::Points& points) const {
      return std::to_string(points.cloud->size()) + " points, radius " + number_text(points.cloud->radius()) + " m";
    }
  };
  return std::visit(Visitor{}, shape);
}

/// "static", "waypoints", …
std::string motion_text(const world::Motion& motion) {
  struct Visitor {
    std::string operator()(const world::StaticMotion&) const { return "static"; }
    std::string operator()(const world::WaypointMotion&) const { return "waypoints"; }
    std::string operator()(const world::CircleMotion&) const { return "circle"; }
    std::string operator()(const world::SineMotion&) const { return "sine"; }
    std::string operator()(const world::ConveyorMotion&) const { return "conveyor"; }
    std::string operator()(const world::DynamicMotion&) const { return "dynamic"; }
  };
  return std::visit(Visitor{}, motion);
}

/// "x y z roll pitch yaw", without digits below 1e-9.
std::string pose_text(const world::Pose& pose) {
  std::string text;
  for (const double number : xyz_rpy_of(pose)) {
    text += (text.empty() ? "" : " ") + number_text(std::abs(number) < 1e-9 ? 0.0 : number);
  }
  return text;
}

/// The first link that the joint moves.
const planner::Link& link_of_joint(const planner::RobotModel& model, int joint) {
  return *std::find_if(model.links.begin(), model.links.end(),
                       [&](const planner::Link& link) { return link.joint == joint; });
}

std::string range_text(double lower, double upper) {
  if (!std::isfinite(lower) || !std::isfinite(upper)) return "unlimited";
  return decimal_text(lower, 3) + " … " + decimal_text(upper, 3);
}

std::size_t all_pairs(const planner::RobotModel& model) {
  const std::size_t n = model.geometry.size();
  return n * (n - 1) / 2;
}

std::string joint_table(const planner::RobotModel& model, const planner::JointLimits& limits, const Palette& palette) {
  Table table({{"joint"},
               {"type"},
               {"moves"},
               {"range", Align::kRight},
               {"velocity", Align::kRight},
               {"acceleration", Align::kRight},
               {"unit"}});
  for (int j = 0; j < model.joints(); ++j) {
    const planner::Link& link = link_of_joint(model, j);
    const planner::JointType type = joint_type(model, j);
    table.add({model.joint_names[j], planner::urdf_type(type), link.name, range_text(limits.lower[j], limits.upper[j]),
               number_text(limits.velocity[j]), number_text(limits.acceleration[j]),
               type == planner::JointType::kPrismatic ? "m" : "rad"});
  }
  return table.text(palette);
}

/// The shape that planners use in cells with fast geometry.
std::string fast_text(const planner::LinkGeometry& geometry) {
  if (!geometry.capsule) return "itself";
  return shape_text(geometry.capsule->placed.capsule) + ", +" + percent_text(geometry.capsule->excess_volume, 1.0);
}

std::string geometry_table(const planner::RobotModel& model, const Palette& palette) {
  Table table({{"link"},
               {"collision shape"},
               {"at xyz [m], rpy [rad]"},
               {"excess volume", Align::kRight},
               {"as fast geometry"}});
  for (const planner::LinkGeometry& geometry : model.geometry) {
    table.add({model.links[geometry.link].name, shape_text(geometry.shape), pose_text(geometry.X_LS),
               geometry.excess_volume > 0.0 ? "+" + percent_text(geometry.excess_volume, 1.0) : "",
               fast_text(geometry)});
  }
  return table.text(palette);
}

Json fast_json(const planner::LinkGeometry& geometry) {
  if (!geometry.capsule) return {{"shape", "itself"}, {"excess_volume", 0.0}};
  return {{"shape", shape_text(geometry.capsule->placed.capsule)}, {"excess_volume", geometry.capsule->excess_volume}};
}

Findings notes_of(const planner::RobotModel& model) {
  Findings notes;
  for (const std::string& note : model.notes) notes.push_back({config::Severity::kNote, note});
  for (const std::string& note : model.details) notes.push_back({config::Severity::kNote, note});
  return notes;
}

/// `limits`: of the cell file, which may be tighter than the model's.
Json model_json(const planner::RobotModel& model, const planner::JointLimits& limits) {
  Json json{{"name", model.name}, {"links", model.links.size()}, {"tool_link", model.links[model.tool_link].name}};
  json["joints"] = Json::array();
  for (int j = 0; j < model.joints(); ++j) {
    const planner::Link& link = link_of_joint(model, j);
    json["joints"].push_back({{"name", model.joint_names[j]},
                              {"type", planner::urdf_type(joint_type(model, j))},
                              {"link", link.name},
                              {"lower", limits.lower[j]},
                              {"upper", limits.upper[j]},
                              {"velocity", limits.velocity[j]},
                              {"acceleration", limits.acceleration[j]}});
  }
  json["geometry"] = Json::array();
  for (const planner::LinkGeometry& geometry : model.geometry) {
    json["geometry"].push_back({{"link", model.links[geometry.link].name},
                                {"shape", shape_text(geometry.shape)},
                                {"xyz_rpy", xyz_rpy_of(geometry.X_LS)},
                                {"excess_volume", geometry.excess_volume},
                                {"fast", fast_json(geometry)}});
  }
  json["self_pairs"] = {{"all", all_pairs(model)},
                        {"checked", model.self_pairs.size()},
                        {"filtered", all_pairs(model) - model.self_pairs.size()}};
  json["findings"] = findings_json(notes_of(model));
  return json;
}

/// The notes of the model, `with_details` or without them. `who` begins each.
std::string notes_text(const planner::RobotModel& model, const std::string& who, bool with_details,
                       const Palette& palette) {
  std::string out;
  const auto add = [&](const std::string& note) { out += palette.yellow("note") + ": " + who + note + "\n"; };
  for (const std::string& note : model.notes) add(note);
  if (!with_details) return out;
  for (const std::string& note : model.details) add(note);
  return out;
}

std::string model_text(const planner::RobotModel& model, const planner::JointLimits& limits, bool details,
                       const Palette& palette) {
  std::string out = palette.bold("robot " + model.name) + ": " + std::to_string(model.joints()) + " joints, " +
                    std::to_string(model.links.size()) + " links, tool frame on link " +
                    model.links[model.tool_link].name + "\n\n" + joint_table(model, limits, palette) + "\n" +
                    geometry_table(model, palette) + "\n";
  out += "self-collision: " + std::to_string(model.self_pairs.size()) + " of " + std::to_string(all_pairs(model)) +
         " pairs of shapes are checked, all others are filtered\n";
  return out + notes_text(model, "", details, palette);
}

/// "arm left: tool frame on link J6; 7 shapes, up to 101 % larger than their meshes (J1); 12 of 21 pairs …"
std::string summary_text(const planner::Arm& arm, const Palette& palette) {
  const planner::RobotModel& model = *arm.model;
  const auto loosest =
      std::max_element(model.geometry.begin(), model.geometry.end(),
                       [](const auto& one, const auto& other) { return one.excess_volume < other.excess_volume; });
  std::string out = palette.bold("arm " + arm.name) + ": tool frame on link " + model.links[model.tool_link].name +
                    "; " + std::to_string(model.geometry.size()) + " shapes";
  if (loosest != model.geometry.end() && loosest->excess_volume > 0.0) {
    out += ", up to " + percent_text(loosest->excess_volume, 1.0) + " larger than their meshes (" +
           model.links[loosest->link].name + ")";
  }
  return out + "; self-collision of " + std::to_string(model.self_pairs.size()) + " of " +
         std::to_string(all_pairs(model)) + " pairs is checked\n";
}

/// The word of the cell file.
const char* shapes_name(planner::LinkShapes shapes) {
  return shapes == planner::LinkShapes::kFast ? "fast" : "exact";
}

Json named_json(const planner::Arm& arm) {
  Json named = Json::object();
  for (const auto& [name, q] : arm.named) named[name] = std::vector<double>(q.begin(), q.end());
  return named;
}

Json arm_json(const planner::PlannedArm& planned, const config::ArmHosts& hosts) {
  const planner::Arm& arm = planned.arm;
  return {{"name", arm.name},
          {"method", planned.parameters.method->traits().name},
          {"geometry", shapes_name(arm.shapes)},
          {"host", hosts.host},
          {"standby_host", hosts.standby_host},
          {"base_xyz_rpy", xyz_rpy_of(arm.X_WB)},
          {"named", named_json(arm)},
          {"model", model_json(*arm.model, arm.limits)}};
}

std::string arms_table(const config::CellFile& file, const Palette& palette) {
  Table table({{"arm"},
               {"robot"},
               {"joints", Align::kRight},
               {"method"},
               {"geometry"},
               {"host"},
               {"base xyz [m], rpy [rad]"},
               {"named poses"}});
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const planner::PlannedArm& planned = file.cell.arms[i];
    std::string named;
    for (const auto& [name, q] : planned.arm.named) named += (named.empty() ? "" : ", ") + name;
    table.add({planned.arm.name, planned.arm.model->name, std::to_string(planned.arm.model->joints()),
               std::string(planned.parameters.method->traits().name), shapes_name(planned.arm.shapes),
               file.arm_hosts[i].host, pose_text(planned.arm.X_WB), named});
  }
  return table.text(palette);
}

std::string obstacles_table(const config::CellFile& file, const Palette& palette) {
  Table table({{"obstacle"}, {"shape"}, {"motion"}, {"starts at xyz [m], rpy [rad]"}});
  for (const world::Obstacle& obstacle : file.cell.scene.obstacles) {
    std::string shapes = shape_text(obstacle.shapes.front().shape);
    if (obstacle.shapes.size() > 1) shapes += " and " + std::to_string(obstacle.shapes.size() - 1) + " more";
    table.add({obstacle.name, shapes,
               obstacle.attachment ? "carried by " + obstacle.attachment->arm : motion_text(obstacle.motion),
               obstacle.attachment ? "" : pose_text(obstacle.X_WO)});
  }
  return table.text(palette);
}

std::string findings_text(const Findings& findings, const Palette& palette) {
  std::string out;
  for (const config::Finding& finding : findings) {
    const std::string name = config::name_of(finding.severity);
    out += (finding.severity == config::Severity::kError ? palette.red(name) : palette.yellow(name)) + ": " +
           finding.sentence + "\n";
  }
  return out + (out.empty() ? "" : "\n");
}

std::string verdict(const Findings& findings, const Palette& palette) {
  const auto count = [&](config::Severity severity) {
    return std::count_if(findings.begin(), findings.end(), [&](const auto& one) { return one.severity == severity; });
  };
  if (count(config::Severity::kError) > 0) return palette.red("this cell can start, but cannot do its tasks");
  const auto warnings = count(config::Severity::kWarning);
  if (warnings == 0) return palette.green("this cell can start");
  return palette.yellow("this cell can start, with " +
                        (warnings == 1 ? std::string("1 warning") : std::to_string(warnings) + " warnings"));
}

Json cell_json(const config::CellFile& file, const Findings& findings) {
  Json json{{"cell", file.cell.name}, {"domain", file.network.domain}};
  json["hosts"] = Json::array();
  for (const config::Host& host : file.hosts) json["hosts"].push_back({{"name", host.name}, {"address", host.address}});
  json["arms"] = Json::array();
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    json["arms"].push_back(arm_json(file.cell.arms[i], file.arm_hosts[i]));
  }
  json["obstacles"] = Json::array();
  for (const world::Obstacle& obstacle : file.cell.scene.obstacles) {
    Json shapes = Json::array();
    for (const world::PlacedShape& placed : obstacle.shapes) shapes.push_back(shape_text(placed.shape));
    json["obstacles"].push_back({{"name", obstacle.name},
                                 {"shapes", shapes},
                                 {"motion", motion_text(obstacle.motion)},
                                 {"attached_to", obstacle.attachment ? obstacle.attachment->arm : ""},
                                 {"xyz_rpy", xyz_rpy_of(obstacle.X_WO)}});
  }
  json["findings"] = findings_json(findings);
  return json;
}

/// Without `details` an arm has one line, and the notes that its user may act on.
std::string cell_text(const config::CellFile& file, const Findings& findings, bool details, const Palette& palette) {
  const planner::Timing& timing = file.cell.timing;
  std::string out = palette.bold("cell " + file.cell.name) + ": DDS domain " + std::to_string(file.network.domain) +
                    ", planners every " + duration_text(timing.control_period) + ", drivers every " +
                    duration_text(timing.driver_period) + ", world every " + duration_text(timing.world_period) +
                    "\n\n" + arms_table(file, palette);
  if (!file.cell.scene.obstacles.empty()) out += "\n" + obstacles_table(file, palette);
  if (!details) out += "\n";
  // Arms with the same robot and limits share a description.
  std::vector<const planner::Arm*> described;
  std::string notes;
  for (const planner::PlannedArm& planned : file.cell.arms) {
    const planner::Arm& arm = planned.arm;
    const bool same = std::any_of(described.begin(), described.end(), [&](const planner::Arm* other) {
      return other->model == arm.model && other->limits.lower == arm.limits.lower &&
             other->limits.upper == arm.limits.upper && other->limits.velocity == arm.limits.velocity &&
             other->limits.acceleration == arm.limits.acceleration;
    });
    if (same) continue;
    described.push_back(&arm);
    if (details) {
      out += "\n" + palette.bold("arm " + arm.name) + ", " + model_text(*arm.model, arm.limits, true, palette);
    } else {
      out += summary_text(arm, palette);
      notes += notes_text(*arm.model, "arm " + arm.name + ": ", false, palette);
    }
  }
  return out + "\n" + notes + findings_text(findings, palette) + verdict(findings, palette) + "\n" +
         (details ? "" : "joints, limits, shapes and pairs: hecaton check " + shell_word(file.path) + " --details\n") +
         next_steps(file, findings);
}

struct CheckOptions {
  std::string file;
  bool details = false;
  RobotOptions robot;
};

/// The arms of a robot of the catalogue that has two, as words of `hecaton init`; empty: another robot.
std::string both_arms(const std::string& robot) {
  const std::vector<config::RobotTool> tools = config::tools_of(robot);
  if (tools.size() != 2) return {};
  return "left=" + robot + ":" + tools[0].link + " right=" + robot + ":" + tools[1].link;
}

/// How to draft a cell with the robot.
std::string first_steps(const CheckOptions& options) {
  const std::string both = both_arms(options.file);
  const std::string link = options.robot.tool.empty() ? "" : ":" + shell_word(options.robot.tool);
  return "next: hecaton init -o cell.yaml " +
         (both.empty() || !link.empty() ? "left=" + shell_word(options.file) + link + "@\"0 0 0\"" : both) +
         words_of(options.robot.files) + "\n";
}

ExitCode check_urdf(const Settings& settings, const CheckOptions& options) {
  planner::RobotModel model = *load_robot(options.file, options.robot);
  if (!config::means_robot(options.file)) {
    model.notes.push_back("a URDF has no accelerations: every joint is assumed to reach its velocity limit in " +
                          number_text(planner::kAssumedRunUp) + " s");
  }
  if (!config::means_robot(options.file) && config::is_robot_name(options.file)) {
    model.notes.push_back("the file '" + options.file + "' is read, not the robot of this name in `hecaton robots`; " +
                          "rename the file to use the robot");
  }
  print(settings, model_json(model, model.limits),
        model_text(model, model.limits, options.details, Palette::for_stream(stdout)) + first_steps(options));
  return ExitCode::kDone;
}

constexpr int kEpisodes = 5;  // in which hecaton check tries to draw a task

/// What hecaton simulate would say instead of a report.
void check_draws(const config::CellFile& file, Findings& findings) {
  const bool has_error = !findings.empty() && findings.front().severity == config::Severity::kError;
  if (has_error || !has_tasks(file)) return;
  const auto reason = planner::why_no_task(file.cell, kEpisodes);
  if (!reason) return;
  findings.insert(findings.begin(),
                  config::Finding{config::Severity::kError, "tasks: no task can be drawn: " + *reason});
}

/// The cell may run already: then its own drivers hold the ports.
void check_ports(const config::CellFile& file, Findings& findings) {
  for (TakenPort& port : taken_ports(file)) {
    findings.push_back({port.by_driver ? config::Severity::kNote : config::Severity::kWarning, std::move(port.text)});
  }
  std::stable_sort(findings.begin(), findings.end(),
                   [](const auto& a, const auto& b) { return a.severity > b.severity; });
}

/// A file of the enclave that exists and that this user may not read; empty: none.
std::string unreadable_in(const std::string& enclave) {
  if (enclave.empty()) return {};
  for (const char* name : {"", "/cert.pem", "/key.pem", "/permissions.p7s"}) {
    if (::access((enclave + name).c_str(), R_OK) != 0 && errno == EACCES) return enclave + name;
  }
  return {};
}

/// Throws when hecaton-ros2 cannot use ros2.enclave.
void require_enclave(const config::CellFile& file) {
  const std::string& folder = file.ros2->enclave;
  try {
    if (!folder.empty()) static_cast<void>(read_ros2_enclave(folder));
  } catch (const KeystoreError& error) {
    std::string what = error.what();  // "FOLDER/FILE: is missing"
    if (const auto colon = what.find(": ", folder.size()); colon != std::string::npos) what.erase(colon, 1);
    const std::string remedy = "`ros2 security create_enclave` makes";
    if (what.find(remedy) == std::string::npos) what += "; " + remedy + " an enclave";
    throw std::runtime_error(file.path + ": ros2.enclave = " + folder +
                             " must be a folder with valid keys of ROS 2, but " + what);
  }
}

/// Throws when hecaton-ros2 could not start here. When it runs on another machine, that is a note.
void check_ros2(const config::CellFile& file, Findings& findings) {
  if (!file.ros2) return;
  const auto note = [&](std::string text) { findings.push_back({config::Severity::kNote, std::move(text)}); };
  const std::string unreadable = unreadable_in(file.ros2->enclave);
  const auto require = [&] {
    static_cast<void>(interface_addresses(file, "ros2.interface", file.ros2->interface));
    if (unreadable.empty()) require_enclave(file);
  };
  if (config::is_this_machine(file, file.ros2->host)) {
    require();
    if (unreadable.empty()) return;
    return note("ros2.enclave = " + file.ros2->enclave + " is not checked, because this user may not read " +
                unreadable + "; check the cell as the user of hecaton-ros2");
  }
  try {
    require();
  } catch (const std::runtime_error& error) {
    note("ros2.host = " + file.ros2->host + " is another machine; check the cell there, because here " + error.what());
  }
}

ExitCode check_cell(const Settings& settings, const CheckOptions& options) {
  const config::CellFile file = config::load_cell_file(options.file);
  require_interface(file);
  require_known_devices(file);
  Findings findings = config::validate(file);
  check_ports(file, findings);
  check_ros2(file, findings);
  for (std::string& note : device_notes(file)) findings.push_back({config::Severity::kNote, std::move(note)});
  check_draws(file, findings);
  print(settings, cell_json(file, findings), cell_text(file, findings, options.details, Palette::for_stream(stdout)));
  const bool works = findings.empty() || findings.front().severity != config::Severity::kError;  // errors come first
  return works ? ExitCode::kDone : ExitCode::kBadInput;
}

}  // namespace

void add_check(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("check", "Validates a cell file or a robot and describes it, without starting a process");
  auto options = std::make_shared<CheckOptions>();
  command->add_option("FILE", options->file, "cell file (YAML), robot description (URDF) or name of a robot")
      ->required();
  command->add_flag("--details", options->details,
                    "also each joint, limit and shape, and how meshes and link pairs were simplified");
  add_robot_options(*command, options->robot);
  command->footer("Exit code 3 when the file is wrong, or when hecaton simulate could draw no task.");
  command->callback([&session, options, command] {
    session.action = [&session, options, command] {
      if (is_robot(options->file)) return check_urdf(session.settings, *options);
      refuse_robot_options(*command);
      return check_cell(session.settings, *options);
    };
  });
}

}  // namespace hecaton::services::cli
