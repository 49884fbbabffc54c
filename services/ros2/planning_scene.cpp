#include "services/ros2/planning_scene.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "planner/model/convex_hull.hpp"
#include "services/bus/wire_rules.hpp"
#include "services/config/obstacle_rules.hpp"
#include "services/ros2_messages/cell_description.hpp"

namespace hecaton::ros2 {
namespace {

// moveit_msgs/msg/CollisionObject
enum Operation : std::uint8_t { kAdd = 0, kRemove = 1, kAppend = 2, kMove = 3 };
// shape_msgs/msg/SolidPrimitive
enum Primitive : std::uint8_t { kBox = 1, kSphere = 2, kCylinder = 3, kCone = 4, kPrism = 5 };

/// A mesh whose hull has more volume than this, relative to its own, is not convex.
constexpr double kHullExcess = 0.01;
constexpr std::size_t kMostVertices = 4096;

/// The reason why an object is refused.
class Refused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A name of the message in a sentence.
std::string quoted(const std::string& name) {
  return "'" + bus::printable(name, bus::kLongestName) + "'";
}

std::string index_text(const char* name, std::size_t index) {
  return std::string(name) + "[" + std::to_string(index) + "]";
}

bool is_zero(const Quaternion& q) {
  return q.x == 0.0 && q.y == 0.0 && q.z == 0.0 && q.w == 0.0;
}

/// A pose without values. MoveIt takes a quaternion of zeros for no rotation.
bool is_unset(const Pose& pose) {
  const Quaternion& o = pose.orientation;
  const bool no_rotation = is_zero(o) || (o.x == 0.0 && o.y == 0.0 && o.z == 0.0 && o.w == 1.0);
  return no_rotation && pose.position.x == 0.0 && pose.position.y == 0.0 && pose.position.z == 0.0;
}

world::Pose pose_from(const Pose& message, const std::string& what) {
  const Point& p = message.position;
  Quaternion o = message.orientation;
  if (is_zero(o)) o.w = 1.0;
  const double norm = std::sqrt(o.x * o.x + o.y * o.y + o.z * o.z + o.w * o.w);
  if (!std::isfinite(p.x + p.y + p.z) || !(std::abs(norm - 1.0) < 1e-2)) {
    throw Refused(what + " must have finite numbers and a unit quaternion");
  }
  world::Pose pose = world::Pose::Identity();
  pose.linear() = Eigen::Quaterniond(o.w, o.x, o.y, o.z).normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(p.x, p.y, p.z);
  return pose;
}

world::Shape shape_from(const SolidPrimitive& primitive, const std::string& what) {
  const auto& size = primitive.dimensions;
  const auto require = [&](std::size_t count) {
    if (size.size() == count) return;
    throw Refused(what + " has " + std::to_string(size.size()) + " dimensions, but its type has " +
                  std::to_string(count));
  };
  switch (primitive.type) {
    case kBox:
      require(3);
      return world::Box{{0.5 * size[0], 0.5 * size[1], 0.5 * size[2]}};
    case kSphere:
      require(1);
      return world::Sphere{size[0]};
    case kCylinder:
      require(2);
      return world::Cylinder{size[1], 0.5 * size[0]};
    case kCone:
      throw Refused(what + " is a cone, which is not supported; send a cylinder around it, or a convex mesh");
    case kPrism:
      throw Refused(what + " is a prism, which is not supported; send it as a convex mesh");
    default:
      throw Refused(what + ".type = " + std::to_string(primitive.type) + " must be BOX, SPHERE or CYLINDER");
  }
}

/// Of a closed surface with consistent orientation [m³].
double volume(const Mesh& mesh) {
  const auto vertex = [&](std::uint32_t index) {
    const Point& p = mesh.vertices[index];
    return Eigen::Vector3d(p.x, p.y, p.z);
  };
  double six = 0.0;
  for (const MeshTriangle& triangle : mesh.triangles) {
    const auto& corners = triangle.vertex_indices;
    six += vertex(corners[0]).dot(vertex(corners[1]).cross(vertex(corners[2])));
  }
  return std::abs(six) / 6.0;
}

world::Shape shape_from(const Mesh& mesh, const std::string& what) {
  if (mesh.vertices.size() > kMostVertices) {
    throw Refused(what + " has " + std::to_string(mesh.vertices.size()) + " vertices, but at most " +
                  std::to_string(kMostVertices) + " are allowed; simplify it");
  }
  for (const MeshTriangle& triangle : mesh.triangles) {
    for (const std::uint32_t index : triangle.vertex_indices) {
      if (index >= mesh.vertices.size()) throw Refused(what + ": a triangle has a vertex that does not exist");
    }
  }
  std::vector<Eigen::Vector3d> points;
  for (const Point& p : mesh.vertices) points.emplace_back(p.x, p.y, p.z);
  const auto hull = planner::convex_hull(points);
  if (!hull) throw Refused(what + " has no volume, or a coordinate that is not finite");
  if (!(planner::volume(*hull) <= (1.0 + kHullExcess) * volume(mesh))) {
    throw Refused(what + " is not convex or not closed; send convex parts as meshes of their own, or primitives");
  }
  return planner::convex_shape(points);
}

/// One object of a scene, with its frame.
class SceneObject {
 public:
  SceneObject(const CollisionObject& object, const SceneFrames& frames) : object_(object) {
    const std::string frame = object.header.frame_id.empty() ? kWorldFrame : object.header.frame_id;
    const auto found = frames.find(frame);
    if (found == frames.end()) {
      throw Refused("frame_id = " + quoted(frame) + " must be world, or a link of an arm whose state is known");
    }
    X_WF_ = found->second.X_WF;
  }

  /// Poses are those of the message. A single shape in an object without a pose gives the object its own pose, as
  /// MoveIt does.
  [[nodiscard]] world::Obstacle obstacle() const {
    if (!object_.planes.empty()) throw Refused("planes are not supported; send a box");
    world::Obstacle obstacle;
    obstacle.name = object_.id;
    obstacle.X_WO = X_WO();
    add(obstacle, object_.primitives, object_.primitive_poses, "primitive");
    add(obstacle, object_.meshes, object_.mesh_poses, "mesh");
    if (obstacle.shapes.size() == 1 && is_unset(object_.pose)) {
      obstacle.X_WO = obstacle.X_WO * obstacle.shapes[0].X_BS;
      obstacle.shapes[0].X_BS = world::Pose::Identity();
    }
    if (const auto complaint = config::complain(obstacle)) throw Refused(complaint->sentence());
    return obstacle;
  }
  /// The obstacle's name and pose.
  [[nodiscard]] world::Obstacle moved() const {
    if (has_shapes() || !object_.primitive_poses.empty() || !object_.mesh_poses.empty()) {
      throw Refused("MOVE must have no shapes and no poses of shapes; send ADD to replace the object");
    }
    world::Obstacle obstacle;
    obstacle.name = object_.id;
    obstacle.X_WO = X_WO();
    if (const auto complaint = config::complain(obstacle.X_WO, "pose")) throw Refused(complaint->sentence());
    return obstacle;
  }
  [[nodiscard]] bool has_shapes() const {
    return !object_.primitives.empty() || !object_.meshes.empty() || !object_.planes.empty();
  }

 private:
  [[nodiscard]] world::Pose X_WO() const { return X_WF_ * pose_from(object_.pose, "pose"); }

  /// A shape without a pose is at the object's frame.
  template <class T>
  static void add(world::Obstacle& obstacle, const std::vector<T>& shapes, const std::vector<Pose>& poses,
                  const std::string& kind) {
    if (poses.size() > shapes.size()) throw Refused(kind + "_poses must not be more than its shapes");
    if (obstacle.shapes.size() + shapes.size() > config::kMostShapes) {
      throw Refused("it has more than " + std::to_string(config::kMostShapes) + " shapes");
    }
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const world::Pose X_OS =
          i < poses.size() ? pose_from(poses[i], index_text((kind + "_poses").c_str(), i)) : world::Pose::Identity();
      obstacle.shapes.push_back({shape_from(shapes[i], index_text(kind.c_str(), i)), X_OS});
    }
  }

  const CollisionObject& object_;
  world::Pose X_WF_ = world::Pose::Identity();
};

void require_id(const CollisionObject& object) {
  if (object.id.empty() && object.operation == kRemove) return;  // all objects, as in MoveIt
  if (object.id.empty()) throw Refused("an object must have an id");
  if (object.id.size() > bus::kLongestName || bus::unprintable(object.id)) {
    throw Refused("an id must be printable and have at most " + std::to_string(bus::kLongestName) + " bytes");
  }
}

SceneEdit named(SceneEdit::Kind kind, const std::string& name) {
  SceneEdit edit{kind, {}};
  edit.obstacle.name = name;
  return edit;
}

SceneEdit edit_of(const CollisionObject& object, const SceneFrames& frames) {
  require_id(object);
  switch (object.operation) {
    case kAdd:
      return {SceneEdit::Kind::kAdd, SceneObject(object, frames).obstacle()};
    case kAppend:
      return {SceneEdit::Kind::kAppend, SceneObject(object, frames).obstacle()};
    case kMove:
      return {SceneEdit::Kind::kMove, SceneObject(object, frames).moved()};
    case kRemove:
      return named(object.id.empty() ? SceneEdit::Kind::kRemoveAll : SceneEdit::Kind::kRemove, object.id);
    default:
      throw Refused("operation = " + std::to_string(object.operation) + " must be ADD, REMOVE, APPEND or MOVE");
  }
}

SceneEdit edit_of(const AttachedCollisionObject& attached, const SceneFrames& frames) {
  const CollisionObject& object = attached.object;
  require_id(object);
  if (object.operation != kAdd && object.operation != kRemove) {
    throw Refused("operation = " + std::to_string(object.operation) + " of an attached object must be ADD or REMOVE");
  }
  const auto link = frames.find(attached.link_name);
  const bool any_arm = attached.link_name.empty() && object.operation == kRemove;
  if (!any_arm && (link == frames.end() || !link->second.carrier)) {
    throw Refused("link_name = " + quoted(attached.link_name) +
                  " must be a link that moves with the tool of an arm whose state is known");
  }
  const std::string arm = any_arm ? std::string() : *link->second.carrier;
  if (object.operation == kRemove) {
    SceneEdit edit = named(object.id.empty() ? SceneEdit::Kind::kDetachAll : SceneEdit::Kind::kDetach, object.id);
    edit.arm = arm;
    return edit;
  }
  const SceneObject with_frame(object, frames);
  if (!with_frame.has_shapes()) {
    SceneEdit edit = named(SceneEdit::Kind::kAttach, object.id);
    edit.arm = arm;
    return edit;
  }
  SceneEdit edit{SceneEdit::Kind::kAdd, with_frame.obstacle(), arm};
  edit.obstacle.attachment = {arm, link->second.X_WT.inverse() * edit.obstacle.X_WO};
  if (const auto complaint = config::complain(edit.obstacle)) throw Refused(complaint->sentence());
  return edit;
}

}  // namespace

void add_frames(SceneFrames& frames, const planner::Arm& arm, const planner::Kinematics& kinematics,
                const std::string& prefix) {
  const auto& links = arm.model->links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    // The link of the tool, or one that fixed joints lead to from it or from which they lead to it.
    const auto anchor = [&](int link) {
      while (links[link].joint < 0 && links[link].parent >= 0) link = links[link].parent;
      return link;
    };
    SceneFrame frame{kinematics.X_WL[i], std::nullopt, kinematics.X_WT};
    if (anchor(static_cast<int>(i)) == anchor(arm.model->tool_link)) frame.carrier = arm.name;
    frames.insert_or_assign(prefix + links[i].name, std::move(frame));
  }
}

SceneEdits edits_of(const PlanningScene& scene, const SceneFrames& frames) {
  SceneEdits result;
  if (!scene.is_diff) {
    result.refusals.push_back(
        {"", "is_diff = false: a whole scene would remove the obstacles of the cell file; send a diff"});
    return result;
  }
  const auto take = [&](const auto& message, const std::string& id) {
    try {
      result.edits.push_back(edit_of(message, frames));
    } catch (const Refused& refused) {
      result.refusals.push_back({bus::printable(id, bus::kLongestName), refused.what()});
    }
  };
  for (const AttachedCollisionObject& attached : scene.robot_state.attached_collision_objects) {
    take(attached, attached.object.id);
  }
  for (const CollisionObject& object : scene.world.collision_objects) take(object, object.id);
  if (!scene.world.octomap.octomap.data.empty()) {
    result.refusals.push_back({"", "an octomap is not supported; send collision objects"});
  }
  return result;
}

SceneEdits of_topic(SceneEdits scene, const std::string& arm) {
  for (SceneEdit& edit : scene.edits) {
    edit.source = arm;
    if (edit.kind == SceneEdit::Kind::kDetachAll && edit.arm.empty()) edit.arm = arm;
  }
  return scene;
}

}  // namespace hecaton::ros2
