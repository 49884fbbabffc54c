#include "services/cli/episode_plotter.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "services/cli/failure.hpp"
#include "services/cli/plot_cspace.hpp"

namespace hecaton::services::cli {
namespace {

constexpr double kInterval = 0.25;  // [s]

}  // namespace

EpisodePlotter::EpisodePlotter(std::string folder, const planner::Cell& cell)
    : folder_(std::move(folder)), past_(cell.arms.size()) {
  const bool any = std::any_of(cell.arms.begin(), cell.arms.end(),
                               [](const planner::PlannedArm& planned) { return planned.parameters.by_cspace(); });
  if (!any) {
    throw Failure(
        ExitCode::kBadInput,
        "--plot = " + folder_ + " needs an arm that plans through C-space: with method sensed_cspace or known_cspace");
  }
  std::error_code failed;
  std::filesystem::create_directories(folder_, failed);
  if (failed) throw Failure(ExitCode::kBadInput, "--plot: " + folder_ + " cannot be made: " + failed.message());
}

void EpisodePlotter::draw(const planner::EpisodeMoment& moment) {
  const bool due = moment.time >= due_;
  if (due) due_ = moment.time + kInterval;
  for (int arm = 0; arm < static_cast<int>(past_.size()); ++arm) {
    const auto* planner = moment.planners[arm].cspace();
    if (planner == nullptr) continue;
    Past& past = past_[arm];
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
  file << plot_cspace(moment, arm, past_[arm].trace);
  if (!file.flush()) failure_ = "--plot: " + path + " cannot be written";
}

}  // namespace hecaton::services::cli
