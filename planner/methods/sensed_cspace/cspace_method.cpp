#include "planner/methods/sensed_cspace/cspace_method.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "planner/methods/sensed_cspace/arm_planes.hpp"
#include "planner/methods/sensed_cspace/cspace_map.hpp"
#include "planner/methods/sensed_cspace/sensed_planner.hpp"

namespace hecaton::planner::cspace {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// Number of steps of at most `spacing` along `length`; at least 1.
int steps(double length, double spacing) {
  return std::max(1, static_cast<int>(std::ceil(length / spacing)));
}

/// A parallelogram.
void add_patch(const Eigen::Vector3d& corner, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double spacing,
               Points& points) {
  const int n = steps(a.norm(), spacing);
  const int m = steps(b.norm(), spacing);
  for (int i = 0; i <= n; ++i) {
    for (int k = 0; k <= m; ++k) points.emplace_back(corner + a * i / n + b * k / m);
  }
}

void add_disc(double z, double radius, double spacing, Points& points) {
  const int rings = steps(radius, spacing);
  for (int ring = 0; ring <= rings; ++ring) {
    const double r = radius * ring / rings;
    const int n = steps(2.0 * kPi * r, spacing);
    for (int k = 0; k < n; ++k) {
      points.emplace_back(r * std::cos(2.0 * kPi * k / n), r * std::sin(2.0 * kPi * k / n), z);
    }
  }
}

struct Visitor {
  double spacing;

  Points operator()(const world::Box& box) const {
    Points points;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d a = 2.0 * box.half_extents[(axis + 1) % 3] * Eigen::Vector3d::Unit((axis + 1) % 3);
      const Eigen::Vector3d b = 2.0 * box.half_extents[(axis + 2) % 3] * Eigen::Vector3d::Unit((axis + 2) % 3);
      const Eigen::Vector3d through = 2.0 * box.half_extents[axis] * Eigen::Vector3d::Unit(axis);
      add_patch(-box.half_extents, a, b, spacing, points);
      add_patch(-box.half_extents + through, a, b, spacing, points);
    }
    return points;
  }
  Points operator()(const world::Cylinder& cylinder) const {
    Points points;
    add_disc(-cylinder.half_length, cylinder.radius, spacing, points);
    add_disc(cylinder.half_length, cylinder.radius, spacing, points);
    add_wall(cylinder.radius, cylinder.half_length, points);
    return points;
  }
  Points operator()(const world::Capsule& capsule) const {
    Points points;
    add_wall(capsule.radius, capsule.half_length, points);
    for (const Eigen::Vector3d& p : (*this)(world::Sphere{capsule.radius})) {
      points.emplace_back(p + std::copysign(capsule.half_length, p.z()) * Eigen::Vector3d::UnitZ());
    }
    return points;
  }
  Points operator()(const world::Sphere& sphere) const {
    Points points;
    const int rings = steps(kPi * sphere.radius, spacing);
    for (int ring = 0; ring <= rings; ++ring) {
      const double polar = kPi * ring / rings;
      const double r = sphere.radius * std::sin(polar);
      const int n = steps(2.0 * kPi * r, spacing);
      for (int k = 0; k < n; ++k) {
        points.emplace_back(r * std::cos(2.0 * kPi * k / n), r * std::sin(2.0 * kPi * k / n),
                            sphere.radius * std::cos(polar));
      }
    }
    return points;
  }
  Points operator()(const world::Convex& convex) const {
    Points points;
    const auto& vertices = convex.hull->vertices;
    for (const auto& face : convex.hull->faces) {
      for (std::size_t i = 1; i + 1 < face.size(); ++i) {
        const Eigen::Vector3d& corner = vertices[face[0]];
        const Eigen::Vector3d a = vertices[face[i]] - corner;
        const Eigen::Vector3d b = vertices[face[i + 1]] - corner;
        const int n = steps(std::max(a.norm(), b.norm()), spacing);
        for (int u = 0; u <= n; ++u) {
          for (int v = 0; v <= n - u; ++v) points.emplace_back(corner + a * u / n + b * v / n);
        }
      }
    }
    return points;
  }
  Points operator()(const world::Points& cloud) const {
    Points points;
    const Points ball = (*this)(world::Sphere{cloud.cloud->radius()});
    for (const Eigen::Vector3f& centre : cloud.cloud->points()) {
      for (const Eigen::Vector3d& p : ball) points.emplace_back(centre.cast<double>() + p);
    }
    return points;
  }

 private:
  void add_wall(double radius, double half_length, Points& points) const {
    const int rings = steps(2.0 * half_length, spacing);
    const int n = steps(2.0 * kPi * radius, spacing);
    for (int ring = 0; ring <= rings; ++ring) {
      for (int k = 0; k < n; ++k) {
        points.emplace_back(radius * std::cos(2.0 * kPi * k / n), radius * std::sin(2.0 * kPi * k / n),
                            half_length * (2.0 * ring / rings - 1.0));
      }
    }
  }
};

}  // namespace

std::vector<Eigen::Vector3d> surface_points(const world::Obstacle& obstacle, double spacing) {
  Points points;
  if (obstacle.attachment) return points;
  for (const world::PlacedShape& placed : obstacle.shapes) {
    const world::Pose X_WS = obstacle.X_WO * placed.X_BS;
    for (const Eigen::Vector3d& p_S : std::visit(Visitor{spacing}, placed.shape)) points.emplace_back(X_WS * p_S);
  }
  return points;
}

namespace {

/// Cells of a full turn for an arm with three joints. Its map needs nine bytes for each cell: 62 MB for a PUMA.
constexpr int kMostCellsInSpace = 240;

/// Maps the surfaces of all known obstacles, and never forgets them.
class KnownObstaclePlanner final : public SensedPlanner {
 public:
  KnownObstaclePlanner(const Arm& arm, const SensedParameters& parameters, double dt)
      : SensedPlanner(arm, parameters, dt), spacing_(parameters.margin) {}

  void set_obstacles(std::span<const world::Obstacle> obstacles) override {
    for (const world::Obstacle& obstacle : obstacles) add_obstacle(surface_points(obstacle, spacing_));
  }
  void sense(const RangeScan& /*scan*/) override {}

 private:
  double spacing_;  ///< [m]
};

}  // namespace

void CspaceMethod::visit_parameters(ParameterVisitor& visitor) {
  static constexpr std::array<std::string_view, 3> kRemember = {"never", "until_nearer", "always"};
  static constexpr std::array<std::string_view, 2> kMapper = {"exact", "published"};
  visitor.section("sensed");
  visitor.integer("cells", parameters.cells, 36, 1440);
  visitor.number("margin", parameters.margin, {0.0, 1.0, "m", true});
  visitor.choice("remember", kRemember, parameters.remember);
  visitor.choice("mapper", kMapper, parameters.mapper);
}

std::optional<std::string> CspaceMethod::validate() const {
  const int cells = parameters.cells;
  const double margin = parameters.margin;
  if (cells < 36 || cells > 1440 || cells % 4 != 0) {
    return must_be("sensed.cells", cells, "a multiple of 4 from 36 to 1440");
  }
  if (!std::isfinite(margin) || margin <= 0.0) return must_be("sensed.margin", margin, "a finite number above 0");
  return std::nullopt;
}

std::optional<std::string> CspaceMethod::contact_risk() const {
  if (parameters.mapper != Mapper::kPublished) return std::nullopt;
  return "sensed.mapper = published misses cells of C-space in which the arm touches an obstacle; use it in simulation "
         "only";
}

std::optional<std::string> CspaceMethod::objection(const Arm& arm, std::span<const RangeSensor> sensors) const {
  const RobotModel& robot = *arm.model;
  if (const auto why = ArmPlanes::why_not(robot)) {
    return "must be given to an arm of two links that turn in a plane, which a joint may turn about the base; of "
           "robot " +
           robot.name + ", " + *why;
  }
  if (robot.joints() == 3 && parameters.cells > kMostCellsInSpace) {
    return "must be given to an arm with three joints with sensed.cells of " + std::to_string(kMostCellsInSpace) +
           " at most, not " + std::to_string(parameters.cells);
  }
  if (traits().sensor_only && sensors.empty()) return "must be given to an arm with sensors";
  return std::nullopt;
}

std::unique_ptr<MotionGuide> SensedCspace::make_guide(const Arm& arm, double dt) const {
  return std::make_unique<SensedPlanner>(arm, parameters, dt);
}

std::unique_ptr<MotionGuide> KnownCspace::make_guide(const Arm& arm, double dt) const {
  return std::make_unique<KnownObstaclePlanner>(arm, parameters, dt);
}

}  // namespace hecaton::planner::cspace
