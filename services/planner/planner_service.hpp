#pragma once
/// The planner of one arm on the bus: states in, one command a period out, and an answer to every goal. On the arm's
/// standby host it does the same without commanding and answering, until it is put in charge.

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/world.h>

#include "planner/arm_controller.hpp"
#include "planner/rollout/rollout_policy.hpp"
#include "planner/route/route_policy.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/planner/arm_view.hpp"
#include "services/planner/company.hpp"
#include "services/planner/duty.hpp"
#include "services/planner/goal_desk.hpp"
#include "services/planner/goal_memory.hpp"
#include "services/planner/goal_resolver.hpp"
#include "services/planner/obstacle_view.hpp"
#include "services/planner/recollection.hpp"
#include "services/planner/rollout_worker.hpp"
#include "services/planner/route_worker.hpp"
#include "services/planner/sensor_view.hpp"
#include "services/planner/unsaid_statuses.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/pulse.hpp"

namespace hecaton::services {

class PlannerService {
 public:
  /// `arm`: index in the cell. Throws std::runtime_error with a sentence when the bus cannot be joined.
  PlannerService(const config::CellFile& file, int arm, const ServiceOptions& options, const ShutdownSignal& shutdown);

  /// Until the process is to end.
  void run();

 private:
  using Clock = std::chrono::steady_clock;
  /// A goal waits this long for the world's and the own arm's first words: as long as the supervisor gives a node to
  /// appear.
  static constexpr std::chrono::seconds kLongestWait{10};

  void listen();
  void listen_to_sensors();

  // change_of_duty.cpp
  /// Takes in who is in charge now; true: this planner is.
  bool hear_mandate();
  void note_duty();
  void hear_the_other(const msg::GoalStatus& status);
  void catch_up();
  [[nodiscard]] std::optional<LastCommand> last_command() const;
  [[nodiscard]] Recollection judge_remembered();
  void resume_goal();
  void remember_goals();

  void look_at_threads();
  void handle_goals();
  void plan();
  [[nodiscard]] planner::OwnNews news_of(const ArmView::Heard& own) const;
  void note_reaction(Clock::duration taken);
  void look_ahead(const planner::TickResult& result, std::span<const planner::ArmObservation> arms,
                  std::span<const world::ObstacleState> obstacles);
  void plan_route(const planner::TickResult& result, std::span<const planner::ArmObservation> arms,
                  std::span<const world::ObstacleState> obstacles);
  void command(const planner::TickResult& result);
  void answer_clients(Progress progress);
  void publish_statuses();
  void beat();
  [[nodiscard]] bool hears_own_arm() const;
  void note_hold(const std::string& reason);
  /// What it must know of obstacles and does not, or too old; empty: nothing.
  [[nodiscard]] std::string blind() const;
  /// Why the arm must not move now; empty when it may.
  [[nodiscard]] std::string hold_reason() const;

  std::string name_;
  std::vector<PlacedNode> planners_;  ///< of this arm
  std::size_t place_;                 ///< ours among them
  std::string node_;
  int self_;
  double state_age_limit_;  ///< [s]
  bool by_sight_;           ///< knows no obstacle but what its sensors see
  bus::Mailbox mailbox_, modes_mailbox_;
  bus::Participant participant_;
  CellModeListener modes_;
  bus::Reader<msg::ArmState> arm_states_;
  bus::Reader<msg::ObstacleShapes> obstacle_shapes_;
  bus::Reader<msg::ObstacleStates> obstacle_states_;
  bus::Reader<msg::RangeScan> scans_;
  bus::Reader<msg::Goal> goals_;
  bus::Reader<msg::GoalStatus> goals_of_others_;
  bus::Writer<msg::ArmCommand> commands_;
  bus::Writer<msg::GoalStatus> statuses_;
  Pulse pulse_;
  PeriodicLoop loop_;

  Duty duty_;
  bool in_charge_;  ///< else it stands by
  UnsaidStatuses unsaid_;
  ArmView arms_;
  ObstacleView obstacles_;
  SensorView sensors_;
  GoalDesk desk_;
  std::unique_ptr<GoalMemory> memory_;                ///< null: it could not be had
  std::optional<GoalMemory::Remembered> remembered_;  ///< until it is known whether it still counts
  std::optional<Clock::time_point> undecided_since_;  ///< that, while we are in charge
  std::deque<msg::GoalStatus> heard_early_;           ///< from the other planner, before it is known whether it counts
  ArmLease caught_up_;                                ///< under which everything that counts was followed
  bool has_news_ = false;                             ///< that are not remembered yet
  planner::ArmController controller_;
  GoalResolver resolver_;
  planner::RolloutPolicy rollout_policy_;
  RolloutWorker rollouts_;
  planner::RoutePolicy route_policy_;
  RouteWorker routes_;
  Company company_;

  Clock::time_point now_{};
  Clock::duration reaction_{};  ///< from hearing to commanding
  std::string hold_reason_ = "has just started";
  std::string no_answers_;         ///< why goals are not resolved, a sentence; empty: they are
  std::string hanging_thread_;     ///< which of the other threads does not answer, a sentence; empty: all do
  double waited_for_input_ = 0.0;  ///< the tick had to brake for want of fresh states this long [s]
  std::uint64_t sequence_ = 0;
  msg::ArmCommand command_;  ///< reused every period
  std::string complaint_;    ///< logged last about unusable messages
};

}  // namespace hecaton::services
