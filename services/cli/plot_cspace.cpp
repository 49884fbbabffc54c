#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "planner/methods/registry.hpp"
#include "planner/methods/sensed_cspace/cspace_method.hpp"
#include "services/cli/plots.hpp"
#include "services/command_line/program.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

using planner::JointVector;
using planner::cspace::Angles;
using planner::cspace::ArmPlanes;
using planner::cspace::Cell3;
using planner::cspace::Point;
using planner::cspace::SensedMap;
using planner::cspace::Turn;

constexpr double kSide = 480.0;    // of each plot [px]
constexpr double kPlotGap = 60.0;  // [px]

/// The workspace in the present plane of the arm's last two joints.
class Workspace {
 public:
  Workspace(const planner::PlannedArm& planned, double theta0)
      : arm_(planned.arm), planes_(*planned.arm.model), turn_{std::cos(theta0), std::sin(theta0)} {
    const auto& a = planes_.arm();
    scale_ = kSide / (2.2 * (a.reach() + std::max(a.width1, a.width2)));
  }

  [[nodiscard]] std::string link_lines(const JointVector& q, const char* style) const {
    const Angles t = planes_.angles(q);
    const auto& a = planes_.arm();
    const Point elbow{a.length1 * std::cos(t[1]), a.length1 * std::sin(t[1])};
    const Point tip{elbow.x + a.length2 * std::cos(t[1] + t[2]), elbow.y + a.length2 * std::sin(t[1] + t[2])};
    return line({0.0, 0.0}, elbow, a.width1, style) + line(elbow, tip, a.width2, style);
  }

  [[nodiscard]] std::string dot(const Eigen::Vector3d& p_B, const char* colour) const {
    const Point p = planes_.place(p_B, turn_).in_plane;
    return formatted("<circle cx='%.1f' cy='%.1f' r='1.3' fill='%s'/>\n", x(p), y(p), colour);
  }

  /// The outline of the obstacle in the plane: the hull of points on its surface.
  [[nodiscard]] std::string obstacle(const world::Obstacle& obstacle) const {
    std::string shapes;
    for (const world::PlacedShape& placed : obstacle.shapes) {
      world::Obstacle part = obstacle;
      part.shapes = {placed};
      std::vector<Point> points;
      for (const Eigen::Vector3d& p_W : planner::cspace::surface_points(part, 0.02)) {
        points.push_back(planes_.place(arm_.X_WB.inverse() * p_W, turn_).in_plane);
      }
      shapes += "<polygon fill='#bbb' points='";
      for (const Point& p : planner::cspace::convex_piece(points).corners)
        shapes += formatted("%.1f,%.1f ", x(p), y(p));
      shapes += "'/>\n";
    }
    return shapes;
  }

 private:
  [[nodiscard]] double x(const Point& p) const { return 0.5 * kSide + scale_ * p.x; }
  [[nodiscard]] double y(const Point& p) const { return 0.5 * kSide - scale_ * p.y; }
  [[nodiscard]] std::string line(const Point& a, const Point& b, double width, const char* style) const {
    return formatted("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' stroke-width='%.1f' stroke-linecap='round' %s/>\n",
                     x(a), y(a), x(b), y(b), 2.0 * width * scale_, style);
  }

  const planner::Arm& arm_;
  ArmPlanes planes_;
  Turn turn_;
  double scale_;
};

/// The map; the centre of a cell is at its index.
class CspacePlot {
 public:
  explicit CspacePlot(const SensedMap& map) : map_(map), scale_(kSide / std::max(map.size()[1], map.size()[2])) {}

  [[nodiscard]] std::string blocked(int plane) const {
    std::string cells = "<path fill='#d66' stroke='none' d='";
    for (int i = 0; i < map_.size()[1]; ++i) {
      for (int k = 0; k < map_.size()[2];) {
        const int first = k;
        while (k < map_.size()[2] && map_.blocked({plane, i, k})) ++k;
        if (k > first)
          cells += formatted("M%.2f %.2fh%.2fv%.2fh%.2fz", x(i - 0.5), y(first - 0.5), scale_, -scale_ * (k - first),
                             -scale_);
        if (k == first) ++k;
      }
    }
    return cells + "'/>\n";
  }

  [[nodiscard]] std::string polyline(const std::vector<Cell3>& cells, const char* style) const {
    std::string line = formatted("<polyline fill='none' %s points='", style);
    for (const Cell3& cell : cells) line += formatted("%.1f,%.1f ", x(cell[1]), y(cell[2]));
    return line + "'/>\n";
  }

  [[nodiscard]] std::string mark(const JointVector& q, const char* colour) const {
    const Cell3 cell = map_.cell_at(q);
    return formatted("<circle cx='%.1f' cy='%.1f' r='5' fill='%s'/>\n", x(cell[1]), y(cell[2]), colour);
  }

  [[nodiscard]] std::string frame() const {
    return formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='none' stroke='black'/>\n", x(-0.5),
                     y(map_.size()[2] - 0.5), scale_ * map_.size()[1], scale_ * map_.size()[2]);
  }

 private:
  [[nodiscard]] double x(double cell) const { return kSide + kPlotGap + scale_ * (cell + 0.5); }
  [[nodiscard]] double y(double cell) const { return kSide - scale_ * (cell + 0.5); }

  const SensedMap& map_;
  double scale_;
};

/// "θ₀ = −74°, θ₁ → −225° … 45°, θ₂ ↑ −48° … 222°"
std::string axes(const ArmPlanes& planes, const SensedMap& map, const JointVector& q) {
  const auto degrees = [](double angle) { return formatted("%.0f°", angle * 180.0 / planner::cspace::kPi); };
  const Cell3 size = map.size();
  const Angles low = planes.angles(map.centre({0, 0, 0}));
  const Angles high = planes.angles(map.centre({size[0] - 1, size[1] - 1, size[2] - 1}));
  const auto range = [&](int angle) { return degrees(low[angle]) + " … " + degrees(high[angle]); };
  const std::string plane = planes.spatial() ? "θ₀ = " + degrees(planes.angles(q)[0]) + ", " : "";
  return plane + "θ₁ → " + range(1) + ", θ₂ ↑ " + range(2);
}

constexpr double kInterval = 0.25;  // [s]

bool by_field(const planner::PlannedArm& planned) {
  return planned.parameters.method->traits().plot == planner::MethodTraits::Plot::kField;
}

bool has_plot(const planner::MethodTraits& traits) {
  return traits.plot != planner::MethodTraits::Plot::kNone;
}

std::string plot_in_field(const planner::EpisodeMoment& moment, int arm,
                          const std::vector<planner::JointVector>& trace) {
  char time[32];
  std::snprintf(time, sizeof time, ", t = %.2f s", moment.time);
  return plot_path({.planned = moment.cell.arms[arm],
                    .obstacles = moment.cell.scene.obstacles,
                    .path = trace,
                    .goal = moment.goals[arm],
                    .title = moment.cell.arms[arm].arm.name + time,
                    .field = true});
}

}  // namespace

const planner::cspace::SensedPlanner* cspace_of(const planner::ArmController& controller) {
  return dynamic_cast<const planner::cspace::SensedPlanner*>(controller.guide());
}

std::string plot_cspace(const planner::EpisodeMoment& moment, int arm, const std::vector<JointVector>& trace) {
  const planner::PlannedArm& planned = moment.cell.arms[arm];
  const planner::cspace::SensedPlanner& planner = *cspace_of(moment.planners[arm].controller());
  const SensedMap& map = planner.map();
  const JointVector& q = moment.measured[arm];
  const Workspace workspace(planned, ArmPlanes(*planned.arm.model).angles(q)[0]);
  const CspacePlot cspace(map);

  std::string svg = formatted(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='-10 -30 %.0f %.0f'>\n"
      "<rect x='-10' y='-30' width='100%%' height='100%%' fill='white'/>\n"
      "<g font-family='sans-serif' font-size='14'>"
      "<text x='0' y='-10'>%s, t = %.2f s, searches: %d</text>"
      "<text x='%.0f' y='-10'>%s</text></g>\n",
      2.0 * kSide + kPlotGap + 20.0, kSide + 50.0, planned.arm.name.c_str(), moment.time, planner.searches(),
      kSide + kPlotGap, axes(ArmPlanes(*planned.arm.model), map, q).c_str());
  for (const world::Obstacle& obstacle : moment.cell.scene.obstacles) svg += workspace.obstacle(obstacle);
  svg += workspace.link_lines(moment.goals[arm], "stroke='#8c8' opacity='0.35'");
  svg += workspace.link_lines(q, "stroke='#36c' opacity='0.8'");
  for (const Eigen::Vector3d& p_B : map.points()) svg += workspace.dot(p_B, "#c00");
  svg += cspace.blocked(map.cell_at(q)[0]);
  svg += cspace.polyline(planner.path(), "stroke='#090' stroke-width='1.5' stroke-dasharray='4 3'");
  std::vector<Cell3> been;
  for (const JointVector& before : trace) been.push_back(map.cell_at(before));
  svg += cspace.polyline(been, "stroke='#36c' stroke-width='2'");
  svg += cspace.mark(moment.goals[arm], "#090") + cspace.mark(q, "#36c") + cspace.frame();
  return svg + "</svg>\n";
}

EpisodePlotter::EpisodePlotter(std::string folder, const planner::Cell& cell)
    : folder_(std::move(folder)), traces_(cell.arms.size()) {
  const bool any = std::any_of(cell.arms.begin(), cell.arms.end(), [](const planner::PlannedArm& planned) {
    return has_plot(planned.parameters.method->traits());
  });
  if (!any) {
    std::vector<std::string_view> names;
    for (const planner::MethodTraits& traits : planner::built_in_methods().traits()) {
      if (has_plot(traits)) names.push_back(traits.name);
    }
    throw Failure(ExitCode::kBadInput,
                  "--plot = " + folder_ + " needs an arm with method " + config::alternatives(names));
  }
  std::error_code failed;
  std::filesystem::create_directories(folder_, failed);
  if (failed) throw Failure(ExitCode::kBadInput, "--plot: " + folder_ + " cannot be created: " + failed.message());
}

void EpisodePlotter::plot(const planner::EpisodeMoment& moment) {
  const bool due = moment.time >= due_;
  if (due) due_ = moment.time + kInterval;
  for (int arm = 0; arm < static_cast<int>(traces_.size()); ++arm) {
    ArmTrace& trace = traces_[arm];
    if (due && by_field(moment.cell.arms[arm])) {
      trace.q.push_back(moment.measured[arm]);
      write(moment, arm);
    }
    const auto* planner = cspace_of(moment.planners[arm].controller());
    if (planner == nullptr) continue;
    trace.q.push_back(moment.measured[arm]);
    if (due || planner->searches() != trace.searches) write(moment, arm);
    trace.searches = planner->searches();
  }
}

void EpisodePlotter::write(const planner::EpisodeMoment& moment, int arm) {
  char number[16];
  std::snprintf(number, sizeof number, "%04d", plots_++);
  const std::string path = folder_ + "/" + moment.cell.arms[arm].arm.name + "_" + number + ".svg";
  std::ofstream file(path);
  const auto& trace = traces_[arm].q;
  file << (by_field(moment.cell.arms[arm]) ? plot_in_field(moment, arm, trace) : plot_cspace(moment, arm, trace));
  if (!file.flush()) failure_ = "--plot: " + path + " cannot be written";
}

}  // namespace hecaton::services::cli
