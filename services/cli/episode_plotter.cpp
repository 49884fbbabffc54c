#include "services/cli/episode_plotter.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "services/cli/plot_cspace.hpp"
#include "services/cli/plot_path.hpp"
#include "services/command_line/failure.hpp"

namespace hecaton::services::cli {
namespace {

constexpr double kInterval = 0.25;  // [s]

bool by_field(const planner::PlannedArm& planned) {
  return planned.parameters.method == planner::Method::kPotentialField;
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
    return planned.parameters.by_cspace() || by_field(planned);
  });
  if (!any) {
    throw Failure(ExitCode::kBadInput,
                  "--plot = " + folder_ + " needs an arm with method sensed_cspace, known_cspace or potential_field");
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
    const auto* planner = moment.planners[arm].cspace();
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
