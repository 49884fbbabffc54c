#include "services/ros2_messages/cell_description.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "planner/model/kinematics.hpp"
#include "planner/model/outside_joints.hpp"
#include "planner/model/urdf_loader.hpp"

namespace hecaton::ros2 {
namespace {

std::string number(double value) {
  std::array<char, 32> text{};
  const int size = std::snprintf(text.data(), text.size(), "%.9g", value);
  return {text.data(), static_cast<std::size_t>(size)};
}

std::string numbers(const Eigen::Vector3d& v) {
  return number(v.x()) + " " + number(v.y()) + " " + number(v.z());
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string origin(const world::Pose& pose) {
  return "<origin xyz=\"" + numbers(pose.translation()) + "\" rpy=\"" + numbers(world::rpy_of(pose.linear())) + "\"/>";
}

/// Writes each shape as a visual and as a collision element.
struct ShapeWriter {
  std::string& out;
  const world::Pose& X_LS;

  void add(const world::Pose& pose, const std::string& geometry) const {
    for (const char* kind : {"visual", "collision"}) {
      out +=
          std::string("    <") + kind + ">" + origin(pose) + "<geometry>" + geometry + "</geometry></" + kind + ">\n";
    }
  }
  void sphere(const world::Pose& pose, double radius) const {
    add(pose, "<sphere radius=\"" + number(radius) + "\"/>");
  }
  void cylinder(double radius, double half_length) const {
    add(X_LS, "<cylinder radius=\"" + number(radius) + "\" length=\"" + number(2.0 * half_length) + "\"/>");
  }

  void operator()(const world::Box& box) const { add(X_LS, "<box size=\"" + numbers(2.0 * box.half_extents) + "\"/>"); }
  void operator()(const world::Sphere& ball) const { sphere(X_LS, ball.radius); }
  void operator()(const world::Cylinder& body) const { cylinder(body.radius, body.half_length); }
  void operator()(const world::Capsule& body) const {
    if (body.half_length > 0.0) cylinder(body.radius, body.half_length);
    for (const double end : {-body.half_length, body.half_length}) {
      sphere(X_LS * Eigen::Translation3d(0.0, 0.0, end), body.radius);
    }
  }
  void operator()(const world::Convex& body) const {
    Eigen::AlignedBox3d box;
    for (const auto& vertex : body.hull->vertices) box.extend(vertex);
    add(X_LS * Eigen::Translation3d(box.center()), "<box size=\"" + numbers(box.sizes()) + "\"/>");
  }
  void operator()(const world::Points& body) const {  // no link has this shape
    sphere(X_LS * Eigen::Translation3d(body.cloud->centre()), body.cloud->bounding_radius());
  }
};

/// Where each link is in its parent's frame when all joints are at zero.
std::vector<world::Pose> poses_in_parent(const planner::RobotModel& model) {
  planner::Kinematics kinematics;
  planner::place_links(model, world::Pose::Identity(), planner::JointVector::Zero(model.joints()), kinematics);
  std::vector<world::Pose> poses;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const int parent = model.links[i].parent;
    poses.push_back(parent < 0 ? world::Pose::Identity() : kinematics.X_WL[parent].inverse() * kinematics.X_WL[i]);
  }
  return poses;
}

void add_joint(const planner::Arm& arm, std::size_t link, const world::Pose& pose, const std::string& prefix,
               std::string& out) {
  const planner::Link& child = arm.model->links[link];
  const std::string parent = escaped(prefix + arm.model->links[static_cast<std::size_t>(child.parent)].name);
  const std::string type = child.joint < 0 ? "fixed" : planner::urdf_type(child.joint_type);
  out += "  <joint name=\"" + escaped(prefix + child.joint_name) + "\" type=\"" + type + "\">" + origin(pose) +
         "<parent link=\"" + parent + "\"/><child link=\"" + escaped(prefix + child.name) + "\"/>";
  if (child.joint >= 0) {
    const auto& limits = arm.limits;
    out += "<axis xyz=\"" + numbers(child.axis) + "\"/><limit";
    if (child.joint_type != planner::JointType::kContinuous) {
      out += " lower=\"" + number(limits.lower[child.joint]) + "\" upper=\"" + number(limits.upper[child.joint]) + "\"";
    }
    out += " velocity=\"" + number(limits.velocity[child.joint]) + "\" effort=\"0\"/>";
  }
  out += "</joint>\n";
}

void add_arm(const planner::Arm& arm, const std::string& prefix, std::string& out) {
  const planner::RobotModel& model = *arm.model;
  const auto poses = poses_in_parent(model);
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    out += "  <link name=\"" + escaped(prefix + model.links[i].name) + "\">\n";
    for (const planner::LinkGeometry& geometry : model.geometry) {
      if (geometry.link != static_cast<int>(i)) continue;
      // /tf moves the link: its own shape, not that around all its places.
      const planner::OutsideBody* body = planner::outside_body(model, geometry.shape);
      std::visit(ShapeWriter{out, body ? body->X_LS : geometry.X_LS}, body ? body->shape : geometry.shape);
    }
    out += "  </link>\n";
    if (model.links[i].parent >= 0) add_joint(arm, i, poses[i], prefix, out);
  }
}

/// A joint outside the chain moves the link.
bool moves_outside(const planner::RobotModel& model, const std::string& link) {
  return model.outside && std::any_of(model.outside->bodies.begin(), model.outside->bodies.end(),
                                      [&](const planner::OutsideBody& body) { return body.link == link; });
}

}  // namespace

std::string arm_urdf(const planner::Arm& arm) {
  std::string out = "<?xml version=\"1.0\"?>\n<robot name=\"" + escaped(arm.name) + "\">\n";
  add_arm(arm, "", out);
  return out + "</robot>\n";
}

std::string cell_urdf(const planner::Cell& cell) {
  std::string out =
      "<?xml version=\"1.0\"?>\n<robot name=\"" + escaped(cell.name) + "\">\n  <link name=\"" + kWorldFrame + "\"/>\n";
  for (const planner::PlannedArm& planned : cell.arms) {
    const planner::Arm& arm = planned.arm;
    const std::string prefix = prefixed(arm.name, "");
    out += "  <joint name=\"" + escaped(prefix) + "base_in_world\" type=\"fixed\">" + origin(arm.X_WB) +
           "<parent link=\"" + kWorldFrame + "\"/><child link=\"" + escaped(prefix + arm.model->links[0].name) +
           "\"/></joint>\n";
    add_arm(arm, prefix, out);
  }
  return out + "</robot>\n";
}

std::vector<LinkFrame> link_frames(const planner::RobotModel& model) {
  std::vector<LinkFrame> frames;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const planner::Link& link = model.links[i];
    if (link.parent < 0) continue;
    frames.push_back({link.parent, static_cast<int>(i), link.joint >= 0 || moves_outside(model, link.name)});
  }
  return frames;
}

}  // namespace hecaton::ros2
