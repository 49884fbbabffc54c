#include <algorithm>

#include "services/cli/describe_model.hpp"
#include "services/command_line/quantities.hpp"
#include "services/command_line/table.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

using config::number_text;

std::string place_text(const world::Pose& pose) {
  std::string text;
  for (const double number : xyz_rpy_of(pose)) {
    text += (text.empty() ? "" : " ") + number_text(std::abs(number) < 1e-9 ? 0.0 : number);
  }
  return text;
}

/// As the cell file calls it.
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
               file.arm_hosts[i].host, place_text(planned.arm.X_WB), named});
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
               obstacle.attachment ? "" : place_text(obstacle.X_WO)});
  }
  return table.text(palette);
}

const char* severity_name(config::Severity severity) {
  switch (severity) {
    case config::Severity::kError:
      return "error";
    case config::Severity::kWarning:
      return "warning";
    case config::Severity::kNote:
      break;
  }
  return "note";
}

std::string findings_text(const Findings& findings, const Palette& palette) {
  std::string out;
  for (const config::Finding& finding : findings) {
    const std::string name = severity_name(finding.severity);
    out += (finding.severity == config::Severity::kError ? palette.red(name) : palette.yellow(name)) + ": " +
           finding.sentence + "\n";
  }
  return out + (out.empty() ? "" : "\n");
}

std::string verdict(const Findings& findings, const Palette& palette) {
  const auto count = [&](config::Severity severity) {
    return std::count_if(findings.begin(), findings.end(), [&](const auto& one) { return one.severity == severity; });
  };
  if (count(config::Severity::kError) > 0) return palette.red("this cell can start, but not do its work");
  const auto warnings = count(config::Severity::kWarning);
  if (warnings == 0) return palette.green("this cell can start");
  return palette.yellow("this cell can start, but mind the " +
                        (warnings == 1 ? std::string("warning") : std::to_string(warnings) + " warnings"));
}

}  // namespace

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
  json["findings"] = Json::array();
  for (const config::Finding& finding : findings) {
    json["findings"].push_back({{"severity", severity_name(finding.severity)}, {"sentence", finding.sentence}});
  }
  return json;
}

std::string cell_text(const config::CellFile& file, const Findings& findings, const Palette& palette) {
  const planner::Timing& timing = file.cell.timing;
  std::string out = palette.bold("cell " + file.cell.name) + ": DDS domain " + std::to_string(file.network.domain) +
                    ", planners every " + duration_text(timing.control_period) + ", drivers every " +
                    duration_text(timing.driver_period) + ", world every " + duration_text(timing.world_period) +
                    "\n\n" + arms_table(file, palette);
  if (!file.cell.scene.obstacles.empty()) out += "\n" + obstacles_table(file, palette);
  // Arms of one robot file and the same limits share a description.
  std::vector<const planner::Arm*> told;
  for (const planner::PlannedArm& planned : file.cell.arms) {
    const planner::Arm& arm = planned.arm;
    const bool same = std::any_of(told.begin(), told.end(), [&](const planner::Arm* other) {
      return other->model == arm.model && other->limits.lower == arm.limits.lower &&
             other->limits.upper == arm.limits.upper && other->limits.velocity == arm.limits.velocity &&
             other->limits.acceleration == arm.limits.acceleration;
    });
    if (same) continue;
    told.push_back(&arm);
    out += "\n" + palette.bold("arm " + arm.name) + ", " + model_text(*arm.model, arm.limits, palette);
  }
  return out + "\n" + findings_text(findings, palette) + verdict(findings, palette) + "\n";
}

}  // namespace hecaton::services::cli
