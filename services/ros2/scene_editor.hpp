#pragma once
/// Planning scenes of MoveIt, carried out as edits of the cell's obstacles.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "services/client/connection.hpp"
#include "services/config/cell_file.hpp"
#include "services/ros2/node_graph.hpp"
#include "services/ros2/order_report.hpp"
#include "services/ros2/planning_scene.hpp"
#include "services/ros2/publisher.hpp"
#include "services/ros2_messages/cell_view.hpp"

namespace hecaton::ros2 {

/// Carries out edits one after the other. All calls are for one thread, but for report().
///
/// An obstacle with other shapes replaces one of its name by a removal and an addition. When the addition fails, the
/// worker repeats it each second until the world has the obstacle: in its new form, or else as it was. A later edit of
/// that name acts on what shall be added, and a removal ends the attempts.
class SceneWorker {
 public:
  explicit SceneWorker(std::shared_ptr<client::Connection> connection);

  /// Takes the edits of one scene. A scene in excess of kMostWaiting objects and shapes is refused.
  void add(SceneEdits scene);
  /// Edits, and objects that were refused. Thread-safe.
  [[nodiscard]] OrderReport report() const;

  static constexpr std::size_t kMostWaiting = 8192;

 private:
  /// An obstacle that the world lacks because of this worker.
  struct Missing {
    std::vector<world::Obstacle> versions;  ///< the first one that the world accepts is added
    std::string reason;                     ///< why it is missing
  };

  void carry_out(const SceneEdits& scene, const std::stop_token& stop);
  void run(const std::stop_token& stop);
  void apply(const SceneEdit& edit, const Wait& wait);
  void apply_to_known(const SceneEdit& edit, const Wait& wait);
  /// False: the edit has ended with this.
  [[nodiscard]] bool apply_to_missing(const SceneEdit& edit, const Wait& wait);
  void add_or_replace(const SceneEdit& edit, const Wait& wait);
  void replace(const msg::ObstacleShapes& old, const world::Pose& X_WO, world::Obstacle next, const Wait& wait);
  /// True when an arm carries the obstacle. Throws Error.
  bool is_carried(const std::string& obstacle, const Wait& wait);
  void require(const msg::WorldEditReply& reply) const;
  msg::WorldEditReply request(msg::EditKind kind, const SceneEdit& edit, const Wait& wait);
  msg::WorldEditReply add_obstacle(const world::Obstacle& obstacle, const Wait& wait);
  /// Adds a missing obstacle. Why the world has refused the first version; empty: it has not. Throws Error.
  std::optional<std::string> add_missing(const std::string& obstacle, const Wait& wait);
  /// Tries to add all missing obstacles.
  void restore_missing(const std::stop_token& stop);
  /// Logs and reports which obstacles are missing.
  void report_missing();
  /// The scene, with the shapes of the obstacle after the last edit of this worker. Throws Error.
  client::Connection::Scene scene_with(const std::string& obstacle, const Wait& wait);
  void refuse(const SceneRefusal& refusal);

  std::shared_ptr<client::Connection> connection_;
  std::map<std::string, std::uint64_t> editions_;  ///< of the scene after the last edit of each obstacle's shapes
  std::map<std::string, Missing> missing_;
  std::set<std::string> reported_missing_;
  mutable std::mutex mutex_;
  std::condition_variable_any arrived_;
  std::deque<SceneEdits> scenes_;
  std::size_t waiting_ = 0;  ///< objects and shapes in scenes_
  OrderReport report_{.name = "planning scene"};
  std::jthread thread_;
};

/// The topics NAMESPACE/planning_scene, with links as `ARM_LINK`, and NAMESPACE/ARM/planning_scene, with the names of
/// the arm's own URDF besides. For one thread.
class SceneTopics {
 public:
  /// `file` and `mailbox` must outlive it.
  SceneTopics(bus::Participant& participant, const config::CellFile& file,
              std::shared_ptr<client::Connection> connection, bus::Mailbox& mailbox);

  /// Takes the scenes that have arrived. Frames are where the arms were measured last.
  void update(const CellView& view, bus::Clock::time_point now);
  [[nodiscard]] OrderReport report() const { return worker_.report(); }
  [[nodiscard]] NodeEndpoints endpoints() const;

 private:
  struct ArmTopic {
    std::size_t arm;
    Subscription<PlanningScene> scenes;
  };
  SceneWorker worker_;
  Subscription<PlanningScene> cell_;
  std::vector<ArmTopic> arms_;
};

}  // namespace hecaton::ros2
