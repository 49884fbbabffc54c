#include "services/cli/describe_model.hpp"

#include <algorithm>
#include <cmath>

#include "services/command_line/quantities.hpp"
#include "services/command_line/table.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

using config::number_text;

const planner::Link& link_of_joint(const planner::RobotModel& model, int joint) {
  return *std::find_if(model.links.begin(), model.links.end(),
                       [&](const planner::Link& link) { return link.joint == joint; });
}

std::string type_name(planner::JointType type) {
  switch (type) {
    case planner::JointType::kFixed:
      return "fixed";
    case planner::JointType::kRevolute:
      return "revolute";
    case planner::JointType::kContinuous:
      return "continuous";
    case planner::JointType::kPrismatic:
      return "prismatic";
  }
  return "";
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
    const bool prismatic = link.joint_type == planner::JointType::kPrismatic;
    table.add({model.joint_names[j], type_name(link.joint_type), link.name,
               range_text(limits.lower[j], limits.upper[j]), number_text(limits.velocity[j]),
               number_text(limits.acceleration[j]), prismatic ? "m" : "rad"});
  }
  return table.text(palette);
}

/// What planners take for the shape in cells of fast geometry.
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
    std::string place;
    for (const double number : xyz_rpy_of(geometry.X_LS)) {
      place += (place.empty() ? "" : " ") + number_text(std::abs(number) < 1e-9 ? 0.0 : number);
    }
    table.add({model.links[geometry.link].name, shape_text(geometry.shape), place,
               geometry.excess_volume > 0.0 ? "+" + percent_text(geometry.excess_volume, 1.0) : "",
               fast_text(geometry)});
  }
  return table.text(palette);
}

}  // namespace

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
  };
  return std::visit(Visitor{}, shape);
}

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

namespace {

Json fast_json(const planner::LinkGeometry& geometry) {
  if (!geometry.capsule) return {{"shape", "itself"}, {"excess_volume", 0.0}};
  return {{"shape", shape_text(geometry.capsule->placed.capsule)}, {"excess_volume", geometry.capsule->excess_volume}};
}

}  // namespace

Json model_json(const planner::RobotModel& model, const planner::JointLimits& limits) {
  Json json{{"name", model.name}, {"links", model.links.size()}, {"tool_link", model.links[model.tool_link].name}};
  json["joints"] = Json::array();
  for (int j = 0; j < model.joints(); ++j) {
    const planner::Link& link = link_of_joint(model, j);
    json["joints"].push_back({{"name", model.joint_names[j]},
                              {"type", type_name(link.joint_type)},
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
  json["warnings"] = model.notes;
  return json;
}

std::string model_text(const planner::RobotModel& model, const planner::JointLimits& limits, const Palette& palette) {
  std::string out = palette.bold("robot " + model.name) + ": " + std::to_string(model.joints()) + " joints, " +
                    std::to_string(model.links.size()) + " links, tool frame on link " +
                    model.links[model.tool_link].name + "\n\n" + joint_table(model, limits, palette) + "\n" +
                    geometry_table(model, palette) + "\n";
  out += "self-collision: " + std::to_string(model.self_pairs.size()) + " of " + std::to_string(all_pairs(model)) +
         " pairs of shapes are checked, the others are filtered\n";
  for (const std::string& note : model.notes) out += palette.yellow("note") + ": " + note + "\n";
  return out;
}

}  // namespace hecaton::services::cli
