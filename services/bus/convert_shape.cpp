#include <array>
#include <cstdio>
#include <type_traits>

#include "services/bus/convert.hpp"
#include "services/bus/validate.hpp"

namespace hecaton::bus {
namespace {

msg::Vec3 dimensions(double x, double y, double z) {
  return to_message(Eigen::Vector3d(x, y, z));
}

void set_hull(msg::PlacedShape& message, const world::ConvexHull& hull) {
  for (const auto& vertex : hull.vertices) message.vertices().push_back(to_message(vertex));
  for (const auto& face : hull.faces) {
    message.face_sizes().push_back(static_cast<std::uint32_t>(face.size()));
    for (const int corner : face) message.face_corners().push_back(static_cast<std::uint32_t>(corner));
  }
}

Converted<world::Shape> hull_from_message(const msg::PlacedShape& message, const std::string& what) {
  auto hull = std::make_shared<world::ConvexHull>();
  for (std::size_t i = 0; i < message.vertices().size(); ++i) {
    const auto vertex = from_message(message.vertices()[i], what + ".vertices[" + std::to_string(i) + "]");
    if (!vertex) return {{}, vertex.error};
    hull->vertices.push_back(*vertex);
  }
  if (hull->vertices.size() < 4) return {{}, what + " is convex and must have at least 4 vertices"};
  std::size_t next = 0;
  for (const auto size : message.face_sizes()) {
    if (size < 3 || size > message.face_corners().size() - next) {
      return {{}, what + ".face_sizes must each be at least 3 and add up to the number of face_corners"};
    }
    std::vector<int> face;
    for (std::size_t i = 0; i < size; ++i) {
      const auto corner = message.face_corners()[next++];
      if (corner >= hull->vertices.size()) {
        return {{},
                what + ".face_corners names vertex " + std::to_string(corner) + " of " +
                    std::to_string(hull->vertices.size())};
      }
      face.push_back(static_cast<int>(corner));
    }
    hull->faces.push_back(std::move(face));
  }
  if (next != message.face_corners().size() || hull->faces.size() < 4) {
    return {{}, what + " is convex and must have at least 4 faces whose sizes add up to the number of face_corners"};
  }
  return {world::Shape{world::Convex{std::move(hull)}}, {}};
}

/// First complaint of several, empty when there is none.
std::string first_of(std::initializer_list<std::string> complaints) {
  for (const auto& complaint : complaints) {
    if (!complaint.empty()) return complaint;
  }
  return {};
}

Converted<world::Shape> shape_from_message(const msg::PlacedShape& message, const std::string& what) {
  const double x = message.dimensions().x();
  const double y = message.dimensions().y();
  const double z = message.dimensions().z();
  const std::string name = what + ".dimensions.";
  std::string error;
  switch (message.kind()) {
    case msg::ShapeKind::SHAPE_BOX:
      error = first_of({check_above(name + "x", x, 0), check_above(name + "y", y, 0), check_above(name + "z", z, 0)});
      if (error.empty()) return {world::Shape{world::Box{{x, y, z}}}, {}};
      break;
    case msg::ShapeKind::SHAPE_SPHERE:
      error = check_above(name + "x", x, 0);
      if (error.empty()) return {world::Shape{world::Sphere{x}}, {}};
      break;
    case msg::ShapeKind::SHAPE_CAPSULE:
      error = first_of({check_above(name + "x", x, 0), check_above(name + "y", y, 0, true)});
      if (error.empty()) return {world::Shape{world::Capsule{x, y}}, {}};
      break;
    case msg::ShapeKind::SHAPE_CYLINDER:
      error = first_of({check_above(name + "x", x, 0), check_above(name + "y", y, 0)});
      if (error.empty()) return {world::Shape{world::Cylinder{x, y}}, {}};
      break;
    case msg::ShapeKind::SHAPE_CONVEX:
      return hull_from_message(message, what);
    default:
      error = what + ": unknown kind of shape";
  }
  return {{}, error};
}

}  // namespace

msg::PlacedShape to_message(const world::PlacedShape& shape) {
  msg::PlacedShape message;
  message.X_OS(to_message(shape.X_BS));
  struct Visitor {
    msg::PlacedShape& to;
    void operator()(const world::Box& box) const {
      to.kind(msg::ShapeKind::SHAPE_BOX);
      to.dimensions(to_message(box.half_extents));
    }
    void operator()(const world::Sphere& sphere) const {
      to.kind(msg::ShapeKind::SHAPE_SPHERE);
      to.dimensions(dimensions(sphere.radius, 0, 0));
    }
    void operator()(const world::Capsule& capsule) const {
      to.kind(msg::ShapeKind::SHAPE_CAPSULE);
      to.dimensions(dimensions(capsule.radius, capsule.half_length, 0));
    }
    void operator()(const world::Cylinder& cylinder) const {
      to.kind(msg::ShapeKind::SHAPE_CYLINDER);
      to.dimensions(dimensions(cylinder.radius, cylinder.half_length, 0));
    }
    void operator()(const world::Convex& convex) const {
      to.kind(msg::ShapeKind::SHAPE_CONVEX);
      set_hull(to, *convex.hull);
    }
  };
  std::visit(Visitor{message}, shape.shape);
  return message;
}

Converted<world::PlacedShape> from_message(const msg::PlacedShape& message, const std::string& what) {
  const auto shape = shape_from_message(message, what);
  if (!shape) return {{}, shape.error};
  const auto pose = from_message(message.X_OS(), what + ".X_OS");
  if (!pose) return {{}, pose.error};
  return {world::PlacedShape{*shape, *pose}, {}};
}

std::string shape_text(const msg::PlacedShape& shape) {
  const auto& size = shape.dimensions();
  std::array<char, 128> text{};
  switch (shape.kind()) {
    case msg::ShapeKind::SHAPE_BOX:
      std::snprintf(text.data(), text.size(), "box %g × %g × %g m", 2 * size.x(), 2 * size.y(), 2 * size.z());
      break;
    case msg::ShapeKind::SHAPE_SPHERE:
      std::snprintf(text.data(), text.size(), "sphere ⌀ %g m", 2 * size.x());
      break;
    case msg::ShapeKind::SHAPE_CAPSULE:
      std::snprintf(text.data(), text.size(), "capsule ⌀ %g m, length %g m", 2 * size.x(), 2 * (size.x() + size.y()));
      break;
    case msg::ShapeKind::SHAPE_CYLINDER:
      std::snprintf(text.data(), text.size(), "cylinder ⌀ %g m, height %g m", 2 * size.x(), 2 * size.y());
      break;
    case msg::ShapeKind::SHAPE_CONVEX:
      std::snprintf(text.data(), text.size(), "convex, %zu vertices", shape.vertices().size());
      break;
    default:
      return "unknown";
  }
  return text.data();
}

}  // namespace hecaton::bus
