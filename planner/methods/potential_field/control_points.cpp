#include "planner/methods/potential_field/control_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "planner/model/enclosing_capsule.hpp"

namespace hecaton::planner::potential {
namespace {

/// A ball must have a size; so small a one is a point [m].
constexpr double kPoint = 1e-5;

/// The points of a box that lie in a plane of its own thickness are as good as one.
constexpr double kThin = 0.02;

int pieces(double length, double spacing) {
  return std::max(1, static_cast<int>(std::ceil(length / spacing - 1e-9)));
}

class PointsOfBody {
 public:
  PointsOfBody(const Body& body, double spacing, std::vector<ControlPoint>& out)
      : link_(body.link), spacing_(spacing), out_(out) {
    if (body.capsule) {
      on_axis(body.capsule->X_FS, body.capsule->capsule.half_length, body.capsule->capsule.radius);
    } else {
      std::visit([&](const auto& shape) { of(body.X_CS, shape); }, body.shape);
    }
  }

 private:
  void add(const Eigen::Vector3d& p_L, double radius) { out_.push_back({link_, p_L, radius}); }

  void on_axis(const Pose& X_LS, double half_length, double radius) {
    const int count = half_length > 0.0 ? pieces(2.0 * half_length, spacing_) : 0;
    for (int i = 0; i <= count; ++i) {
      const double z = count == 0 ? 0.0 : half_length * (2.0 * i / count - 1.0);
      add(X_LS * Eigen::Vector3d(0.0, 0.0, z), radius);
    }
  }

  void of(const Pose& X_LS, const world::Sphere& sphere) { add(X_LS.translation(), sphere.radius); }
  void of(const Pose& X_LS, const world::Capsule& capsule) { on_axis(X_LS, capsule.half_length, capsule.radius); }
  // Balls on the axis that stay inside: a flat cylinder's only ball is as large as fits.
  void of(const Pose& X_LS, const world::Cylinder& cylinder) {
    const double radius = std::min(cylinder.radius, cylinder.half_length);
    on_axis(X_LS, cylinder.half_length - radius, radius);
  }
  // A mesh's hull may have hundreds of vertices: points on its axis, without a size, as a capsule would stand out.
  void of(const Pose& X_LS, const world::Convex& convex) {
    const PlacedCapsule around = bounding_capsule(convex);
    on_axis(X_LS * around.X_FS, around.capsule.half_length, 0.0);
  }
  void of(const Pose& X_LS, const world::Box& box) {
    for (int axis = 0; axis < 3; ++axis) edges_along(X_LS, box.half_extents, axis);
  }

  /// The four edges along an axis; vertices only with the first one.
  void edges_along(const Pose& X_LS, const Eigen::Vector3d& half, int axis) {
    const int count = pieces(2.0 * half[axis], spacing_);
    const int first = axis == 0 ? 0 : 1;
    for (int corner = 0; corner < 4; ++corner) {
      Eigen::Vector3d p = half;
      for (int k = 0; k < 2; ++k) {
        const int other = (axis + 1 + k) % 3;
        const bool low = (corner >> k & 1) != 0;
        if (half[other] < kThin && low) p[other] = std::nan("");  // its twin is enough
        if (half[other] < kThin && !low) p[other] = 0.0;
        if (half[other] >= kThin && low) p[other] = -half[other];
      }
      if (p.hasNaN()) continue;
      if (half[axis] < kThin && first == 0) {
        p[axis] = 0.0;
        add(X_LS * p, 0.0);
        continue;
      }
      for (int i = first; i <= count - first; ++i) {
        p[axis] = half[axis] * (2.0 * i / count - 1.0);
        add(X_LS * p, 0.0);
      }
    }
  }

  int link_;
  double spacing_;
  std::vector<ControlPoint>& out_;
};

}  // namespace

std::vector<ControlPoint> control_points(const CellGeometry& geometry, double spacing) {
  std::vector<ControlPoint> points;
  for (const Body& body : geometry.own_bodies()) {
    if (body.moves) PointsOfBody(body, spacing, points);
  }
  return points;
}

std::vector<ControlPoint> tool_points(const RobotModel& model, double spacing) {
  const Pose& X_LT = model.X_LT;
  return {{model.tool_link, X_LT.translation(), 0.0},
          {model.tool_link, X_LT * Eigen::Vector3d(spacing, 0.0, 0.0), 0.0},
          {model.tool_link, X_LT * Eigen::Vector3d(0.0, spacing, 0.0), 0.0}};
}

CellGeometry control_geometry(const CellGeometry& geometry, const std::vector<ControlPoint>& points) {
  std::vector<Arm> arms = geometry.arms();
  auto model = std::make_shared<RobotModel>(*arms[geometry.self()].model);
  model->geometry.clear();
  model->self_pairs.clear();
  for (const ControlPoint& point : points) {
    LinkGeometry& ball = model->geometry.emplace_back();
    ball.link = point.link;
    ball.shape = world::Sphere{std::max(point.radius, kPoint)};
    ball.X_LS.translation() = point.p_L;
  }
  arms[geometry.self()].model = std::move(model);
  CellGeometry of_points(std::move(arms), geometry.self());

  // What arms carry has no bodies of its own: its place among the obstacles stays empty.
  std::vector<world::Obstacle> obstacles(geometry.obstacle_count());
  for (int i = 0; i < geometry.obstacle_count(); ++i) {
    obstacles[i].name = std::to_string(i);
    for (const Body& body : geometry.obstacle_bodies(i)) obstacles[i].shapes.push_back({body.shape, body.X_CS});
  }
  of_points.set_obstacles(obstacles);
  return of_points;
}

}  // namespace hecaton::planner::potential
