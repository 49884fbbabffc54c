#include <algorithm>
#include <array>
#include <set>

#include "services/config/moveit_files.hpp"
#include "services/config/moveit_values.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

using namespace moveit;

constexpr std::array<std::string_view, 10> kSceneKeys = {"name",
                                                         "robot_state",
                                                         "robot_model_name",
                                                         "fixed_frame_transforms",
                                                         "allowed_collision_matrix",
                                                         "link_padding",
                                                         "link_scale",
                                                         "object_colors",
                                                         "world",
                                                         "is_diff"};
constexpr std::array<std::string_view, 2> kWorldKeys = {"collision_objects", "octomap"};
constexpr std::array<std::string_view, 13> kObjectKeys = {
    "header",     "pose",   "id",          "type",           "primitives",     "primitive_poses", "meshes",
    "mesh_poses", "planes", "plane_poses", "subframe_names", "subframe_poses", "operation"};
constexpr std::array<std::string_view, 3> kShapeKeys = {"type", "dimensions", "polygon"};
constexpr std::array<std::string_view, 3> kHeaderKeys = {"seq", "stamp", "frame_id"};
constexpr std::array<std::string_view, 3> kFixedKeys = {"header", "child_frame_id", "transform"};
/// Words, and SolidPrimitive's numbers for them.
constexpr std::array<std::string_view, 6> kPrimitives = {"box", "sphere", "cylinder", "1", "2", "3"};

/// The same in a scene's frames and in what they are called here.
struct Frames {
  std::span<const std::string> known;

  [[nodiscard]] bool has(const std::string& frame) const {
    return std::find(known.begin(), known.end(), frame) != known.end();
  }
  void check(const YamlView& header) const {
    check_keys(header, kHeaderKeys);
    const auto frame = header.entry("frame_id");
    if (!frame || !is_given(*frame) || has(frame->text())) return;
    const std::vector<std::string_view> words(known.begin(), known.end());
    frame->fail("empty or " + alternatives(words) + ": other frames are not read");
  }
};

std::size_t kind_of(const YamlView& type) {
  const auto named = std::span(kPrimitives).first(3);
  for (std::size_t i = 3; i < kPrimitives.size(); ++i) {
    if (type.value() == kPrimitives[i]) return i - 3;
  }
  return type.choice(named);
}

world::Shape primitive(const YamlView& view) {
  check_keys(view, kShapeKeys);
  const YamlView dimensions = required(view, "dimensions");
  const auto values = [&](std::size_t count, std::string_view of) {
    std::vector<double> result;
    for (const YamlView& item : dimensions.items(count, count, of)) result.push_back(item.number(kLength));
    return result;
  };
  switch (kind_of(required(view, "type"))) {
    case 0: {
      const auto size = values(3, "numbers [x, y, z] in m");
      return world::Box{0.5 * Eigen::Vector3d(size[0], size[1], size[2])};
    }
    case 1:
      return world::Sphere{values(1, "numbers [radius] in m")[0]};
    default: {
      const auto size = values(2, "numbers [height, radius] in m");
      return world::Cylinder{size[1], 0.5 * size[0]};
    }
  }
}

world::Obstacle collision_object(const YamlView& view, const Frames& frames) {
  check_keys(view, kObjectKeys);
  refuse_given(view, {"meshes", "mesh_poses", "planes", "plane_poses"}, "are not read; give primitives");
  if (const auto header = view.entry("header"); header && is_given(*header)) frames.check(*header);
  if (const auto operation = view.entry("operation"); operation && operation->value() != "0") {
    operation->fail("0 (ADD), for there is nothing yet to remove, append to or move");
  }
  world::Obstacle obstacle;
  obstacle.name = required(view, "id").text();
  if (const auto own = view.entry("pose"); own && is_given(*own)) obstacle.X_WO = pose(*own);
  const YamlView poses = required(view, "primitive_poses");
  const auto shapes = required(view, "primitives").items(1, kMost, "primitives");
  const auto places = poses.items(shapes.size(), shapes.size(), "poses, one for each primitive");
  for (std::size_t i = 0; i < shapes.size(); ++i) obstacle.shapes.push_back({primitive(shapes[i]), pose(places[i])});
  return obstacle;
}

/// Frames that objects may be in must be where the planning frame is; others do not matter.
void check_fixed(const YamlView& view, const Frames& frames) {
  check_keys(view, kFixedKeys);
  const YamlView child = required(view, "child_frame_id");
  if (!is_given(child) || !frames.has(child.text())) return;
  const YamlView transform = required(view, "transform");
  const YamlView translation = required(transform, "translation");
  const YamlView rotation = required(transform, "rotation");
  if (position(translation).norm() > 1e-9) translation.fail("[0, 0, 0]: objects are read in the robot's root frame");
  if (orientation(rotation).vec().norm() > 1e-9) {
    rotation.fail("[0, 0, 0, 1]: objects are read in the robot's root frame");
  }
}

/// Items of lists of links whose value is not `plain`.
void check_links(const YamlView& root, std::string_view list, std::string_view key, double plain) {
  const auto links = root.entry(list);
  if (!links || !is_given(*links)) return;
  for (const YamlView& link : links->items(0, kMost, "links")) {
    const YamlView value = required(link, key);
    if (value.number(kCoordinate) != plain) {
      value.fail(number_text(plain) + ": links are read as they are; --clearance keeps away from everything");
    }
  }
}

}  // namespace

MoveItScene read_moveit_scene(const std::string& path, std::span<const std::string> frame_names) {
  planner::SourceFiles sources;
  const YamlNode tree = read_yaml_file(path, sources);
  const YamlSource source{path, sources};
  const YamlView root(tree, source, "");
  const Frames frames{frame_names};
  check_keys(root, kSceneKeys);
  refuse_diff(root, "scene");
  MoveItScene scene;
  scene.robot = text_if_given(root, "robot_model_name");
  if (const auto state = root.entry("robot_state"); state && is_given(*state)) {
    static_cast<void>(robot_state(*state));
  }
  if (const auto fixed = root.entry("fixed_frame_transforms"); fixed && is_given(*fixed)) {
    for (const YamlView& item : fixed->items(0, kMost, "transforms")) check_fixed(item, frames);
  }
  check_links(root, "link_padding", "padding", 0.0);
  check_links(root, "link_scale", "scale", 1.0);
  const YamlView world = required(root, "world");
  check_keys(world, kWorldKeys);
  if (const auto outer = world.entry("octomap"); outer && is_given(*outer)) {
    if (const auto inner = outer->entry("octomap"); inner && is_given(*inner)) {
      refuse_given(*inner, {"data"}, "is not read; give primitives");
    }
  }
  std::set<std::string> names;
  for (const YamlView& item : required(world, "collision_objects").items(0, kMost, "objects")) {
    scene.obstacles.push_back(collision_object(item, frames));
    if (!names.insert(scene.obstacles.back().name).second) required(item, "id").fail("a name that no other object has");
    if (const std::string note = note_of(item, {"subframe_names"}, "goals are joint values"); !note.empty()) {
      scene.notes.push_back(note);
    }
  }
  const std::string why = "the robot description and its SRDF say what may touch, the request where the arm begins";
  if (const std::string note = note_of(root, {"allowed_collision_matrix", "robot_state"}, why); !note.empty()) {
    scene.notes.push_back(note);
  }
  return scene;
}

MoveItScene read_moveit_scene(const std::string& path) {
  const std::array<std::string, 1> frames = {"world"};
  return read_moveit_scene(path, frames);
}

}  // namespace hecaton::config
