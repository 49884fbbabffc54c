#include "services/config/read_timing.hpp"

#include <array>

#include "services/config/fields.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

constexpr Bounds kPeriod{0.0005, 1.0, "s"};
constexpr std::array<std::string_view, 2> kConflicting = {"some", "all"};
constexpr std::array<std::string_view, 2> kFrame = {"world", "base"};

std::string milliseconds_text(double seconds) {
  return number_text(seconds * 1e3) + "ms";
}

void read_clutter(const MapView& map, planner::Clutter& clutter) {
  constexpr Bounds kSize{0.001, kFarthest, "m"};
  clutter.count = map.at("count").integer(1, 64);
  read_number(map, "smallest", kSize, clutter.smallest);
  read_number(map, "largest", kSize, clutter.largest);
  read_number(map, "inner", {0.0, kFarthest, "m"}, clutter.inner);
  read_number(map, "outer", kLength, clutter.outer);
  read_number(map, "lowest", kCoordinate, clutter.lowest);
  read_number(map, "highest", kCoordinate, clutter.highest);
  const auto in_order = [&](const char* low, double least, const char* high, double most) {
    if (least > most) map.fail(high, number_text(most), std::string("at least ") + low + " = " + number_text(least));
  };
  in_order("smallest", clutter.smallest, "largest", clutter.largest);
  in_order("inner", clutter.inner, "outer", clutter.outer);
  in_order("lowest", clutter.lowest, "highest", clutter.highest);
}

/// Which arms and poses there are is known later: cell_file.cpp.
void read_problem(const MapView& map, const YamlView& areas, planner::MotionProblem& problem) {
  for (const auto& [arm, poses] : areas.named_items(128)) {
    for (const YamlView& pose : poses.items(2, 16, "pose names")) problem.areas[arm].push_back(pose.name());
  }
  if (problem.areas.empty()) areas.fail("a map with the name of one arm at least");
  read_number(map, "spread", {0.0, 3.0, "rad"}, problem.spread);
  read_number(map, "mean_wait", {0.0, 1e6, "steps"}, problem.mean_wait);
}

void leave_out(const MapView& map, std::string_view key, const char* why) {
  if (const auto given = map.find(key)) given->fail(std::string("left out, because ") + why);
}

}  // namespace

planner::Timing read_timing(const MapView& root) {
  planner::Timing timing;
  const auto view = root.find("timing");
  if (!view) return timing;
  const MapView map = view->map(section::kTiming);
  read_seconds(map, "control_period", kPeriod, timing.control_period);
  read_seconds(map, "driver_period", kPeriod, timing.driver_period);
  read_seconds(map, "world_period", kPeriod, timing.world_period);
  read_seconds(map, "command_timeout", {0.001, 10.0, "s"}, timing.command_timeout);
  if (timing.driver_period > timing.control_period) {
    map.fail("driver_period", milliseconds_text(timing.driver_period),
             "at most control_period = " + milliseconds_text(timing.control_period));
  }
  // One late command is no reason to stop; a second one is.
  if (timing.command_timeout < 2.0 * timing.control_period) {
    map.fail("command_timeout", milliseconds_text(timing.command_timeout),
             "at least twice control_period = " + milliseconds_text(timing.control_period));
  }
  return timing;
}

bool read_real_time(const MapView& root) {
  bool real_time = false;
  if (const auto view = root.find("timing")) read_boolean(view->map(section::kTiming), "real_time", real_time);
  return real_time;
}

planner::TaskArea read_tasks(const MapView& root) {
  planner::TaskArea tasks;
  const auto view = root.find("tasks");
  if (!view) {
    tasks.radius = 0.0;
    return tasks;
  }
  const MapView map = view->map(section::kTasks);
  if (const auto sequence = map.find("pose_sequence")) {
    for (const char* key : {"areas", "frame", "centre", "radius", "half_height", "posture", "conflicting", "clutter"}) {
      leave_out(map, key, "tasks.pose_sequence says where the arms go");
    }
    for (const YamlView& pose : sequence->items(2, 64, "pose names")) tasks.pose_sequence.push_back(pose.name());
    read_seconds(map, "time_limit", {0.0, 3600.0, "s", true}, tasks.time_limit);
    return tasks;
  }
  if (const auto areas = map.find("areas")) {
    for (const char* key : {"frame", "centre", "radius", "half_height", "posture", "conflicting", "clutter"}) {
      leave_out(map, key, "tasks.areas says where the arms go");
    }
    read_problem(map, *areas, tasks.problem);
    read_seconds(map, "time_limit", {0.0, 3600.0, "s", true}, tasks.time_limit);
    return tasks;
  }
  for (const char* key : {"spread", "mean_wait"}) leave_out(map, key, "it belongs to tasks.areas");
  if (const auto frame = map.find("frame")) tasks.of_each_arm = frame->choice(kFrame) == 1;
  tasks.centre = read_vector(map.at("centre"), kCoordinate, "numbers [x, y, z] in m");
  read_number(map, "radius", kLength, tasks.radius);
  read_number(map, "half_height", {0.0, kFarthest, "m"}, tasks.half_height);
  if (const auto posture = map.find("posture")) tasks.posture = posture->name();
  if (const auto arms = map.find("conflicting")) tasks.all_conflict = arms->choice(kConflicting) == 1;
  if (const auto clutter = map.find("clutter")) read_clutter(clutter->map(section::kClutter), tasks.clutter);
  read_seconds(map, "time_limit", {0.0, 3600.0, "s", true}, tasks.time_limit);
  return tasks;
}

}  // namespace hecaton::config
