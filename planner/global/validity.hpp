#pragma once
/// Collision checks of configurations and edges. Conservative: a configuration reported as free is free.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/swept_core.hpp"
#include "planner/global/kernel_robot.hpp"
#include "planner/global/kernel_shapes.hpp"
#include "planner/global/validity_kernel.hpp"

namespace hecaton::planner::global {

/// The bodies of all free obstacles, and of all other arms. `X_WO`: poses in the order of the geometry's obstacles.
/// `others`: one configuration per arm of the cell. Empty: without that arm. The own arm's entry is ignored.
[[nodiscard]] std::vector<WorldBody> world_bodies(const CellGeometry& geometry, std::span<const Pose> X_WO,
                                                  std::span<const JointVector> others);

/// How an edge is checked.
struct EdgeCheck {
  /// Every configuration of the edge is free. Otherwise at most ValidityOptions::step is between checked
  /// configurations, the first end is not checked, and something thin can lie between them.
  bool proven = true;
  double clearance = 0.0;  ///< distance to keep from the world beyond the padding [m]
};

/// Distances and steps of the checks.
struct ValidityOptions {
  CoverOptions cover;    ///< balls that cover the bodies
  double step = 0.03;    ///< between checked configurations of an edge that is not proven, in joint space [rad | m]
  double padding = 0.0;  ///< minimum distance from obstacles and between arms [m]; not for bodies that do not move
  double self_padding = 0.0;  ///< minimum distance between links of one arm [m]
};

/// Checks the own arms of one or several geometries, as one robot, in a fixed world. A configuration concatenates the
/// joints of all arms. Balls cover the links; where they do not decide, the exact distance of the shapes does.
/// Numbers are floats; larger balls make up for rounding, up to 10 rad for joints without limits. A free configuration
/// may be reported as colliding if less than a few hundredths of a millimetre is left. Bodies that no joint moves may
/// touch obstacles. Results may differ between processors where rounding decides. Not thread-safe (counts checks).
class Validity {
 public:
  /// Throws std::invalid_argument for more than kMaxDimensions joints, kMaxBodies bodies or kMaxBalls balls.
  Validity(std::vector<CellGeometry> planned, std::span<const WorldBody> world, const ValidityOptions& options = {});

  void set_world(std::span<const WorldBody> world);  ///< replaces obstacles and other arms

  [[nodiscard]] int dimensions() const { return built_.robot.dimensions; }  ///< joints of all planned arms
  /// Floats per configuration: dimensions(), rounded up to whole lanes.
  [[nodiscard]] int stride() const { return (built_.robot.dimensions + kWidth - 1) / kWidth * kWidth; }
  [[nodiscard]] const std::vector<CellGeometry>& planned() const { return planned_; }  ///< as given
  [[nodiscard]] const ValidityOptions& options() const { return options_; }            ///< as given
  [[nodiscard]] const KernelRobot& robot() const { return built_.robot; }  ///< planned arms, for validity_kernel.hpp
  [[nodiscard]] const KernelWorld& world() const { return world_; }        ///< all else, for validity_kernel.hpp

  /// True if the configuration touches nothing. Joint limits are not checked.
  [[nodiscard]] bool state_free(const float* q) const;
  /// Bit i: configuration i of kWidth, stride() floats each, collides.
  [[nodiscard]] unsigned collisions(const float* q) const;
  /// True if the straight edge from a to b is free. A proven edge is free for all points between the given numbers,
  /// rounding included [Schwarzer05]; false if it collides or if that stays undecided.
  [[nodiscard]] bool edge_free(const float* a, const float* b, const EdgeCheck& check = {}) const;
  /// The same proof for the parabola (1 − t)² a + 2 t (1 − t) corner + t² b. `spread`: also for all configurations
  /// within this distance of the parabola, joint by joint [rad | m]; may be null.
  [[nodiscard]] bool curve_free(const float* a, const float* corner, const float* b, double clearance = 0.0,
                                const float* spread = nullptr) const;
  /// edge_free() by one of the compilations of the kernel, to compare them.
  [[nodiscard]] bool edge_free(const ValidityKernel& kernel, const float* a, const float* b,
                               const EdgeCheck& check) const;
  /// collisions() by one of them.
  [[nodiscard]] unsigned collisions(const ValidityKernel& kernel, const float* q) const;

  /// What the checks since construction cost, in configurations: an edge counts its length divided by the step.
  [[nodiscard]] std::uint64_t checks() const { return checks_; }

  /// A pair of bodies and its exact distance.
  struct Nearest {
    std::string a;          ///< "arm/link"
    std::string b;          ///< "arm/link" or an obstacle
    double distance = 0.0;  ///< [m]; negative: depth; infinite without any pair
    double required = 0.0;  ///< minimum distance of this pair [m]
  };
  /// The pair with the smallest distance. `q`: dimensions() values [rad | m].
  [[nodiscard]] Nearest nearest(std::span<const double> q) const;
  /// The pair with the smallest margin beyond its minimum distance: the reason why q is not free.
  [[nodiscard]] Nearest tightest(std::span<const double> q) const;

  /// Which pairs of bodies count.
  enum class Pairs : std::uint8_t {
    kAll,     ///< all that can move relative to each other
    kNotOwn,  ///< without pairs of two links of one arm
  };
  /// Lower bound of the smallest distance of these pairs anywhere on the edge from a to b [m]; negative: depth;
  /// infinite without any pair. At most 0.2 % or 2 µm below the true value, unless that takes more than a million
  /// distances.
  [[nodiscard]] double clearance(std::span<const double> a, std::span<const double> b, Pairs pairs = Pairs::kAll) const;

 private:
  [[nodiscard]] Nearest smallest(std::span<const double> q, bool as_margin) const;
  void count_checks(const float* a, const float* b) const;
  [[nodiscard]] KernelScene scene(const ValidityKernel& kernel) const;
  static ExactGap from_obstacle(const void* self, int body, int obstacle, ExactQuestion& question);
  static ExactGap from_body(const void* self, int a, int b, ExactQuestion& question);

  std::vector<CellGeometry> planned_;
  std::vector<WorldBody> world_bodies_;
  ValidityOptions options_;
  Pose X_OW_;  ///< O: the frame of the kernel, at the first arm's base
  BuiltRobot built_;
  KernelWorld world_;
  std::vector<float> levers_;            ///< see body_levers()
  std::vector<PlacedCore> world_cores_;  ///< of points only the pose counts
  mutable KernelMemory memory_;
  mutable std::uint64_t checks_ = 0;
};

}  // namespace hecaton::planner::global
