// A serialised message of a ROS 2 node. The first byte chooses its type.

#include <cmath>

#include "services/bus/wire_rules.hpp"
#include "services/config/cell_file.hpp"
#include "services/ros2/node_graph.hpp"
#include "services/ros2/planning_scene.hpp"
#include "services/ros2/trajectory.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace hecaton;
using namespace hecaton::ros2;

const planner::Arm& north() {
  static const config::CellFile kCell = config::load_cell_file(fuzz::source("deploy/cells/three_puma.yaml"));
  return kCell.cell.arms[0].arm;
}

SceneFrames frames_at_home() {
  planner::Kinematics kinematics;
  planner::forward_kinematics(*north().model, north().X_WB, north().home(), kinematics);
  SceneFrames frames;
  add_frames(frames, north(), kinematics, "north_");
  add_frames(frames, north(), kinematics, "");
  frames.emplace("world", SceneFrame{});
  return frames;
}

/// It goes to the log, to another node, or onto a page.
void require_readable(const std::string& text) {
  fuzz::require_sentence(text);
  fuzz::require(!bus::unprintable(text), "a refusal is printable");
}

void use(const PlanningScene& scene) {
  static const SceneFrames kFrames = frames_at_home();
  const SceneEdits edits = edits_of(scene, kFrames);
  for (const SceneRefusal& refusal : edits.refusals) require_readable(refusal.reason);
  for (const SceneEdit& edit : edits.edits) {
    const bool of_all = edit.kind == SceneEdit::Kind::kRemoveAll || edit.kind == SceneEdit::Kind::kDetachAll;
    fuzz::require(edit.obstacle.name.empty() == of_all && edit.obstacle.X_WO.matrix().allFinite(),
                  "an edit has the name of an obstacle, unless it is one of all, and a finite pose");
  }
}

void use(const SendGoalRequest& request) {
  const planner::JointVector q = north().home();
  const auto checked = check_trajectory(request.goal, north(), q, 0.0);
  if (const auto* refusal = std::get_if<TrajectoryRefusal>(&checked)) return require_readable(refusal->text);
  const planner::TimedTrajectory& trajectory = std::get<TrajectoryOrder>(checked).trajectory;
  fuzz::require(!planner::objection(trajectory, north().limits, north().model->joint_names),
                "the planner can follow a trajectory that the service accepts");
  TrajectoryFollower follower(std::get<TrajectoryOrder>(checked));
  for (int i = 0; i < 20; ++i) {
    if (follower.update({q, 0.05, TrajectoryFollower::GoalReport::kUnderWay, 0.05 * i, 1.0})) return;
  }
}

void use(const JointState& state) {
  static_cast<void>(joint_numbers(state.name, north()));
}

template <class Message>
void use(const Message&) {}

template <class Message>
void check(fuzz::View bytes) {
  const auto message = decoded<Message>(bytes);
  if (!message) return;
  const Bytes once = encoded(*message);
  const auto again = decoded<Message>(once);
  fuzz::require(again && encoded(*again) == once, "a decoded message survives another way over the wire");
  use(*message);
}

void check_announcement(fuzz::View bytes) {
  const Bytes copy(bytes.begin(), bytes.end());
  for (const auto distribution : {config::Ros2Distribution::kHumble, config::Ros2Distribution::kJazzy}) {
    static_cast<void>(is_of_other(distribution, copy));
  }
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(ros2)(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  using Check = void (*)(fuzz::View);
  static constexpr std::array<Check, 8> kChecks{
      check<PlanningScene>,  check<SendGoalRequest>,   check<PoseStamped>,      check<JointState>,
      check<TriggerRequest>, check<CancelGoalRequest>, check<GetResultRequest>, check_announcement};
  kChecks[input.byte() % kChecks.size()](input.rest());
  return 0;
}
