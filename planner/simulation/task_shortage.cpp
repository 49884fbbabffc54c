#include "planner/simulation/task_shortage.hpp"

#include <sstream>
#include <vector>

#include "world/model/obstacle_motion.hpp"

namespace hecaton::planner {
namespace {

/// More names are given as a number.
constexpr std::size_t kMostNames = 4;
/// An arm is named as the cause only after so many draws.
constexpr int kMinDraws = 20;

/// "arm a", "arms a, b and c", "12 arms"
std::string named(const std::string& kind, const std::vector<std::string>& names) {
  if (names.size() == 1) return kind + " " + names.front();
  if (names.size() > kMostNames) return std::to_string(names.size()) + " " + kind + "s";
  std::string text = kind + "s ";
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

std::string obstacles_text(const Cell& cell, bool scripted_only = false) {
  std::vector<std::string> names;
  for (const world::Obstacle& obstacle : cell.scene.obstacles) {
    if (!scripted_only || world::is_scripted(obstacle.motion)) names.push_back(obstacle.name);
  }
  return names.empty() ? "" : named("obstacle", names);
}

std::string arms_text(const Cell& cell) {
  std::vector<std::string> names;
  for (const PlannedArm& planned : cell.arms) names.push_back(planned.arm.name);
  return named("arm", names);
}

/// "itself and of all places of obstacles train and comet"
std::string what_is_kept_clear_of(const Cell& cell, const std::string& arms) {
  const std::string obstacles = obstacles_text(cell);
  return obstacles.empty() ? arms : arms + " and of all places of " + obstacles;
}

std::string area_text(const TaskArea& area) {
  std::ostringstream text;
  text << "the task area (centre " << area.centre.x() << ", " << area.centre.y() << ", " << area.centre.z() << " m "
       << (area.of_each_arm ? "from each base" : "in W") << ", radius " << area.radius << " m, half height "
       << area.half_height << " m)";
  return text.str();
}

std::string apart_text(double distance) {
  std::ostringstream text;
  text.precision(3);
  if (distance < 0.0) {
    text << "they overlap by " << -1e3 * distance << " mm at least";
  } else {
    text << "they are " << 1e3 * distance << " mm apart at most";
  }
  return text.str();
}

/// "; most often left/link4 and left/base are too near (they are 3.1 mm apart at most, 25 mm are needed): …"
std::string obstruction_text(const Obstruction& seen) {
  if (seen.draws == 0) return "";
  std::ostringstream text;
  text.precision(3);
  text << "; most often " << seen.pair << " are too near (" << apart_text(seen.farthest) << ", " << 1e3 * seen.needed
       << " mm are needed): "
       << (seen.of_self ? "change the task area, lower damper.self_security_distance, or disable the pair in an SRDF"
                        : "change the task area, move the obstacle, or lower damper.security_distance");
  return text.str();
}

}  // namespace

std::string why_no_configuration(const Cell& cell, std::span<const DrawTally> tallies) {
  for (std::size_t i = 0; i < tallies.size(); ++i) {
    const DrawTally& tally = tallies[i];
    if (tally.draws < kMinDraws || tally.clear) continue;
    const std::string arm = "in " + std::to_string(tally.draws) + " draws arm " + cell.arms[i].arm.name;
    if (!tally.reached) return arm + " reached no point of " + area_text(cell.tasks);
    return arm + " reached " + area_text(cell.tasks) + " only where it is not clear of " +
           what_is_kept_clear_of(cell, "itself") + obstruction_text(tally.most_frequent);
  }
  const bool alone = cell.arms.size() == 1;
  const std::string where = cell.tasks.problem.areas.empty() ? area_text(cell.tasks) : "the balls of tasks.areas";
  return "no configuration in " + where + " was found with " + arms_text(cell) + " clear of " +
         what_is_kept_clear_of(cell, alone ? "itself" : "each other, of themselves");
}

std::string why_no_conflict(const Cell& cell, int drawn) {
  const std::string meet = cell.tasks.clutter.count > 0 ? "any arm meets an arm or an obstacle"
                           : cell.tasks.all_conflict    ? "every arm meets another"
                                                        : "any arms meet";
  return "on the straight motions to none of " + std::to_string(drawn) + " goals drawn in " + area_text(cell.tasks) +
         " " + meet;
}

std::string why_no_start_time(const Cell& cell, int drawn) {
  return "at all of " + std::to_string(drawn) + " start times drawn " + obstacles_text(cell, true) +
         " were too close to " + arms_text(cell) + " at the start";
}

}  // namespace hecaton::planner
