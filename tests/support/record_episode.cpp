/// hecaton-record-episode: one simulated episode of a cell, as lines of JSON for pictures.
///
/// usage: hecaton-record-episode CELL SEED PERIOD
///
/// Writes one line per PERIOD of virtual time [s]. A line has `time` [s], and for each arm and each obstacle its shapes
/// in the world frame W [m]. An arm also has the origin of its tool frame, and the goal of that point. All obstacles
/// begin their scripts at time 0. The same cell and seed give the same lines. Exit code 1: no task could be drawn.

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "planner/model/kinematics.hpp"
#include "planner/simulation/cell_simulation.hpp"
#include "services/config/cell_file.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton {
namespace {

using planner::Pose;

std::string text(const Eigen::Vector3d& p) {
  char buffer[96];
  std::snprintf(buffer, sizeof buffer, "[%.4f, %.4f, %.4f]", p.x(), p.y(), p.z());
  return buffer;
}

/// A shape as a segment or box in W. Meshes are left out.
struct ShapeText {
  const Pose& X_WS;

  [[nodiscard]] std::string round(const char* kind, double radius, double half_length) const {
    const Eigen::Vector3d half(0.0, 0.0, half_length);
    return std::string("{\"kind\": \"") + kind + "\", \"radius\": " + std::to_string(radius) +
           ", \"from\": " + text(X_WS * half) + ", \"to\": " + text(X_WS * -half) + "}";
  }
  std::string operator()(const world::Sphere& sphere) const { return round("capsule", sphere.radius, 0.0); }
  std::string operator()(const world::Capsule& capsule) const {
    return round("capsule", capsule.radius, capsule.half_length);
  }
  std::string operator()(const world::Cylinder& cylinder) const {
    return round("cylinder", cylinder.radius, cylinder.half_length);
  }
  std::string operator()(const world::Box& box) const {
    std::string corners;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
      corners += (i == 0 ? "" : ", ") + text(X_WS * box.half_extents.cwiseProduct(sign));
    }
    return "{\"kind\": \"box\", \"corners\": [" + corners + "]}";
  }
  std::string operator()(const world::Convex&) const { return {}; }
};

class ShapeList {
 public:
  void add(const world::Shape& shape, const Pose& X_WS) {
    const std::string next = std::visit(ShapeText{X_WS}, shape);
    if (!next.empty()) list_ += (list_.empty() ? "" : ", ") + next;
  }
  [[nodiscard]] std::string list() const { return "[" + list_ + "]"; }

 private:
  std::string list_;
};

std::string arm_text(const planner::Arm& arm, const planner::JointVector& q, const planner::JointVector& goal) {
  planner::Kinematics kinematics;
  planner::forward_kinematics(*arm.model, arm.X_WB, goal, kinematics);
  const Eigen::Vector3d goal_W = kinematics.X_WT.translation();
  planner::forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
  ShapeList shapes;
  for (const planner::LinkGeometry& geometry : arm.model->geometry) {
    shapes.add(geometry.shape, kinematics.X_WL[geometry.link] * geometry.X_LS);
  }
  return "{\"name\": \"" + arm.name + "\", \"tool\": " + text(kinematics.X_WT.translation()) +
         ", \"goal\": " + text(goal_W) + ", \"shapes\": " + shapes.list() + "}";
}

std::string obstacle_text(const world::Obstacle& obstacle, double time) {
  const Pose X_WO = world::motion_at(obstacle, time).X_WO;
  ShapeList shapes;
  for (const world::PlacedShape& placed : obstacle.shapes) shapes.add(placed.shape, X_WO * placed.X_BS);
  return "{\"name\": \"" + obstacle.name + "\", \"shapes\": " + shapes.list() + "}";
}

void print_moment(const planner::Cell& cell, double time, const planner::CellConfiguration& measured,
                  const planner::CellConfiguration& goals) {
  std::string arms;
  for (std::size_t i = 0; i < cell.arms.size(); ++i) {
    arms += (arms.empty() ? "" : ", ") + arm_text(cell.arms[i].arm, measured[i], goals[i]);
  }
  std::string obstacles;
  for (const world::Obstacle& obstacle : cell.scene.obstacles) {
    obstacles += (obstacles.empty() ? "" : ", ") + obstacle_text(obstacle, time);
  }
  std::printf("{\"time\": %.3f, \"arms\": [%s], \"obstacles\": [%s]}\n", time, arms.c_str(), obstacles.c_str());
}

int record(const std::string& path, std::uint64_t seed, double period) {
  const planner::Cell cell = config::load_cell_file(path).cell;
  planner::TaskGenerator generator(cell);
  planner::Random random(seed);
  const auto starts = generator.draw_configuration(random);
  const auto goals = starts ? generator.draw_conflicting_goals(random, *starts) : std::nullopt;
  if (!goals) {
    std::fprintf(stderr, "%s: no task could be drawn: %s\n", path.c_str(), generator.shortage().c_str());
    return EXIT_FAILURE;
  }
  planner::EpisodeOptions options;
  options.seed = seed;
  double due = 0.0;
  print_moment(cell, 0.0, *starts, *goals);
  options.observe = [&](double time, const planner::CellConfiguration& measured, std::span<const planner::ArmPlanner>) {
    if (time < due + period) return;
    due += period;
    print_moment(cell, time, measured, *goals);
  };
  const planner::EpisodeOutcome outcome = planner::simulate_episode(cell, *starts, *goals, options);
  std::fprintf(stderr, "%.2f s, %llu contacts\n", outcome.duration,
               static_cast<unsigned long long>(outcome.contact_report.contacts));
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace hecaton

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("usage: hecaton-record-episode CELL SEED PERIOD\n", stderr);
    return 2;
  }
  try {
    return hecaton::record(argv[1], std::stoull(argv[2]), std::stod(argv[3]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
