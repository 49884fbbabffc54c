#pragma once
/// Diffs of MoveIt's planning scene (moveit_msgs/msg/PlanningScene) as edits of a cell's obstacles. Pure.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/model/kinematics.hpp"
#include "services/ros2_messages/ros2_types.hpp"
#include "world/model/scene.hpp"

namespace hecaton::ros2 {

/// A frame to which the poses of a planning scene may refer.
struct SceneFrame {
  world::Pose X_WF = world::Pose::Identity();
  /// The arm that carries what is attached to this link, because the link is rigidly fixed to its tool; else empty.
  std::optional<std::string> carrier = {};
  world::Pose X_WT = world::Pose::Identity();  ///< tool of the carrier
};
using SceneFrames = std::map<std::string, SceneFrame, std::less<>>;

/// Adds the links of an arm at its measured position. `prefix`: before the name of each link, "north_" or nothing.
void add_frames(SceneFrames& frames, const planner::Arm& arm, const planner::Kinematics& kinematics,
                const std::string& prefix);

/// One edit of the cell's obstacles.
struct SceneEdit {
  enum class Kind {
    kAdd,     ///< `obstacle`; replaces an obstacle of its name
    kAppend,  ///< the shapes of `obstacle`, at their poses in W, to the obstacle of its name; adds it if there is none
    kMove,    ///< the obstacle of that name to X_WO
    kRemove,  ///< the obstacle of that name
    kAttach,  ///< the obstacle of that name to `arm`
    kDetach,  ///< the obstacle of that name from `arm`; no arm: from any
    kRemoveAll,  ///< what planning scenes of `source` added and no arm carries; no source: of all topics
    kDetachAll   ///< what planning scenes attached to `arm`; no arm: to any
  };
  Kind kind{};
  world::Obstacle obstacle;  ///< its shapes only for kAdd and kAppend; no name for kRemoveAll and kDetachAll
  std::string arm = {};
  std::string source = {};  ///< the arm on whose own topic the scene came; empty: on the topic of the cell
};

/// Something in a scene that is not carried out.
struct SceneRefusal {
  std::string object;  ///< its id; empty: the scene itself
  std::string reason;  ///< a sentence: what, its value, what is allowed
};

/// In the order of the message.
struct SceneEdits {
  std::vector<SceneEdit> edits;
  std::vector<SceneRefusal> refusals;
};

/// Attached objects first, then those of the world. Each object is an edit or a refusal. A whole scene (`is_diff`
/// false), an octomap and planes are refused. Parts of a scene that do not concern obstacles are ignored: colours,
/// paddings, the matrix of allowed collisions, joint positions.
[[nodiscard]] SceneEdits edits_of(const PlanningScene& scene, const SceneFrames& frames);
/// The edits of a scene that came on the own topic of `arm`. They remove and detach what belongs to this topic and arm.
[[nodiscard]] SceneEdits of_topic(SceneEdits scene, const std::string& arm);

}  // namespace hecaton::ros2
