#pragma once
/// A planner's part in plans for several arms, over DDS: what it hears of the others' and says of its own
/// (docs/design/0017-composite-plans.md).

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <idl/goal.h>

#include "planner/route/composite_policy.hpp"
#include "services/bus/endpoint.hpp"
#include "services/planner/arm_view.hpp"
#include "services/planner/route_worker.hpp"

namespace hecaton::services {

class Company {
 public:
  /// `arms`, `parameters`: of the whole cell; `self`: index of the own arm; `node`: of the planner.
  Company(bus::Participant& participant, bus::Mailbox* mailbox, std::vector<planner::Arm> arms,
          std::vector<planner::LocalParameters> parameters, int self, std::string node, std::uint64_t seed);

  /// Tells `view` what others propose and how far they are, and `complain` each sentence about what cannot be used.
  void listen(ArmView& view, const std::function<void(const std::string&)>& complain);

  /// After a period of `controller`, which commands its arm.
  void plan(planner::ArmController& controller, const planner::TickResult& result,
            std::span<const planner::ArmObservation> arms, std::span<const world::ObstacleState> states,
            const RouteWorker::Obstacles& obstacles);
  /// Another planner commands the arm; it also says where the arm stands.
  void resign(planner::ArmController& controller);
  [[nodiscard]] bool takes_part() const { return policy_.takes_part(); }
  /// Of the thread that searches plans, as of BackgroundThread.
  [[nodiscard]] TurnWatch::Clock::duration silence(TurnWatch::Clock::time_point now) { return routes_.silence(now); }

 private:
  void publish();
  void publish_proposal();

  std::vector<std::string> names_;  ///< of the cell's arms
  int self_;
  std::string node_;
  bus::Reader<msg::CompositePlan> proposals_;
  bus::Reader<msg::CompositeProgress> progress_of_others_;
  bus::Writer<msg::CompositePlan> proposal_;
  bus::Writer<msg::CompositeProgress> progress_;
  planner::CompositePolicy policy_;
  RouteWorker routes_;
  std::shared_ptr<const planner::CompositePlan> published_plan_;
  planner::CompositeProgress published_progress_;
  bool has_said_ = false;  ///< both, since it commands the arm
};

}  // namespace hecaton::services
