#pragma once
/// Collision checks of configurations and edges. Conservative: a configuration reported as free is free.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/swept_core.hpp"
#include "planner/global/kernel_shapes.hpp"
#include "planner/global/validity_kernel.hpp"

namespace hecaton::planner::global {

/// The bodies of all free obstacles, and of all other arms. `X_WO`: poses in the order of the geometry's obstacles.
/// `others`: one configuration per arm of the cell. Empty: without that arm. The own arm's entry is ignored.
[[nodiscard]] std::vector<WorldBody> world_bodies(const CellGeometry& geometry, std::span<const Pose> X_WO,
                                                  std::span<const JointVector> others);

/// Upper bounds of the motion of a body's points per unit of a joint [m/rad | 1]: row by row for every own body of the
/// geometries, one for each joint of all their own arms. They hold for any values of the other joints within their
/// limits. Rounded up.
[[nodiscard]] std::vector<float> body_levers(const std::vector<CellGeometry>& planned);

struct ValidityOptions {
  CoverOptions cover;
  double step = 0.03;         ///< between checked configurations of an edge, in joint space [rad | m]
  double padding = 0.0;       ///< minimum distance from obstacles and between arms [m]; not for bodies that do not move
  double self_padding = 0.0;  ///< minimum distance between links of one arm [m]
};

/// Checks the own arms of one or several geometries, as one robot, in a fixed world. A configuration concatenates the
/// joints of all arms. Spheres cover the links; where they do not decide, the exact distance of the shapes does.
/// Numbers are floats; larger spheres make up for rounding. A free configuration may be reported as colliding if less
/// than a few hundredths of a millimetre is left. Bodies that no joint moves may touch obstacles. Not thread-safe
/// (counts checks).
class Validity {
 public:
  /// Throws std::invalid_argument for more than kMaxDimensions joints, kMaxBodies bodies or kMaxSpheres spheres.
  Validity(std::vector<CellGeometry> planned, std::span<const WorldBody> world, const ValidityOptions& options = {});

  void set_world(std::span<const WorldBody> world);

  [[nodiscard]] int dimensions() const { return robot_.dimensions; }
  /// Floats per configuration: dimensions(), rounded up to whole lanes.
  [[nodiscard]] int stride() const { return (robot_.dimensions + kWidth - 1) / kWidth * kWidth; }
  [[nodiscard]] const std::vector<CellGeometry>& planned() const { return planned_; }
  [[nodiscard]] const ValidityOptions& options() const { return options_; }
  [[nodiscard]] const KernelRobot& robot() const { return robot_; }
  [[nodiscard]] const KernelWorld& world() const { return world_; }
  [[nodiscard]] ExactCheck exact() const { return {this, from_obstacle, from_body}; }

  [[nodiscard]] bool state_free(const float* q) const;
  /// Bit i: configuration i of eight, stride() floats each, collides.
  [[nodiscard]] unsigned collisions(const float* eight) const;
  /// True if no configuration on the straight edge from a to b collides. a itself is not checked. `finer`: factor of
  /// the number of configurations.
  [[nodiscard]] bool edge_free(const float* a, const float* b, int finer = 1) const;

  /// Continuous check of the edge from a to b [Schwarzer05]: enlarges the bodies by the most that they can move on a
  /// segment, and halves segments that this does not decide. `clearance`: distance to keep from the world beyond the
  /// padding [m]. False if the edge collides or if the check stays undecided.
  [[nodiscard]] bool proven_free(const float* a, const float* b, double clearance = 0.0) const;
  /// The same for the parabola (1 − t)² a + 2 t (1 − t) corner + t² b. `spread`: also for all configurations within
  /// this distance of the parabola, joint by joint [rad | m]; may be null.
  [[nodiscard]] bool proven_free(const float* a, const float* corner, const float* b, double clearance = 0.0,
                                 const float* spread = nullptr) const;

  /// Number of configurations checked since construction.
  [[nodiscard]] std::uint64_t checks() const { return checks_; }

  /// A pair of bodies and its exact distance.
  struct Nearest {
    std::string a;
    std::string b;
    double distance = 0.0;  ///< [m]; negative: depth; infinite without any pair
    double required = 0.0;  ///< minimum distance of this pair [m]
  };
  /// The pair with the smallest distance. `q`: dimensions() values [rad | m].
  [[nodiscard]] Nearest nearest(std::span<const double> q) const;
  /// The pair with the smallest margin beyond its minimum distance: the reason why q is not free.
  [[nodiscard]] Nearest tightest(std::span<const double> q) const;

  enum class Pairs : std::uint8_t {
    kAll,
    kNotOwn,  ///< without pairs of two links of one arm
  };
  /// Lower bound of the smallest distance of these pairs anywhere on the edge from a to b [m]; negative: depth;
  /// infinite without any pair. At most 0.2 % or 2 µm below the true value, unless that takes more than a million
  /// distances.
  [[nodiscard]] double clearance(std::span<const double> a, std::span<const double> b, Pairs pairs = Pairs::kAll) const;

 private:
  [[nodiscard]] Nearest smallest(std::span<const double> q, bool as_margin) const;
  void add_arm(const CellGeometry& geometry, int first_dimension, int first_body);
  void add_pairs(const std::vector<int>& first_body);
  static double from_obstacle(const void* self, int body, const float* frame, int obstacle);
  static double from_body(const void* self, int a, const float* frame_a, int b, const float* frame_b);

  /// A shape and its pose in its kernel frame; for bodies of the world, in O.
  struct PlacedCore {
    SweptCore core;
    Pose X_FS = Pose::Identity();
  };

  std::vector<CellGeometry> planned_;
  std::vector<WorldBody> world_bodies_;
  ValidityOptions options_;
  Pose X_OW_;     ///< O: the frame of the kernel, at the first arm's base
  double scale_;  ///< upper bound of the coordinates of moving bodies in O [m]
  KernelRobot robot_;
  KernelWorld world_;
  std::vector<PlacedCore> body_cores_;
  std::vector<int> body_arm_;  ///< index of each body's arm in planned_
  std::vector<float> levers_;  ///< see body_levers()
  std::vector<PlacedCore> world_cores_;
  mutable std::uint64_t checks_ = 0;
};

}  // namespace hecaton::planner::global
