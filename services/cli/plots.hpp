#pragma once
/// Plots as SVG: arms on their paths, potential fields, graphs of global planners, and C-spaces.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/global/global_planner.hpp"
#include "planner/methods/sensed_cspace/sensed_planner.hpp"
#include "planner/simulation/batch.hpp"

namespace hecaton::services::cli {

/// printf into a string of at most 511 characters.
[[gnu::format(printf, 1, 2)]] [[nodiscard]] std::string formatted(const char* format, ...);

inline constexpr double kPanel = 480.0;  ///< side of a square panel [px]

/// An axis of a panel.
struct PlotAxis {
  std::string label;  ///< with its unit
  double low = 0.0;   ///< at the left or lower edge
  double high = 1.0;  ///< at the other edge
};

/// What a colour means.
struct LegendEntry {
  std::string colour;  ///< of SVG
  std::string text;
};

/// A square panel of a plot.
struct PlotPanel {
  std::string content;  ///< SVG of kPanel by kPanel pixels, from the upper left corner
  PlotAxis across;
  PlotAxis up;
  std::vector<LegendEntry> legend;
};

/// An arm among obstacles on its path, as in [Cardenas10] figures 2, 5 and 6.
struct PathPlot {
  const planner::PlannedArm& planned;
  std::span<const world::Obstacle> obstacles;     ///< where they are at the beginning
  const std::vector<planner::JointVector>& path;  ///< from the start on [rad | m]; all but its end is drawn faintly
  const planner::JointVector& goal;               ///< drawn in pale green [rad | m]
  std::string title;
  bool field = false;                  ///< also draws the arm's potential field for a point of its tool
  std::vector<PlotPanel> panels = {};  ///< more panels, drawn on the right
};

/// An SVG with the view from above (x to the right, y upwards). Unless the arm stays at one height, it also has the
/// view from the side (x to the right, z upwards). Panels have axes with units and a legend. With `field` it has the
/// field from above, at the height of the tool at the goal.
[[nodiscard]] std::string plot_path(const PathPlot& plot);

/// A tree or roadmap in a configuration space of two dimensions, as in [Cardenas10] figures 7, 10 and 11.
struct GraphPlot {
  const planner::global::Validity& validity;  ///< of two dimensions
  const planner::global::Space& space;
  const planner::global::SearchRecord& record;
  std::vector<std::vector<double>> found;  ///< the path before it was shortened [rad | m]; empty: none
  std::vector<std::vector<double>> path;   ///< the shortened path [rad | m]
  std::vector<double> start;
  std::vector<double> goal;
  std::string across;  ///< name of the first coordinate, with its unit
  std::string up;      ///< name of the second coordinate, with its unit
};

/// Blocked configurations are grey, the tree or roadmap is blue. The found
/// path is orange, the shortened path black, the start orange, the goal green.
[[nodiscard]] PlotPanel graph_panel(const GraphPlot& plot);

/// The C-space planner of an arm; null for methods without one.
[[nodiscard]] const planner::cspace::SensedPlanner* cspace_of(const planner::ArmController& controller);

/// One instant of an arm that plans in C-space, as in [Li96] figure 4, as an SVG. `trace`: configurations so far,
/// oldest first [rad | m]. The left panel shows the obstacles (grey), the arm, the points that it has seen (red) and
/// the goal (pale green). Its plane is that of the last two joints. The right panel shows the C-space: θ₁ to the right,
/// θ₂ upwards, for three joints in the plane of the present θ₀.
[[nodiscard]] std::string plot_cspace(const planner::EpisodeMoment& moment, int arm,
                                      const std::vector<planner::JointVector>& trace);

/// Plots a simulated episode into a folder: every arm that plans in C-space or by a potential field. It plots each
/// quarter of a second, and after each search in C-space.
class EpisodePlotter {
 public:
  /// Makes the folder if it is missing. Throws Failure when it cannot, or when no arm of the cell would be plotted.
  EpisodePlotter(std::string folder, const planner::Cell& cell);

  /// Never throws: it runs in a thread of the simulation.
  void plot(const planner::EpisodeMoment& moment);

  [[nodiscard]] int plots() const { return plots_; }  ///< files written
  /// A sentence; empty: all files were written.
  [[nodiscard]] const std::optional<std::string>& failure() const { return failure_; }

 private:
  struct ArmTrace {
    std::vector<planner::JointVector> q;  ///< [rad | m], oldest first
    int searches = -1;
  };

  void write(const planner::EpisodeMoment& moment, int arm);

  std::string folder_;
  std::optional<std::string> failure_;
  double due_ = 0.0;  ///< time of the next plot [s]
  std::vector<ArmTrace> traces_;
  int plots_ = 0;
};

}  // namespace hecaton::services::cli
