#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

#include "planner/collision/exact_distance.hpp"
#include "planner/methods/potential_field/potential_field.hpp"
#include "planner/methods/sensed_cspace/planar_geometry.hpp"
#include "services/cli/plots.hpp"

namespace hecaton::services::cli {
namespace {

using planner::JointVector;
using planner::Pose;
using planner::cspace::Point;

constexpr double kLeftOfPanel = 64.0;  // for ticks and label [px]
constexpr double kBelowPanel = 48.0;   // for ticks and label [px]
constexpr double kLegendLine = 17.0;   // [px]
constexpr double kAbovePanel = 30.0;   // for the title [px]
constexpr double kPanelGap = 20.0;     // [px]
constexpr double kBorder = 0.1;        // around the scene [m]
constexpr double kLevel = 0.01;        // change of height of an arm's bodies that counts as none [m]
constexpr int kSquares = 72;           // of the field, a side
constexpr int kArrowEvery = 3;         // squares

/// Discs whose hull is the outline of a shape from any side.
struct Discs {
  std::vector<Eigen::Vector3d> centres_W;
  double radius = 0.0;
};

Discs discs_of(const world::Shape& shape, const Pose& X_WS) {
  struct Visitor {
    const Pose& X_WS;
    [[nodiscard]] Discs on_axis(double half_length, double radius) const {
      return {{X_WS * Eigen::Vector3d(0, 0, half_length), X_WS * Eigen::Vector3d(0, 0, -half_length)}, radius};
    }
    Discs operator()(const world::Sphere& sphere) const { return {{X_WS.translation()}, sphere.radius}; }
    Discs operator()(const world::Capsule& capsule) const { return on_axis(capsule.half_length, capsule.radius); }
    Discs operator()(const world::Cylinder& cylinder) const {
      Discs rims;
      for (int i = 0; i < 48; ++i) {
        const double angle = i * std::numbers::pi / 24.0;
        const Eigen::Vector3d rim(cylinder.radius * std::cos(angle), cylinder.radius * std::sin(angle), 0.0);
        for (const double z : {-cylinder.half_length, cylinder.half_length}) {
          rims.centres_W.emplace_back(X_WS * (rim + z * Eigen::Vector3d::UnitZ()));
        }
      }
      return rims;
    }
    Discs operator()(const world::Box& box) const {
      Discs corners;
      for (int i = 0; i < 8; ++i) {
        const Eigen::Vector3d sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
        corners.centres_W.emplace_back(X_WS * box.half_extents.cwiseProduct(sign));
      }
      return corners;
    }
    Discs operator()(const world::Convex& convex) const {
      Discs vertices;
      for (const Eigen::Vector3d& vertex : convex.hull->vertices) vertices.centres_W.emplace_back(X_WS * vertex);
      return vertices;
    }
    Discs operator()(const world::Points& points) const {
      Discs balls;
      for (const Eigen::Vector3f& point : points.cloud->points()) {
        balls.centres_W.emplace_back(X_WS * point.cast<double>());
      }
      balls.radius = points.cloud->radius();
      return balls;
    }
  };
  return std::visit(Visitor{X_WS}, shape);
}

/// Round distance of ticks for about five of them.
double tick_step(double range) {
  const double rough = range / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (rough <= factor * power) return factor * power;
  }
  return 10.0 * power;
}

std::string ticks(const PlotAxis& axis, bool upwards) {
  const double step = tick_step(axis.high - axis.low);
  std::string text;
  for (double k = std::ceil(axis.low / step); k * step <= axis.high; k += 1.0) {
    const double at = kPanel * (k * step - axis.low) / (axis.high - axis.low);
    text += upwards
                ? formatted("<path d='M0 %.1fh-5' stroke='black'/><text x='-8' y='%.1f' text-anchor='end'>%g</text>\n",
                            kPanel - at, kPanel - at + 4.0, k * step)
                : formatted(
                      "<path d='M%.1f %.0fv5' stroke='black'/><text x='%.1f' y='%.0f' text-anchor='middle'>%g</text>\n",
                      at, kPanel, at, kPanel + 18.0, k * step);
  }
  return text;
}

/// Frame, ticks, labels and legend of a panel whose upper left corner is the origin.
std::string around(const PlotPanel& panel) {
  std::string text = formatted("<rect width='%.0f' height='%.0f' fill='none' stroke='black'/>\n", kPanel, kPanel);
  text += ticks(panel.across, false) + ticks(panel.up, true);
  text += formatted("<text x='%.0f' y='%.0f' text-anchor='middle'>", 0.5 * kPanel, kPanel + 36.0) + panel.across.label;
  text += formatted("</text>\n<text transform='translate(-44 %.0f) rotate(-90)' text-anchor='middle'>", 0.5 * kPanel);
  text += panel.up.label + "</text>\n";
  double y = kPanel + kBelowPanel;
  for (const LegendEntry& entry : panel.legend) {
    text += formatted("<rect x='0' y='%.0f' width='18' height='9' fill='%s'/><text x='26' y='%.0f'>", y,
                      entry.colour.c_str(), y + 9.0);
    text += entry.text + "</text>\n";
    y += kLegendLine;
  }
  return text;
}

class Drawing {
 public:
  explicit Drawing(const PathPlot& plot)
      : plot_(plot),
        field_parameters_(planner::parameters_of<planner::potential::PotentialParameters>(plot.planned.methods)),
        geometry_({plot.planned.arm}, 0) {
    geometry_.set_obstacles(carried());
    for (const world::Obstacle& obstacle : plot.obstacles) {
      if (obstacle.attachment) continue;
      for (const world::PlacedShape& placed : obstacle.shapes) {
        scene_.push_back({placed.shape, obstacle.X_WO * placed.X_BS});
        extend(discs_of(placed.shape, scene_.back().X_BS));
      }
    }
    lowest_ = extent_.isEmpty() ? -HUGE_VAL : extent_.min().z() - field_parameters_.influence_distance;
    const std::vector<JointVector> states = plotted();
    const std::vector<Discs> first = arm_at(states.front(), -HUGE_VAL);
    for (const JointVector& q : states) {
      const std::vector<Discs> arm = arm_at(q, -HUGE_VAL);
      for (std::size_t i = 0; i < arm.size(); ++i) {
        level_ = level_ && std::abs(arm[i].centres_W[0].z() - first[i].centres_W[0].z()) < kLevel;
      }
    }
    if (!level_) lowest_ = -HUGE_VAL;
    for (const JointVector& q : states) {
      for (const Discs& discs : arm_at(q, lowest_)) extend(discs);
    }
    scale_ = kPanel / (extent_.sizes().maxCoeff() + 2.0 * kBorder);
  }

  [[nodiscard]] std::string svg() {
    std::vector<PlotPanel> panels{panel(1)};
    if (!level_) panels.push_back(panel(2));
    if (plot_.field) panels.push_back(field_panel());
    panels.insert(panels.end(), plot_.panels.begin(), plot_.panels.end());
    std::size_t entries = 0;
    for (const PlotPanel& panel : panels) entries = std::max(entries, panel.legend.size());
    const double width = static_cast<double>(panels.size()) * (kLeftOfPanel + kPanel + kPanelGap);
    const double height = kAbovePanel + kPanel + kBelowPanel + static_cast<double>(entries) * kLegendLine + kPanelGap;
    std::string text = formatted(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' font-family='sans-serif' font-size='13'>\n"
        "<rect width='100%%' height='100%%' fill='white'/>\n<text x='%.0f' y='20' font-size='14'>",
        width, height, kLeftOfPanel);
    text += plot_.title + "</text>\n";
    double x = kLeftOfPanel;
    for (const PlotPanel& panel : panels) {
      text += formatted("<svg x='%.0f' y='%.0f' width='%.0f' height='%.0f'>\n", x, kAbovePanel, kPanel, kPanel);
      text += panel.content;
      text += formatted("</svg>\n<g transform='translate(%.0f %.0f)'>\n", x, kAbovePanel) + around(panel) + "</g>\n";
      x += kPanel + kPanelGap + kLeftOfPanel;
    }
    return text + "</svg>\n";
  }

 private:
  [[nodiscard]] std::vector<world::Obstacle> carried() const {
    std::vector<world::Obstacle> own;
    for (const world::Obstacle& obstacle : plot_.obstacles) {
      if (obstacle.attachment && obstacle.attachment->arm == plot_.planned.arm.name) own.push_back(obstacle);
    }
    return own;
  }

  [[nodiscard]] std::vector<JointVector> plotted() const {
    std::vector<JointVector> states = plot_.path;
    states.push_back(plot_.goal);
    return states;
  }

  /// Bodies not below `lowest` [m].
  [[nodiscard]] std::vector<Discs> arm_at(const JointVector& q, double lowest) const {
    const planner::Arm& arm = plot_.planned.arm;
    planner::Kinematics kinematics;
    forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
    std::vector<Discs> bodies;
    for (const planner::Body& body : geometry_.own_bodies()) {
      const Pose& X_WL = kinematics.X_WL[body.link];
      if ((X_WL * body.bound.centre).z() + body.bound.radius < lowest) continue;
      bodies.push_back(discs_of(body.shape, X_WL * body.X_CS));
    }
    return bodies;
  }

  void extend(const Discs& discs) {
    for (const Eigen::Vector3d& p : discs.centres_W) {
      extent_.extend(Eigen::Vector3d(p.array() - discs.radius));
      extent_.extend(Eigen::Vector3d(p.array() + discs.radius));
    }
  }

  [[nodiscard]] double x(double across) const { return 0.5 * kPanel + scale_ * (across - extent_.center().x()); }
  [[nodiscard]] double y(double up, int axis) const { return 0.5 * kPanel - scale_ * (up - extent_.center()[axis]); }

  /// `axis`: that of W which points upwards in the plot.
  [[nodiscard]] std::string outline(const Discs& discs, int axis, const char* style) const {
    std::vector<Point> points;
    const int corners = discs.radius > 0.0 ? 48 : 1;
    for (const Eigen::Vector3d& p : discs.centres_W) {
      for (int i = 0; i < corners; ++i) {
        const double angle = i * 2.0 * std::numbers::pi / corners;
        points.push_back({p.x() + discs.radius * std::cos(angle), p[axis] + discs.radius * std::sin(angle)});
      }
    }
    std::string text = formatted("<polygon %s points='", style);
    for (const Point& p : planner::cspace::convex_piece(points).corners)
      text += formatted("%.1f,%.1f ", x(p.x), y(p.y, axis));
    return text + "'/>\n";
  }

  [[nodiscard]] std::string arm(const JointVector& q, int axis, const char* style) const {
    std::string text;
    for (const Discs& discs : arm_at(q, lowest_)) text += outline(discs, axis, style);
    return text;
  }

  [[nodiscard]] std::string obstacles(int axis) const {
    std::string text;
    for (const world::PlacedShape& placed : scene_) {
      text += outline(discs_of(placed.shape, placed.X_BS), axis, "fill='#bbb' stroke='#888'");
    }
    return text;
  }

  [[nodiscard]] Eigen::Vector3d tool_at(const JointVector& q) const {
    const planner::Arm& arm = plot_.planned.arm;
    planner::Kinematics kinematics;
    forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
    return kinematics.X_WT.translation();
  }

  [[nodiscard]] std::string tool_trace(int axis) const {
    std::string text = "<polyline fill='none' stroke='#c60' stroke-width='1.5' points='";
    for (const JointVector& q : plot_.path) {
      const Eigen::Vector3d p = tool_at(q);
      text += formatted("%.1f,%.1f ", x(p.x()), y(p[axis], axis));
    }
    return text + "'/>\n";
  }

  /// The range of W's axis that a panel shows [m].
  [[nodiscard]] PlotAxis range(int axis) const {
    constexpr const char* kLabels[] = {"x [m]", "y [m]", "z [m]"};
    const double half = 0.5 * kPanel / scale_;
    return {kLabels[axis], extent_.center()[axis] - half, extent_.center()[axis] + half};
  }

  [[nodiscard]] PlotPanel panel(int axis) const {
    std::string text = obstacles(axis);
    text += arm(plot_.goal, axis, "fill='#8c8' fill-opacity='0.5'");
    for (const JointVector& q : plot_.path) {
      text += arm(q, axis, "fill='none' stroke='#36c' stroke-opacity='0.25'");
    }
    if (!plot_.path.empty()) {
      text += arm(plot_.path.front(), axis, "fill='#fc6' fill-opacity='0.6'");
      text += arm(plot_.path.back(), axis, "fill='#36c' fill-opacity='0.6'");
    }
    return {text + tool_trace(axis),
            range(0),
            range(axis),
            {{"#fc6", "start"},
             {"#36c", "arm on its way, and at the end of the path"},
             {"#8c8", "goal"},
             {"#c60", "way of the tool"},
             {"#bbb", "obstacles"}}};
  }

  struct FieldAt {
    double repulsion = 0.0;
    Eigen::Vector2d force = Eigen::Vector2d::Zero();
  };

  /// −∇U of a point at p_W that the tool's position at the goal attracts, in the horizontal plane.
  [[nodiscard]] FieldAt field_at(const Eigen::Vector3d& p_W, const Eigen::Vector3d& goal_W) const {
    const planner::potential::PotentialParameters& parameters = field_parameters_;
    const world::Sphere point{1e-5};
    FieldAt at;
    for (const world::PlacedShape& placed : scene_) {
      Pose X_WP = Pose::Identity();
      X_WP.translation() = p_W;
      const auto near = planner::shape_distance(point, X_WP, placed.shape, placed.X_BS);
      const auto u = planner::potential::repulsion(near.distance, parameters.influence_distance, parameters.repulsion);
      at.repulsion = std::max(at.repulsion, near.distance < 0.0 ? HUGE_VAL : u.value);
      at.force += u.slope * near.n_W.head<2>();
    }
    const Eigen::Vector2d away = (p_W - goal_W).head<2>();
    const double d = away.norm();
    if (d > 0.0) at.force -= planner::potential::attraction(d, parameters.goal_distance).slope / d * away;
    return at;
  }

  [[nodiscard]] static std::string arrow(double px, double py, const Eigen::Vector2d& tip) {
    return formatted("<path d='M%.1f %.1fl%.1f %.1f' stroke='#236' marker-end='url(#tip)'/>\n", px - 0.5 * tip.x(),
                     py + 0.5 * tip.y(), tip.x(), -tip.y());
  }

  /// Repulsion red, arrows along −∇U. Adjacent squares of one shade in a row are drawn as one.
  [[nodiscard]] PlotPanel field_panel() const {
    const Eigen::Vector3d goal_W = tool_at(plot_.goal);
    const double pixel = kPanel / kSquares;
    const double attraction = field_parameters_.goal_distance;
    std::string squares, arrows;
    for (int row = 0; row < kSquares; ++row) {
      int first = 0;
      int shade_of_run = 0;
      for (int column = 0; column <= kSquares; ++column) {
        const double px = (column + 0.5) * pixel, py = (row + 0.5) * pixel;
        const Eigen::Vector3d p_W(extent_.center().x() + (px - 0.5 * kPanel) / scale_,
                                  extent_.center().y() - (py - 0.5 * kPanel) / scale_, goal_W.z());
        const FieldAt at = field_at(p_W, goal_W);
        const int shade = static_cast<int>(std::lround(10.0 * std::min(1.0, std::sqrt(at.repulsion) / attraction)));
        if (shade != shade_of_run || column == kSquares) {
          if (shade_of_run > 0) {
            squares +=
                formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='%.2f' fill='#c33' fill-opacity='%.1f'/>\n",
                          first * pixel, row * pixel, (column - first) * pixel, pixel, 0.1 * shade_of_run);
          }
          first = column;
          shade_of_run = shade;
        }
        const bool drawn = column % kArrowEvery == 1 && row % kArrowEvery == 1 && column < kSquares && shade < 10;
        if (!drawn || at.force.norm() <= 0.0) continue;
        const double length = 0.9 * kArrowEvery * pixel * std::min(1.0, at.force.norm() / attraction);
        arrows += arrow(px, py, length * at.force.normalized());
      }
    }
    const std::string text =
        "<defs><marker id='tip' viewBox='0 0 6 6' refX='5' refY='3' markerWidth='4' markerHeight='4' orient='auto'>"
        "<path d='M0 0L6 3L0 6z' fill='#236'/></marker></defs>\n" +
        squares + obstacles(1) + arrows + tool_trace(1) +
        formatted("<circle cx='%.1f' cy='%.1f' r='5' fill='#090'/>\n", x(goal_W.x()), y(goal_W.y(), 1));
    return {text,
            range(0),
            range(1),
            {{"#236", "−∇U of a point of the tool"},
             {"#c33", "repulsion; the darker, the stronger"},
             {"#090", "goal of the tool"},
             {"#c60", "way of the tool"},
             {"#bbb", "obstacles"}}};
  }

  const PathPlot& plot_;
  planner::potential::PotentialParameters field_parameters_;
  planner::CellGeometry geometry_;
  std::vector<world::PlacedShape> scene_;  ///< in W
  double lowest_ = -HUGE_VAL;  ///< bodies of a level arm that are lower, far below all obstacles, are not plotted [m]
  Eigen::AlignedBox3d extent_;
  double scale_ = 1.0;
  bool level_ = true;
};

}  // namespace

std::string plot_path(const PathPlot& plot) {
  return Drawing(plot).svg();
}

std::string formatted(const char* format, ...) {
  char buffer[512];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

}  // namespace hecaton::services::cli
