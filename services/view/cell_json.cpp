#include "services/view/cell_json.hpp"

#include <cmath>
#include <variant>

#include "planner/model/capsules.hpp"
#include "services/runtime/version.hpp"

namespace hecaton::services::view {
namespace {

/// The page shows at most this many points of a cloud.
constexpr std::size_t kMostShown = 20'000;

struct ShapeFields {
  Json operator()(const world::Box& box) const {
    return {{"kind", "box"}, {"size", vector_json(2.0 * box.half_extents)}};
  }
  Json operator()(const world::Sphere& sphere) const { return {{"kind", "sphere"}, {"radius", sphere.radius}}; }
  Json operator()(const world::Capsule& capsule) const {
    return {{"kind", "capsule"}, {"radius", capsule.radius}, {"length", 2.0 * capsule.half_length}};
  }
  Json operator()(const world::Cylinder& cylinder) const {
    return {{"kind", "cylinder"}, {"radius", cylinder.radius}, {"length", 2.0 * cylinder.half_length}};
  }
  Json operator()(const world::Convex& convex) const {
    Json vertices = Json::array();
    for (const Eigen::Vector3d& vertex : convex.hull->vertices) vertices.push_back(vector_json(vertex));
    return {{"kind", "convex"}, {"vertices", vertices}, {"faces", convex.hull->faces}};
  }
  Json operator()(const world::Points& points) const {
    const auto all = points.cloud->points();
    const std::size_t every = (all.size() + kMostShown - 1) / kMostShown;
    Json shown = Json::array();
    const auto millimetres = [](float x) { return std::round(1e3 * static_cast<double>(x)) / 1e3; };
    for (std::size_t i = 0; i < all.size(); i += every) {
      for (int axis = 0; axis < 3; ++axis) shown.push_back(millimetres(all[i][axis]));
    }
    return {{"kind", "points"}, {"radius", points.cloud->radius()}, {"count", all.size()}, {"points", shown}};
  }
};

Json capsule_json(const planner::PlacedCapsule& placed, const world::Pose& X_BS) {
  return {{"pose", pose_json(X_BS * placed.X_FS)},
          {"radius", placed.capsule.radius},
          {"length", 2.0 * placed.capsule.half_length}};
}

const char* joint_kind(planner::JointType type) {
  switch (type) {
    case planner::JointType::kRevolute:
    case planner::JointType::kContinuous:
      return "revolute";
    case planner::JointType::kPrismatic:
      return "prismatic";
    case planner::JointType::kFixed:
      break;
  }
  return "fixed";
}

Json numbers(const planner::JointVector& q) {
  return std::vector<double>(q.data(), q.data() + q.size());
}

Json links_json(const planner::RobotModel& model) {
  Json links = Json::array();
  for (const planner::Link& link : model.links) {
    links.push_back({{"name", link.name},
                     {"parent", link.parent},
                     {"pose", pose_json(link.X_PJ)},
                     {"axis", vector_json(link.axis)},
                     {"kind", joint_kind(link.joint_type)},
                     {"joint", link.joint},
                     {"multiplier", link.multiplier},
                     {"offset", link.offset}});
  }
  return links;
}

/// `planning`: the capsule with which planners measure distances, when it is not the shape itself.
Json shapes_json(const planner::Arm& arm) {
  Json shapes = Json::array();
  for (const planner::LinkGeometry& geometry : arm.model->geometry) {
    Json shape = shape_json(geometry.shape, geometry.X_LS);
    shape["link"] = geometry.link;
    shape["planning"] = nullptr;
    if (arm.shapes == planner::LinkShapes::kFast && geometry.capsule) {
      shape["planning"] = capsule_json(geometry.capsule->placed, geometry.X_LS);
    }
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

Json pose_names(const planner::Arm& arm) {
  Json names = Json::array();
  for (const auto& [name, q] : arm.named) names.push_back(name);
  return names;
}

Json arm_json(const planner::PlannedArm& planned, const ArmDrawing& drawing) {
  const planner::Arm& arm = planned.arm;
  const planner::RobotModel& model = *arm.model;
  return {{"name", arm.name},
          {"robot", model.name},
          {"base", pose_json(arm.X_WB)},
          {"links", links_json(model)},
          {"shapes", shapes_json(arm)},
          {"joints", model.joint_names},
          {"lower", numbers(arm.limits.lower)},
          {"upper", numbers(arm.limits.upper)},
          {"velocity", numbers(arm.limits.velocity)},
          {"start", numbers(planned.start.size() > 0 ? planned.start : arm.home())},
          {"poses", pose_names(arm)},
          {"tool_link", model.tool_link},
          {"tool", pose_json(model.X_LT)},
          {"security_distance", planned.parameters.damper.security_distance},
          {"influence_distance", planned.parameters.damper.influence_distance},
          {"method", std::string(planned.parameters.method->traits().name)},
          {"urdf", drawing.has_visuals ? Json(drawing.url) : Json(nullptr)},
          {"note", drawing.note}};
}

}  // namespace

Json shape_json(const world::Shape& shape, const world::Pose& X_BS) {
  Json json = std::visit(ShapeFields{}, shape);
  json["pose"] = pose_json(X_BS);
  json["capsule"] = capsule_json(planner::bounding_capsule(shape), X_BS);
  return json;
}

Json cell_json(const config::CellFile& file, const std::vector<ArmDrawing>& drawings) {
  Json json{{"type", "cell"}, {"name", file.cell.name}, {"version", kVersion}, {"floor", file.cell.scene.floor_z}};
  json["arms"] = Json::array();
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    json["arms"].push_back(arm_json(file.cell.arms[i], drawings[i]));
  }
  json["hosts"] = Json::array();
  for (const config::Host& host : file.hosts) json["hosts"].push_back(host.name);
  return json;
}

}  // namespace hecaton::services::view
