#include "services/cli/episode_plotter.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "planner/methods/registry.hpp"
#include "services/cli/plot_cspace.hpp"
#include "services/cli/plot_path.hpp"
#include "services/command_line/failure.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

constexpr double kInterval = 0.25;  // [s]

bool by_field(const planner::PlannedArm& planned) {
  return planned.parameters.method->traits().picture == planner::MethodTraits::Picture::kField;
}

bool has_picture(const planner::MethodTraits& traits) {
  return traits.picture != planner::MethodTraits::Picture::kNone;
}

std::string field_picture(const planner::EpisodeMoment& moment, int arm,
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

EpisodePlotter::EpisodePlotter(std::string folder, const planner::Cell& cell)
    : folder_(std::move(folder)), past_(cell.arms.size()) {
  const bool any = std::any_of(cell.arms.begin(), cell.arms.end(), [](const planner::PlannedArm& planned) {
    return has_picture(planned.parameters.method->traits());
  });
  if (!any) {
    std::vector<std::string_view> names;
    for (const planner::MethodTraits& traits : planner::built_in_methods().traits()) {
      if (has_picture(traits)) names.push_back(traits.name);
    }
    throw Failure(ExitCode::kBadInput,
                  "--plot = " + folder_ + " needs an arm with method " + config::alternatives(names));
  }
  std::error_code failed;
  std::filesystem::create_directories(folder_, failed);
  if (failed) throw Failure(ExitCode::kBadInput, "--plot: " + folder_ + " cannot be made: " + failed.message());
}

void EpisodePlotter::draw(const planner::EpisodeMoment& moment) {
  const bool due = moment.time >= due_;
  if (due) due_ = moment.time + kInterval;
  for (int arm = 0; arm < static_cast<int>(past_.size()); ++arm) {
    Past& past = past_[arm];
    if (due && by_field(moment.cell.arms[arm])) {
      past.trace.push_back(moment.measured[arm]);
      write(moment, arm);
    }
    const auto* planner = cspace_of(moment.planners[arm].controller());
    if (planner == nullptr) continue;
    past.trace.push_back(moment.measured[arm]);
    if (due || planner->searches() != past.searches) write(moment, arm);
    past.searches = planner->searches();
  }
}

void EpisodePlotter::write(const planner::EpisodeMoment& moment, int arm) {
  char number[16];
  std::snprintf(number, sizeof number, "%04d", pictures_++);
  const std::string path = folder_ + "/" + moment.cell.arms[arm].arm.name + "_" + number + ".svg";
  std::ofstream file(path);
  const auto& trace = past_[arm].trace;
  file << (by_field(moment.cell.arms[arm]) ? field_picture(moment, arm, trace) : plot_cspace(moment, arm, trace));
  if (!file.flush()) failure_ = "--plot: " + path + " cannot be written";
}

}  // namespace hecaton::services::cli
