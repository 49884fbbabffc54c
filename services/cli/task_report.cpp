#include "services/cli/task_report.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"

namespace hecaton::services::cli {
namespace {

std::string kind_name(world::ContactKind kind) {
  switch (kind) {
    case world::ContactKind::kArmArm:
      return "arm-arm";
    case world::ContactKind::kArmObstacle:
      return "arm-obstacle";
    case world::ContactKind::kArmSelf:
      return "arm-self";
  }
  return "";
}

Json to_json(const std::optional<Quantiles>& times) {
  if (!times) return nullptr;
  return {{"p50", times->p50}, {"p99", times->p99}, {"max", times->max}};
}

Json separation_json(const std::optional<world::Separation>& separation) {
  if (!separation) return nullptr;
  return {{"kind", kind_name(separation->kind)},
          {"a", separation->a},
          {"b", separation->b},
          {"distance_m", separation->distance}};
}

double ratio(std::uint64_t a, std::uint64_t b) {
  return static_cast<double>(a) / static_cast<double>(b);
}

Json time_json(std::vector<double> times) {
  if (times.empty()) return nullptr;
  std::sort(times.begin(), times.end());
  return {{"p50", quantile(times, 0.5)}, {"p95", quantile(times, 0.95)}, {"max", times.back()}};
}

Json missed_json(const std::vector<MissedTask>& missed) {
  Json list = Json::array();
  for (const MissedTask& task : missed) {
    list.push_back({{"round", task.round},
                    {"arm", task.arm},
                    {"outcome", task.outcome},
                    {"goal", task.goal},
                    {"reason", task.reason}});
  }
  return list;
}

/// The first missed tasks with their reasons.
std::string missed_text(const std::vector<MissedTask>& missed) {
  constexpr std::size_t kShown = 10;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, missed.size()); ++i) {
    const MissedTask& task = missed[i];
    const std::string outcome = task.outcome == "timed_out" ? "timed out" : task.outcome;
    text += "missed: round " + std::to_string(task.round) + ", " + task.arm + " " + outcome + ": " + task.reason + "\n";
  }
  if (missed.size() > kShown) text += "missed: " + std::to_string(missed.size() - kShown) + " more; see -o json\n";
  return text;
}

}  // namespace

double quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0.0;
  const double rank = std::ceil(share * static_cast<double>(sorted.size()));
  const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
  return sorted[std::min(index, sorted.size() - 1)];
}

std::optional<Quantiles> quantiles(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  return Quantiles{quantile(values, 0.5), quantile(values, 0.99), values.back()};
}

ExitCode Report::exit_code() const {
  if (interrupted) return interrupted->exit_code();
  return positive() ? ExitCode::kDone : ExitCode::kNegative;
}

Json to_json(const Report& report) {
  Json json;
  json["tasks"] = report.tasks;
  json["reached"] = report.reached;
  json["blocked"] = report.blocked;
  json["timed_out"] = report.timed_out;
  json["contacts"] = report.contacts;
  json["min_separation_m"] = report.smallest ? Json(report.smallest->distance) : Json(nullptr);
  json["duration_s"] = report.duration;
  json["tick_us"] = to_json(report.tick_us);
  json["arms"] = Json::array();
  for (const ArmReport& arm : report.arms) {
    json["arms"].push_back({{"name", arm.name},
                            {"tasks", arm.tasks},
                            {"reached", arm.reached},
                            {"blocked", arm.blocked},
                            {"timed_out", arm.timed_out}});
  }
  json["faults"] = report.faults;
  json["cell"] = report.cell;
  json["method"] = report.method;
  json["seed"] = report.seed;
  json["tasks_asked"] = report.asked;
  json["not_drawn"] = report.not_drawn;
  json["missed"] = missed_json(report.missed);
  json["findings"] = findings_json(report.findings);
  json["interrupted"] = to_json(report.interrupted);
  json["closest_pair"] = separation_json(report.smallest);
  json["task_s"] = time_json(report.times);
  if (report.reversals) {
    json["velocity_reversals"] = {{"per_joint_s", report.reversals->per_second},
                                  {"quick_per_joint_s", report.reversals->quick_per_second},
                                  {"joint_s_near", report.reversals->joint_seconds}};
  }
  if (report.rollouts) {
    json["rollouts"] = {{"answers", report.rollouts->answers}, {"ticks", report.rollouts->ticks}};
    json["rollouts"]["processor_us"] = report.rollouts->us ? Json(*report.rollouts->us) : Json(nullptr);
  }
  json.update(report.extra);
  return json;
}

std::string table_text(const Report& report, const Palette& palette) {
  Table arms({{"arm"},
              {"tasks", Align::kRight},
              {"reached", Align::kRight},
              {"blocked", Align::kRight},
              {"timed out", Align::kRight}});
  const auto row = [&](const std::string& name, int tasks, int reached, int blocked, int timed_out) {
    arms.add(
        {name, std::to_string(tasks), std::to_string(reached), std::to_string(blocked), std::to_string(timed_out)});
  };
  for (const ArmReport& arm : report.arms) row(arm.name, arm.tasks, arm.reached, arm.blocked, arm.timed_out);
  row("all", report.tasks, report.reached, report.blocked, report.timed_out);

  std::string out = palette.bold("cell " + report.cell) + ", method " + report.method + ", seed " +
                    std::to_string(report.seed) + "\n\n" + arms.text(palette) + "\n";
  const auto line = [&](const std::string& title, const std::string& value) {
    out += title + std::string(21 - display_width(title), ' ') + value + "\n";
  };
  const std::string share =
      percent_text(report.reached, report.wanted()) + (report.interrupted ? " of the tasks so far" : "");
  line("reached", report.positive() ? palette.green(share) : palette.yellow(share));
  if (report.interrupted) line("not complete", palette.yellow(report.interrupted->text()));
  if (report.not_drawn > 0) {
    line("not drawn", palette.yellow(std::to_string(report.not_drawn) + " tasks: no free goals were found"));
  }
  const std::string contacts = std::to_string(report.contacts);
  line("contacts", report.contacts == 0 ? palette.green(contacts) : palette.red(contacts));
  line("smallest separation", report.smallest ? distance_text(report.smallest->distance) + " (" + report.smallest->a +
                                                    " – " + report.smallest->b + ")"
                                              : "no pair was checked");
  if (!report.times.empty()) {
    std::vector<double> times = report.times;
    std::sort(times.begin(), times.end());
    line("time to goal", "p50 " + duration_text(quantile(times, 0.5)) + ", p95 " +
                             duration_text(quantile(times, 0.95)) + ", max " + duration_text(times.back()));
  }
  if (report.reversals) {
    line("velocity reversals", decimal_text(report.reversals->per_second, 2) + " per second and joint, " +
                                   decimal_text(report.reversals->quick_per_second, 2) + " of them within 0.1 s");
  }
  line("duration", duration_text(report.duration));
  if (report.tick_us) {
    line("tick", "p50 " + decimal_text(report.tick_us->p50, 0) + " µs, p99 " + decimal_text(report.tick_us->p99, 0) +
                     " µs, max " + decimal_text(report.tick_us->max, 0) + " µs");
  }
  if (report.rollouts && report.rollouts->answers > 0) {
    const RolloutReport& rollouts = *report.rollouts;
    std::string text = std::to_string(rollouts.answers) + " of " +
                       decimal_text(ratio(rollouts.ticks, rollouts.answers), 0) + " ticks each";
    if (rollouts.us) text += ", " + decimal_text(*rollouts.us / static_cast<double>(rollouts.ticks), 1) + " µs a tick";
    line("rollouts", text);
  }
  if (!report.missed.empty()) out += "\n" + missed_text(report.missed);
  return out;
}

void check_writable(const std::string& path) {
  if (path.empty()) return;
  const std::ofstream file(path, std::ios::app);
  if (!file) throw Failure(ExitCode::kBadInput, "report file '" + path + "' cannot be written");
}

void write_report(const std::string& path, const Report& report) {
  std::ofstream file(path, std::ios::trunc);
  file << json_text(to_json(report));
  file.close();
  if (!file) throw Failure(ExitCode::kBadInput, "report file '" + path + "' cannot be written");
}

bool has_tasks(const config::CellFile& file) {
  const planner::TaskArea& tasks = file.cell.tasks;
  return !tasks.pose_sequence.empty() || !tasks.problem.areas.empty() || tasks.radius > 0.0;
}

void require_tasks(const config::CellFile& file) {
  if (has_tasks(file)) return;
  throw Failure(ExitCode::kBadInput,
                file.path +
                    ": tasks is missing, and the arms have no volume within reach in common: random goals (--tasks) "
                    "need a map with pose_sequence");
}

}  // namespace hecaton::services::cli
