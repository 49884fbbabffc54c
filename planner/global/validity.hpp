#pragma once
/// Whether configurations, and straight ways between them, are free of collision: fast and never too optimistic.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/swept_core.hpp"
#include "planner/global/sphere_cover.hpp"
#include "planner/global/validity_data.hpp"

namespace hecaton::planner::global {

/// What stands in the way, where it stands.
struct WorldBody {
  world::Shape shape;
  Pose X_WS = Pose::Identity();
  std::string name;  ///< what messages call it
};

/// The bodies of all obstacles that nobody carries, at these poses (in the order of the geometry's obstacles), and
/// those of all other arms in their configurations `others`: one for each arm of the cell, empty for arms to leave out;
/// the own is not read.
[[nodiscard]] std::vector<WorldBody> world_bodies(const CellGeometry& geometry, std::span<const Pose> X_WO,
                                                  std::span<const JointVector> others);

struct ValidityOptions {
  CoverOptions cover;
  double step = 0.03;  ///< between configurations that are checked on a straight way, in joint space [rad | m]
  /// Distances from obstacles and between arms are kept above this, but for a body that no joint moves [m].
  double padding = 0.0;
  double self_padding = 0.0;  ///< and between links of one arm above this [m]
};

/// The own arms of one or several geometries as one robot in a standing world. The robots' joints follow one another in
/// a configuration. Links are covered by balls, all numbers are floats and rounding is made up for by larger balls;
/// where balls do not tell, the shapes' exact distance does. What is said to be free is free, what is said to collide
/// may have a few hundredths of a millimetre left. As elsewhere, bodies that no joint moves may stand in obstacles.
class Validity {
 public:
  /// Throws std::invalid_argument for more than kMostDimensions joints.
  Validity(std::vector<CellGeometry> planned, std::span<const WorldBody> world, const ValidityOptions& options = {});

  void set_world(std::span<const WorldBody> world);

  [[nodiscard]] int dimensions() const { return robot_.dimensions; }
  /// Floats between configurations: dimensions, rounded up to whole lanes.
  [[nodiscard]] int stride() const { return (robot_.dimensions + kWidth - 1) / kWidth * kWidth; }
  [[nodiscard]] const std::vector<CellGeometry>& planned() const { return planned_; }
  [[nodiscard]] const ValidityOptions& options() const { return options_; }
  [[nodiscard]] const KernelRobot& robot() const { return robot_; }
  [[nodiscard]] const KernelWorld& world() const { return world_; }
  [[nodiscard]] ExactCheck exact() const { return {this, from_obstacle, from_body}; }

  [[nodiscard]] bool state_free(const float* q) const;
  /// Bit i: configuration i of eight, stride() floats each, collides.
  [[nodiscard]] unsigned collisions(const float* eight) const;
  /// The way from a to b; a itself is taken to be free. `finer`: checks this many times as often.
  [[nodiscard]] bool edge_free(const float* a, const float* b, int finer = 1) const;

  /// Whether the way from a to b is free everywhere, not only where it is looked at: each stretch of it with its bodies
  /// made larger by the farthest that they can move on it, halved where that does not tell. `clearance` is kept from
  /// the world beyond the padding [m].
  [[nodiscard]] bool proven_free(const float* a, const float* b, double clearance = 0.0) const;
  /// The same of the parabola with these control points: (1 − t)² a + 2 t (1 − t) corner + t² b. With `spread`, of
  /// everything that is no farther from it than this, joint by joint [rad | m].
  [[nodiscard]] bool proven_free(const float* a, const float* corner, const float* b, double clearance = 0.0,
                                 const float* spread = nullptr) const;

  /// Configurations looked at since construction.
  [[nodiscard]] std::uint64_t checks() const { return checks_; }

  /// The pair of bodies that is nearest by exact distances, with that distance: what really is in the way.
  struct Nearest {
    std::string a;
    std::string b;
    double distance = 0.0;  ///< [m]; negative: depth; infinite without any pair
    double wanted = 0.0;    ///< is kept between the two [m]
  };
  [[nodiscard]] Nearest nearest(std::span<const double> q) const;
  /// The pair that has the least room beyond what is wanted: why a configuration is not free.
  [[nodiscard]] Nearest tightest(std::span<const double> q) const;

  enum class Pairs : std::uint8_t {
    kAll,
    kNotOwn,  ///< without those of two links of one arm
  };
  /// The smallest distance of these pairs on the straight way from a to b, everywhere on it: never more than that, and
  /// less by 0.2 % or 2 µm at most, unless that takes more than a million distances [m]. Negative: depth; infinite
  /// without any pair.
  [[nodiscard]] double clearance(std::span<const double> a, std::span<const double> b, Pairs pairs = Pairs::kAll) const;

 private:
  [[nodiscard]] Nearest least(std::span<const double> q, bool beyond_wanted) const;
  void add_arm(const CellGeometry& geometry, int first_dimension, int first_body);
  void add_pairs(const std::vector<int>& first_body);
  static double from_obstacle(const void* self, int body, const float* frame, int obstacle);
  static double from_body(const void* self, int a, const float* frame_a, int b, const float* frame_b);

  /// A shape, prepared, and its place: in its kernel frame, or for the world's in O.
  struct PlacedCore {
    SweptCore core;
    Pose X_FS = Pose::Identity();
  };

  std::vector<CellGeometry> planned_;
  std::vector<WorldBody> world_bodies_;
  ValidityOptions options_;
  Pose X_OW_;     ///< the frame O in which the kernel computes: the first arm's base
  double scale_;  ///< no coordinate of a moved body is larger in O [m]
  KernelRobot robot_;
  KernelWorld world_;
  std::vector<PlacedCore> body_cores_;
  std::vector<int> body_arm_;  ///< of the planned ones
  std::vector<float> levers_;  ///< by body and coordinate: no point of it moves farther for a unit [m/rad | 1]
  std::vector<PlacedCore> world_cores_;
  mutable std::uint64_t checks_ = 0;
};

}  // namespace hecaton::planner::global
