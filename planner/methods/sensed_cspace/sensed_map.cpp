#include "planner/methods/sensed_cspace/sensed_map.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/simd/sine_cosine.hpp"

namespace hecaton::planner::cspace {
namespace {

/// Size of the cubes in which points count as one [m].
constexpr double kCube = 0.004;
/// Step along a straight line, in cells. Between two steps the line may leave a cell by half a step.
constexpr double kStep = 0.25;
/// Half width of a wide line, in cells: half a step and a sixteenth of a cell.
constexpr double kAside = 0.5 * kStep + 0.0625;
/// Range around a cell's centre for which the cell must be valid, in cells: half a cell and half a step.
constexpr double kCover = 0.5 + 0.5 * kStep;

/// A joint limit that leaves less than this share of a cell removes the cell: the next cell covers the remainder, and
/// no path has to end in it.
constexpr double kSliver = 0.5 * kStep;

/// The first and the last cell between two angles, in units of cells.
std::pair<int, int> cells_between(double low, double high) {
  int first = static_cast<int>(std::floor(low + 0.5));
  int last = static_cast<int>(std::floor(high + 0.5));
  if (first < last && first + 0.5 - low < kSliver) ++first;
  if (first < last && high - (last - 0.5) < kSliver) --last;
  return {first, last};
}

/// Bound of the motion of any point of the second link while all angles change by `angle` [m].
double sweep(const ArmPlanes& planes, double angle) {
  const PlanarArm& arm = planes.arm();
  return angle * (arm.reach() + arm.length2);
}

/// The arm with links thick enough that the test at a cell's centre covers the whole cell.
PlanarArm covering(const ArmPlanes& planes, const SensedParameters& parameters, double thick) {
  const double half = kCover * AngleGrid{parameters.cells}.pitch();
  PlanarArm arm = planes.arm().grown(thick);
  arm.width1 += half * arm.length1;
  arm.width2 += sweep(planes, half);
  return arm;
}

/// Thickness that covers the margin, other points in the same cube, and other values of θ₀ in the same cell [m].
double thickness(const ArmPlanes& planes, const SensedParameters& parameters) {
  const double half = kCover * AngleGrid{parameters.cells}.pitch();
  return parameters.margin + std::sqrt(3.0) * kCube + half * planes.radius();
}

std::uint64_t cube_of(const Eigen::Vector3d& p) {
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    const auto place = static_cast<std::int64_t>(std::floor(p[i] / kCube));
    key = key << 21 | (static_cast<std::uint64_t>(place) & 0x1F'FFFF);
  }
  return key;
}

bool reaches(const Slab& slab, double off_plane, double thick) {
  return off_plane >= slab.low - thick && off_plane <= slab.high + thick;
}

/// Moves points that a chain of steps of at most `gap` [m] connects next to each other, and returns the groups.
std::vector<std::span<const Eigen::Vector3d>> obstacles_among(std::span<Eigen::Vector3d> points, double gap) {
  std::vector<std::span<const Eigen::Vector3d>> groups;
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin + 1;
    for (std::size_t from = begin; from < end; ++from) {
      const auto near = [&, p = points[from]](const Eigen::Vector3d& q) { return (q - p).norm() <= gap; };
      const auto rest = points.subspan(end);
      end += static_cast<std::size_t>(std::stable_partition(rest.begin(), rest.end(), near) - rest.begin());
    }
    groups.push_back(points.subspan(begin, end - begin));
    begin = end;
  }
  return groups;
}

}  // namespace

SensedMap::SensedMap(const ArmPlanes& planes, const JointLimits& limits, const SensedParameters& parameters)
    : arm_(planes),
      grid_{parameters.cells},
      thick_(thickness(planes, parameters)),
      mapper_(covering(planes, parameters, thick_), grid_) {
  if (parameters.mapper == Mapper::kPublished) images_ = std::make_shared<const ImageDatabase>(mapper_.arm(), grid_);
  const auto within = [](const JointVector& q) { return JointVector(q.cwiseMax(-2.0 * kPi).cwiseMin(2.0 * kPi)); };
  const Angles a = arm_.angles(within(limits.lower));
  const Angles b = arm_.angles(within(limits.upper));
  for (int i = arm_.spatial() ? 0 : 1; i < 3; ++i) {
    const auto [first, last] = cells_between(grid_.place(std::min(a[i], b[i])), grid_.place(std::max(a[i], b[i])));
    first_[i] = first;
    size_[i] = last - first + 1;
    for (int k = 0; k < size_[i]; ++k) wrapped_[i].push_back(static_cast<std::int16_t>(grid_.wrapped(first_[i] + k)));
  }
  planes_.assign(size_[0], CspaceMap(grid_));
  turns_.resize(size_[0]);
  if (!arm_.spatial()) return;
  std::vector<double> angle, sine, cosine;
  for (int i = 0; i < size_[0]; ++i) angle.push_back(grid_.centre(first_[0] + i));
  const std::size_t padded = (angle.size() + 3) / 4 * 4;
  angle.resize(padded, 0.0);
  sine.resize(padded);
  cosine.resize(padded);
  sine_cosine(angle.data(), static_cast<int>(padded), sine.data(), cosine.data());
  for (int i = 0; i < size_[0]; ++i) turns_[i] = {cosine[i], sine[i]};
}

bool SensedMap::note(const Eigen::Vector3d& p_B) {
  if (!seen_.insert(cube_of(p_B)).second) return false;
  points_.push_back(p_B);
  return true;
}

/// differs from paper: [Li96] counts all points of a scan as one obstacle. Here a step from point to point is at most
/// two thicknesses long. A thickness contains the margin, which covers half of the gap between two beams.
bool SensedMap::map_noted() {
  const auto noted = std::span(points_).subspan(mapped_);
  mapped_ = points_.size();
  bool touched = false;
  if (images_) {
    const double gap = 2.0 * std::max(thick_, images_->spacing());
    for (const auto obstacle_B : obstacles_among(noted, gap)) touched = map_as_published(obstacle_B) || touched;
  } else {
    for (const Eigen::Vector3d& p_B : noted) touched = map_exactly(p_B) || touched;
  }
  return touched;
}

/// [Li96] algorithm 3, steps 2.1 to 2.3, in each plane of θ₀ (section 5). The stored images are of both links.
bool SensedMap::map_as_published(std::span<const Eigen::Vector3d> obstacle_B) {
  bool touched = false;
  std::vector<FundamentalObstacle> in_plane;
  for (int i = 0; i < size_[0]; ++i) {
    in_plane.clear();
    for (const Eigen::Vector3d& p_B : obstacle_B) {
      const PlacedPoint placed = arm_.place(p_B, turns_[i]);
      const bool in_reach =
          reaches(arm_.slab(0), placed.off_plane, thick_) || reaches(arm_.slab(1), placed.off_plane, thick_);
      if (in_reach) in_plane.push_back(fundamental_obstacle(placed.in_plane, images_->spacing()));
    }
    if (in_plane.empty()) continue;
    cspace::map_as_published(in_plane, find_critical_points(in_plane, *images_), *images_, image_);
    planes_[i].block(image_);
    touched = touched || !image_.spans.empty();
  }
  return touched;
}

bool SensedMap::map_exactly(const Eigen::Vector3d& p_B) {
  bool touched = false;
  for (int i = 0; i < size_[0]; ++i) {
    const PlacedPoint placed = arm_.place(p_B, turns_[i]);
    const bool first = reaches(arm_.slab(0), placed.off_plane, thick_);
    const bool second = reaches(arm_.slab(1), placed.off_plane, thick_);
    if (!first && !second) continue;
    mapper_.map(convex_piece(std::span(&placed.in_plane, 1)), image_,
                first && second ? Links::kBoth
                : first         ? Links::kFirst
                                : Links::kSecond);
    planes_[i].block(image_);
    touched = touched || !image_.spans.empty();
  }
  return touched;
}

bool SensedMap::holds(const Eigen::Vector3d& p_B) const {
  return seen_.contains(cube_of(p_B));
}

bool SensedMap::holds_exactly(std::span<const Eigen::Vector3d> points_B) const {
  std::unordered_set<std::uint64_t> cubes;
  for (const Eigen::Vector3d& p_B : points_B) cubes.insert(cube_of(p_B));
  return cubes == seen_;
}

void SensedMap::forget() {
  for (CspaceMap& plane : planes_) plane.clear();
  seen_.clear();
  points_.clear();
  mapped_ = 0;
}

Cell3 SensedMap::cell(int index) const {
  return {index / (size_[1] * size_[2]), index / size_[2] % size_[1], index % size_[2]};
}

std::array<double, 3> SensedMap::places(const JointVector& q) const {
  const Angles angles = arm_.angles(q);
  std::array<double, 3> places{};
  for (int i = arm_.spatial() ? 0 : 1; i < 3; ++i) places[i] = grid_.place(angles[i]) - first_[i];
  return places;
}

Cell3 SensedMap::cell_at(const JointVector& q) const {
  const std::array<double, 3> place = places(q);
  Cell3 cell{};
  for (int i = 0; i < 3; ++i) cell[i] = nearest(i, place[i]);
  return cell;
}

int SensedMap::nearest(int angle, double place) const {
  return std::clamp(static_cast<int>(std::floor(place + 0.5)), 0, size_[angle] - 1);
}

JointVector SensedMap::centre(const Cell3& cell) const {
  Angles angles{};
  for (int i = arm_.spatial() ? 0 : 1; i < 3; ++i) angles[i] = grid_.centre(first_[i] + cell[i]);
  return arm_.joints(angles);
}

bool SensedMap::straight_path_free(const JointVector& from, const JointVector& to, bool wide) const {
  const std::array<double, 3> a = places(from);
  const std::array<double, 3> b = places(to);
  double longest = 0.0;
  for (int i = 0; i < 3; ++i) longest = std::max(longest, std::abs(b[i] - a[i]));
  const int steps = static_cast<int>(std::ceil(longest / kStep));
  const double aside = wide ? kAside : 0.0;
  for (int k = 0; k <= steps; ++k) {
    const double share = steps == 0 ? 0.0 : static_cast<double>(k) / steps;
    Cell3 first{};
    Cell3 last{};
    for (int i = 0; i < 3; ++i) {
      const double place = a[i] + share * (b[i] - a[i]);
      first[i] = nearest(i, place - aside);
      last[i] = nearest(i, place + aside);
    }
    if (any_blocked(first, last)) return false;
  }
  return true;
}

bool SensedMap::any_blocked(const Cell3& first, const Cell3& last) const {
  for (int i = first[0]; i <= last[0]; ++i) {
    for (int k = first[1]; k <= last[1]; ++k) {
      for (int m = first[2]; m <= last[2]; ++m) {
        if (blocked({i, k, m})) return true;
      }
    }
  }
  return false;
}

void GrowingMap::note(double distance, const Eigen::Vector3d& p_B) {
  if (!map_.holds(p_B)) waiting_.push_back({distance, p_B});
}

bool GrowingMap::advance(int& points) {
  std::stable_sort(waiting_.begin(), waiting_.end(),
                   [](const Waiting& a, const Waiting& b) { return a.distance < b.distance; });
  auto next = waiting_.begin();
  for (; next != waiting_.end(); ++next) {
    if (map_.holds(next->p_B)) continue;
    if (points <= 0) break;
    (void)map_.note(next->p_B);
    --points;
  }
  waiting_.erase(waiting_.begin(), next);
  return map_.map_noted();
}

bool GrowingMap::add(std::span<const Eigen::Vector3d> points_B) {
  for (const Eigen::Vector3d& p_B : points_B) (void)map_.note(p_B);
  return map_.map_noted();
}

void GrowingMap::forget() {
  map_.forget();
  waiting_.clear();
}

}  // namespace hecaton::planner::cspace
