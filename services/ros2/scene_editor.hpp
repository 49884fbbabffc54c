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
class SceneWorker {
 public:
  explicit SceneWorker(std::shared_ptr<client::Connection> connection);

  /// Takes the edits of one scene. A scene in excess of kMostWaiting objects and shapes is refused.
  void add(SceneEdits scene);
  /// Edits, and objects that were refused. Thread-safe.
  [[nodiscard]] OrderReport report() const;

  static constexpr std::size_t kMostWaiting = 8192;

 private:
  void carry_out(const SceneEdits& scene, const std::stop_token& stop);
  void run(const std::stop_token& stop);
  /// Why the edit was ignored; empty: it was carried out. Throws Error.
  std::string apply(const SceneEdit& edit, const Wait& wait);
  void carry_out(const SceneEdit& edit, const Wait& wait);
  void add_or_replace(const SceneEdit& edit, const Wait& wait);
  void replace(const msg::ObstacleShapes& old, const world::Obstacle& next, const Wait& wait);
  void remove_all(const std::string& source, const Wait& wait);
  void detach_all(const std::string& arm, const Wait& wait);
  /// Goes on after a refusal, and throws the last one. Ignores obstacles that are gone.
  void carry_out_each(const std::vector<SceneEdit>& edits, const Wait& wait);
  /// True when an arm carries the obstacle. Throws Error.
  bool is_carried(const std::string& obstacle, const Wait& wait);
  void require(const msg::WorldEditReply& reply) const;
  /// False when planning scenes did not add the obstacle, or another client has put another one in its place since.
  [[nodiscard]] bool is_added(const std::string& obstacle, const msg::ObstacleShapes& shapes) const;
  void note_attachment(const SceneEdit& edit);
  msg::WorldEditReply request(msg::EditKind kind, const SceneEdit& edit, const Wait& wait);
  /// An edit that carries an obstacle: EDIT_ADD or EDIT_REPLACE.
  msg::WorldEditReply put(msg::EditKind kind, const world::Obstacle& obstacle, const Wait& wait);
  /// The scene, with the shapes of the obstacle after the last edit of this worker. Throws Error.
  client::Connection::Scene scene_with(const std::string& obstacle, const Wait& wait);
  /// The scene after all edits of this worker. Throws Error.
  client::Connection::Scene scene_after_edits(const Wait& wait);
  void refuse(const SceneRefusal& refusal);

  /// An obstacle that planning scenes added.
  struct Added {
    std::set<std::string> sources;  ///< topics on which it came, as SceneEdit::source
    std::vector<msg::PlacedShape> shapes;
  };
  std::shared_ptr<client::Connection> connection_;
  std::map<std::string, std::uint64_t> editions_;  ///< of the scene after the last edit of each obstacle's shapes
  std::map<std::string, Added> added_;
  std::map<std::string, std::string> attached_;  ///< arm to which planning scenes attached an obstacle
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
  [[nodiscard]] OrderReport report() const;
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
