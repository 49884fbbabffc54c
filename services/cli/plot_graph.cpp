#include <algorithm>

#include "services/cli/plots.hpp"

namespace hecaton::services::cli {
namespace {

using planner::global::kWidth;

constexpr int kGraphSquares = 240;  // a side, each of which is checked at its centre
static_assert(kGraphSquares % kWidth == 0);

class Panel {
 public:
  explicit Panel(const GraphPlot& plot)
      : plot_(plot),
        width_(plot.space.upper[0] - plot.space.lower[0]),
        height_(plot.space.upper[1] - plot.space.lower[1]) {}

  [[nodiscard]] PlotPanel panel() const {
    std::string text = blocked() + graph();
    text += way(plot_.found, "#e80", 2.0) + way(plot_.path, "#000", 2.5);
    text += dot(plot_.start, "#e80") + dot(plot_.goal, "#090");
    const planner::global::Space& space = plot_.space;
    return {text,
            {plot_.across, space.lower[0], space.upper[0]},
            {plot_.up, space.lower[1], space.upper[1]},
            {{"#bbb", "blocked configurations"},
             {"#36c", "tree or roadmap"},
             {"#e80", "start, and the path as found"},
             {"#000", "the shortened path"},
             {"#090", "goal"}}};
  }

 private:
  [[nodiscard]] double x(double q0) const { return side_ * (q0 - plot_.space.lower[0]) / width_; }
  [[nodiscard]] double y(double q1) const { return side_ * (plot_.space.upper[1] - q1) / height_; }

  /// Adjacent blocked squares of a row are drawn as one.
  [[nodiscard]] std::string blocked() const {
    const double square = side_ / kGraphSquares;
    const int stride = plot_.space.stride;
    std::string text;
    for (int row = 0; row < kGraphSquares; ++row) {
      int run = 0;
      for (int column = 0; column <= kGraphSquares; column += kWidth) {
        const unsigned hits = column < kGraphSquares ? collisions(row, column, stride) : 0U;
        for (int lane = 0; lane < kWidth; ++lane) {
          if ((hits >> lane & 1U) != 0) {
            ++run;
            continue;
          }
          if (run > 0) {
            text += formatted("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='#bbb'/>\n",
                              (column + lane - run) * square, row * square, run * square, square + 0.2);
          }
          run = 0;
        }
      }
    }
    return text;
  }

  [[nodiscard]] unsigned collisions(int row, int column, int stride) const {
    std::vector<float> eight(static_cast<std::size_t>(kWidth) * stride, 0.0F);
    for (int lane = 0; lane < kWidth; ++lane) {
      float* q = eight.data() + static_cast<std::ptrdiff_t>(lane) * stride;
      q[0] = plot_.space.lower[0] + static_cast<float>(width_ * (column + lane + 0.5) / kGraphSquares);
      q[1] = plot_.space.upper[1] - static_cast<float>(height_ * (row + 0.5) / kGraphSquares);
    }
    return plot_.validity.collisions(eight.data());
  }

  [[nodiscard]] std::string graph() const {
    const planner::global::Points& nodes = plot_.record.nodes;
    std::string text = "<g stroke='#36c' stroke-width='0.8' fill='#36c'>\n";
    for (const auto& [a, b] : plot_.record.edges) {
      text += formatted("<path d='M%.1f %.1fL%.1f %.1f'/>\n", x(nodes[a][0]), y(nodes[a][1]), x(nodes[b][0]),
                        y(nodes[b][1]));
    }
    for (int i = 0; i < nodes.size(); ++i) {
      text += formatted("<circle cx='%.1f' cy='%.1f' r='1.6' stroke='none'/>\n", x(nodes[i][0]), y(nodes[i][1]));
    }
    return text + "</g>\n";
  }

  [[nodiscard]] std::string way(const std::vector<std::vector<double>>& path, const char* colour, double width) const {
    if (path.empty()) return {};
    std::string text = formatted("<polyline fill='none' stroke='%s' stroke-width='%.1f' points='", colour, width);
    for (const std::vector<double>& q : path) text += formatted("%.1f,%.1f ", x(q[0]), y(q[1]));
    return text + "'/>\n";
  }

  [[nodiscard]] std::string dot(const std::vector<double>& q, const char* colour) const {
    return formatted("<circle cx='%.1f' cy='%.1f' r='5' fill='%s'/>\n", x(q[0]), y(q[1]), colour);
  }

  const GraphPlot& plot_;
  double side_ = kPanel;
  double width_;
  double height_;
};

}  // namespace

PlotPanel graph_panel(const GraphPlot& plot) {
  return Panel(plot).panel();
}

}  // namespace hecaton::services::cli
