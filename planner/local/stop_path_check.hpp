#pragma once
/// Whether an arm can stop without touching itself after the next period. The last line behind the dampers, which are
/// exact to first order only (docs/explanation/0020-stop-paths.md).

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/swept_core.hpp"
#include "planner/local/parameters.hpp"
#include "planner/local/velocity_constraints.hpp"

namespace hecaton::planner {

/// The path of a velocity is the motion of the next period to that velocity, followed by the stop profile. Checks the
/// whole path of a velocity against all pairs of the arm's own bodies.
///
/// Remembers a lower bound of each pair's distance from one period to the next, so that most periods measure nothing.
/// Answers do not depend on what it remembers. Only the constructor allocates. Not thread-safe.
class StopPathCheck {
 public:
  /// Throws std::invalid_argument if links of a pair are on either side of a prismatic joint without limits.
  explicit StopPathCheck(const CellGeometry& geometry);

  /// The arm at the beginning of a period.
  struct Start {
    const JointVector& q;               ///< reference position [rad | m]
    const JointVector& qd;              ///< reference velocity [rad/s | m/s]
    const JointVector& tracking_error;  ///< measured minus reference position, kept along the path; empty: none
    double dt;                          ///< control period [s]
    std::span<const Clearance> near;    ///< what ExactDistance::clearances found at q, or a part of it, in its order
  };
  /// Begins a period. `geometry` is that of the constructor. It and `start.near` must outlive the calls of is_clear().
  void begin(const CellGeometry& geometry, const DamperParameters& damper, const Start& start);
  /// Ends the period: is_clear() then answers false.
  void end() { period_.arm = nullptr; }

  /// True if no pair comes nearer on the path of `qd_next` than the limit: half of the security distance of the pair,
  /// or its present distance, if that is less. Measures at points so close together that a pair comes nearer in between
  /// by at most a quarter of the limit; by at most a sixteenth if its present distance is below five eighths of the
  /// limit. A pair that overlaps at the beginning is compared at these points only. False, too, when the period's
  /// measurements are used up.
  [[nodiscard]] bool is_clear(const JointVector& qd_next);

  /// The own bodies (first < second) for which the last is_clear() was false; empty if it was true, or false for
  /// another reason.
  [[nodiscard]] std::optional<std::pair<int, int>> refused() const;
  /// A row that keeps the limit at the refused place, to first order: a plane that cuts the refused velocity off.
  /// Precondition: refused(), and no call of is_clear() since.
  [[nodiscard]] Row cut();

 private:
  /// An own body.
  struct Part {
    int body = 0;  ///< index
    int link = 0;
    SweptCore core;
    Pose X_LS = Pose::Identity();
  };
  struct Pair {
    Part first;
    Part second;
    JointVector rates;    ///< bound on the change of the distance per unit of each joint's motion [m/rad | 1]
    double widest = 0.0;  ///< the largest distance in any posture [m]
    double limit = 0.0;   ///< that the path keeps [m]
    double bound = 0.0;   ///< lower bound of the distance at anchor_ [m]
  };
  /// A pair that its bound does not clear.
  struct OpenPair {
    Pair* pair = nullptr;
    double limit = 0.0;        ///< of this path [m]
    double period_rate = 0.0;  ///< bound on the change of the distance in the period [m/s]
    double stop_rate = 0.0;    ///< the same in the stop, ≤ period_rate
    double due = 0.0;          ///< place of the next measurement on the path [s]
    bool open = true;
  };
  /// A velocity. Places on its path are times: until dt that of the period, then dt plus the way along q̇.
  struct Path {
    const JointVector& qd_next;
    JointVector fastest;  ///< largest speed of each joint in the period [rad/s | m/s]
    JointVector slowed;   ///< the same in the stop, along the way
    double end = 0.0;     ///< [s]
  };
  struct Period {
    const Arm* arm = nullptr;  ///< null: between periods
    std::span<const Clearance> near;
    JointVector q;  ///< as measured [rad | m]
    JointVector qd;
    JointVector error;  ///< absolute [rad | m]
    double dt = 0.0;
    int measurements = 0;
  };
  struct Refusal {
    const Pair* pair = nullptr;
    double limit = 0.0;        ///< the distance that the path must keep there [m]
    ShapeDistance distance{};  ///< of the two bodies at that place
    double at = 0.0;           ///< place on the path [s]
    JointVector qd;            ///< the velocity that the path belongs to
  };

  void set_limits(const DamperParameters& damper);
  [[nodiscard]] bool bounds_clear(const JointVector& travel) const;
  void move_anchor();
  void open_pairs(const Path& path, const JointVector& travel);
  [[nodiscard]] JointVector place(const JointVector& qd_next, double at) const;
  [[nodiscard]] bool walk(const Path& path);
  [[nodiscard]] bool measure(const Path& path, double at, OpenPair& open);

  std::vector<Pair> pairs_;
  double security_distance_ = 0.0;  ///< that the limits belong to [m]
  JointVector anchor_;              ///< configuration of the bounds [rad | m]
  std::vector<OpenPair> open_;
  std::unique_ptr<Kinematics> kinematics_;
  Period period_;
  std::optional<Refusal> refusal_;
};

}  // namespace hecaton::planner
