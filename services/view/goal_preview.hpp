#pragma once
/// Answers for a page on which a person drags the tool of an arm: the joint positions for a tool pose, and why the arm
/// could not be there. It gives no orders. Its collision check has the same geometry as the planners', and the
/// planners' check of goals decides at the end.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <idl/common.h>

#include "planner/cell.hpp"
#include "planner/collision/cell_geometry.hpp"
#include "planner/collision/exact_distance.hpp"
#include "services/view/cell_state.hpp"
#include "services/view/json.hpp"

namespace hecaton::services {

/// What a page asks.
struct PreviewQuestion {
  std::uint64_t page = 0;  ///< number of its WebClient
  std::int64_t id = 0;     ///< that the page gave the question
  int arm = 0;             ///< index in the cell
  world::Pose X_WT = world::Pose::Identity();
  planner::JointVector start;  ///< of the search: the last answer [rad | m]; empty: where the arm is
};

/// What a preview needs of a CellState. A value for another thread.
struct PreviewScene {
  std::vector<std::optional<planner::JointVector>> q;  ///< of each arm; empty: unknown [rad | m]
  std::shared_ptr<const CellState::Obstacles> obstacles;
  std::uint64_t edition = 0;              ///< of the obstacles
  std::map<std::string, msg::Pose> X_WO;  ///< present poses of obstacles, by name

  /// Throws nothing; invalid joint positions count as unknown.
  [[nodiscard]] static PreviewScene of(const CellState& state);
};

enum class PreviewVerdict : std::uint8_t {
  kFree,         ///< the arm can be there
  kNear,         ///< a body is nearer than the security distance: the arm would stop before it
  kOccupied,     ///< another arm is there at present: a goal may wait for it
  kCollision,    ///< with the arm itself, an obstacle, the floor or the fixed part of another arm
  kUnreachable,  ///< no joint positions within the limits were found
  kUnknown,      ///< the question cannot be answered
};
[[nodiscard]] std::string_view name_of(PreviewVerdict verdict);

struct PreviewAnswer {
  std::uint64_t page = 0;
  std::int64_t id = 0;
  int arm = 0;
  planner::JointVector q;  ///< for the pose, or for the nearest one that was found [rad | m]; empty: none
  PreviewVerdict verdict = PreviewVerdict::kUnknown;
  bool accepted = false;  ///< q may be a goal
  std::string text;       ///< one short sentence without a full stop; empty: nothing to say
  std::string own;        ///< the nearest bodies: of the arm; empty: none are near
  std::string other;      ///< and the other one, or "floor"
  double distance = 0.0;  ///< between them [m]; negative: depth
};

/// The message of the page, as `PreviewMessage` in page/src/protocol.ts.
[[nodiscard]] view::Json preview_json(const planner::Cell& cell, const PreviewAnswer& answer);

/// Computes previews. For one thread.
class PreviewSolver {
 public:
  /// `cell` must outlive it.
  explicit PreviewSolver(const planner::Cell& cell);

  /// Searches near `question.start` and then from a few random postures for one that is free. An arm with fewer than
  /// six joints takes the nearest pose. Takes a few milliseconds, and up to 0.1 s where nothing is free. Deterministic.
  [[nodiscard]] PreviewAnswer answer(const PreviewQuestion& question, const PreviewScene& scene);

 private:
  struct Blockage {
    PreviewVerdict verdict = PreviewVerdict::kFree;
    std::string text;
    std::string own;
    std::string other;
    double distance = 0.0;
  };

  void update(const PreviewQuestion& question, const PreviewScene& scene);
  [[nodiscard]] Blockage blockage(const planner::JointVector& q);
  [[nodiscard]] std::optional<Blockage> below_floor(const planner::Kinematics& kinematics) const;
  [[nodiscard]] bool rests(const planner::Clearance& clearance) const;
  void conclude(PreviewAnswer& answer);

  const planner::Cell& cell_;
  int arm_ = -1;  ///< for which the geometry is
  std::uint64_t edition_ = 0;
  std::optional<planner::CellGeometry> geometry_;
  std::optional<planner::ExactDistance> distances_;
  std::vector<std::string> obstacle_names_;
  std::vector<world::ObstacleState> obstacles_;  ///< of the geometry, at present
  std::vector<planner::Kinematics> arms_;        ///< at present
  std::vector<int> known_arms_;                  ///< other arms whose positions are known
};

/// A PreviewSolver in a background thread of low priority. It works on one question at a time and for at most half of
/// the time. All functions are for one thread and do not wait, except the destructor: if the background thread is
/// preempted while it holds the lock, they find nothing.
class GoalPreview {
 public:
  using Clock = std::chrono::steady_clock;

  /// `cell` must outlive it.
  explicit GoalPreview(const planner::Cell& cell);
  ~GoalPreview();  ///< waits for the present question
  GoalPreview(const GoalPreview&) = delete;
  GoalPreview& operator=(const GoalPreview&) = delete;

  /// It can take a question.
  [[nodiscard]] bool ready(Clock::time_point now) const;
  /// Call it only when ready().
  void ask(PreviewQuestion question, PreviewScene scene);
  /// The answer to the last question, once.
  [[nodiscard]] std::optional<PreviewAnswer> take_answer();

 private:
  struct Task {
    PreviewQuestion question;
    PreviewScene scene;
  };
  void work(const std::stop_token& stop);

  PreviewSolver solver_;  // of the thread alone
  mutable std::mutex mutex_;
  std::condition_variable_any asked_;
  std::optional<Task> task_;
  std::optional<PreviewAnswer> answer_;
  bool busy_ = false;
  Clock::time_point rests_until_{};
  std::jthread thread_;  // last: it uses all of it
};

}  // namespace hecaton::services
