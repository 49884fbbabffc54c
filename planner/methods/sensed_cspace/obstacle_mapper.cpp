#include "planner/methods/sensed_cspace/obstacle_mapper.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "planner/methods/sensed_cspace/direction_kernel.hpp"
#include "planner/simd/instruction_set.hpp"
#include "planner/simd/sine_cosine.hpp"

namespace hecaton::planner::cspace {
namespace {

/// Larger than the kernel's error, so that rounding never frees a cell [rad].
constexpr double kSlack = 1e-8;
/// Growth of the links as a share of the reach, for the same reason.
constexpr double kGrowth = 1e-9;
constexpr int kLanesOfKernel = 4;

const DirectionKernel& kernel() {
  static const DirectionKernel chosen = fastest(baseline::touching_directions, avx2::touching_directions);
  return chosen;
}

int ceiling(double x) {
  const int whole = static_cast<int>(x);
  return whole + (static_cast<double>(whole) < x ? 1 : 0);
}

}  // namespace

ObstacleMapper::ObstacleMapper(const PlanarArm& arm, AngleGrid grid) : arm_(arm), grid_(grid) {
  const int rows = 2 * grid.cells + kLanesOfKernel;
  std::vector<double> angles;
  for (int row = 0; row < rows; ++row) angles.push_back(grid.centre(row));
  cosine_.resize(rows);
  sine_.resize(rows);
  sine_cosine(angles.data(), rows, sine_.data(), cosine_.data());
  for (int row = 0; row < rows; ++row) {
    elbow_x_.push_back(arm.length1 * cosine_[row]);
    elbow_y_.push_back(arm.length1 * sine_[row]);
  }
  right_.resize(grid.cells + kLanesOfKernel);
  left_.resize(grid.cells + kLanesOfKernel);
}

/// The rows that can be blocked: both links touch a ball around the obstacle only in arcs about its direction.
ObstacleMapper::Rows ObstacleMapper::rows_in_reach(const ConvexPiece& obstacle) const {
  const double r = std::hypot(obstacle.centre.x, obstacle.centre.y);
  const double l1 = arm_.length1;
  const double thick = obstacle.radius + arm_.width1 + kGrowth * arm_.reach();
  const double far = obstacle.radius + arm_.width2 + kGrowth * arm_.reach() + arm_.length2;
  double half = -1.0;
  if (r <= l1 + thick) half = r <= thick ? kPi : std::asin(thick / r);
  // eq. 3: cos(θ₁ − φ) = (r² + l₁² − s²) / (2 l₁ r)
  if (r <= l1 + far && r >= l1 - far) {
    half = std::max(half, r + l1 <= far ? kPi : std::acos((r * r + l1 * l1 - far * far) / (2.0 * l1 * r)));
  }
  if (half < 0.0) return {};
  const double phi = std::atan2(obstacle.centre.y, obstacle.centre.x);
  const int first = static_cast<int>(std::floor(grid_.place(phi - half - kSlack)));
  const int last = static_cast<int>(std::ceil(grid_.place(phi + half + kSlack)));
  if (last - first + 1 >= grid_.cells) return {0, grid_.cells};
  return {grid_.wrapped(first), last - first + 1};
}

RowSpan ObstacleMapper::cells_between(double right, double left) const {
  const int cells = grid_.cells;
  if (right >= 2.0 * kPi) return {};
  if (right <= -2.0 * kPi) return {0, static_cast<std::int16_t>(cells)};
  const int first = ceiling(std::max(0.0, grid_.place(right - kSlack)));
  int last = static_cast<int>(grid_.place(left + kSlack));
  if (left < right - 2.0 * kSlack) last += cells;
  const int count = std::clamp(last - first + 1, 0, cells);
  return {static_cast<std::int16_t>(first < cells ? first : first - cells), static_cast<std::int16_t>(count)};
}

void ObstacleMapper::map(const ConvexPiece& obstacle, ObstacleImage& image, Links links) {
  const Rows rows = rows_in_reach(obstacle);
  image.first_row = rows.first;
  image.spans.assign(rows.count, {});
  if (rows.count == 0) return;
  if (links != Links::kFirst) block_second_link(obstacle, image);
  if (links != Links::kSecond) block_first_link(obstacle, image);
}

void ObstacleMapper::block_second_link(const ConvexPiece& obstacle, ObstacleImage& image) {
  const int first = image.first_row;
  const int rows = static_cast<int>(image.spans.size());
  const int padded = (rows + kLanesOfKernel - 1) / kLanesOfKernel * kLanesOfKernel;
  kernel()({&elbow_x_[first], &elbow_y_[first], &cosine_[first], &sine_[first], &obstacle, arm_.length2,
            arm_.width2 + kGrowth * arm_.reach()},
           padded, right_.data(), left_.data());
  for (int i = 0; i < rows; ++i) image.spans[i] = cells_between(right_[i], left_[i]);
}

/// Rows in which the first link touches the obstacle are blocked for every θ₂. The kernel gives its directions for a
/// joint at the base.
void ObstacleMapper::block_first_link(const ConvexPiece& obstacle, ObstacleImage& image) {
  constexpr std::array<double, kLanesOfKernel> kZero{};
  constexpr std::array<double, kLanesOfKernel> kOne{1.0, 1.0, 1.0, 1.0};
  std::array<double, kLanesOfKernel> right;
  std::array<double, kLanesOfKernel> left;
  kernel()({kZero.data(), kZero.data(), kOne.data(), kZero.data(), &obstacle, arm_.length1,
            arm_.width1 + kGrowth * arm_.reach()},
           kLanesOfKernel, right.data(), left.data());
  const RowSpan touched = cells_between(right[0], left[0]);
  const RowSpan whole{0, static_cast<std::int16_t>(grid_.cells)};
  for (int k = 0; k < touched.count; ++k) {
    const auto place = static_cast<std::size_t>(grid_.wrapped(touched.first + k - image.first_row));
    if (place < image.spans.size()) image.spans[place] = whole;
  }
}

}  // namespace hecaton::planner::cspace
