/// A simulated crowd for a supervisor: one process that publishes the states of all planners, drivers, agents and the
/// world of a cell, at their rates. Started by supervision_cost.py and ros2_cost.py.

#include <cmath>
#include <deque>
#include <vector>

#include <idl/arm.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/process_info.hpp"
#include "services/runtime/run_service.hpp"

namespace hecaton::services {
namespace {

class Crowd {
 public:
  Crowd(const config::CellFile& file, const ServiceOptions& options, const ShutdownSignal& shutdown)
      : participant_(make_participant(file, options, Role::kSupervisor, "crowd")),
        modes_(participant_),
        loop_(std::chrono::nanoseconds(std::llround(file.cell.timing.driver_period * 1e9)), shutdown) {
    const HeartbeatTiming timing = heartbeat_timing(file, options);
    for (const config::Host& host : file.hosts) {
      heartbeats_.emplace_back(participant_,
                               NodeIdentity{agent_node(host.name), msg::NodeKind::NODE_AGENT, {}, host.name}, timing);
    }
    heartbeats_.emplace_back(participant_, NodeIdentity{world_node(), msg::NodeKind::NODE_WORLD, {}, file.world_host},
                             timing);
    for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
      const std::string& arm = file.cell.arms[i].arm.name;
      const std::string& host = file.arm_hosts[i].host;
      heartbeats_.emplace_back(participant_, NodeIdentity{planner_node(arm), msg::NodeKind::NODE_PLANNER, arm, host},
                               timing);
      heartbeats_.emplace_back(participant_, NodeIdentity{driver_node(arm), msg::NodeKind::NODE_DRIVER, arm, host},
                               timing);
      states_.emplace_back(participant_, bus::WriterOptions{.key = arm});
      msg::ArmState& state = told_.emplace_back();
      state.arm(arm);
      state.mode(msg::ArmMode::ARM_RUNNING);
      state.q(messages::to_message(file.cell.arms[i].start));
      state.qd(messages::to_message(planner::JointVector(planner::JointVector::Zero(file.cell.arms[i].start.size()))));
    }
  }

  void run() {
    HealthReport report;
    std::vector<double> starts;
    for (const msg::ArmState& state : told_) starts.push_back(state.q()[0]);
    while (loop_.next()) {
      modes_.update();
      const double moved = 0.1 * std::sin(1e-9 * static_cast<double>(stamp_now()));
      for (std::size_t i = 0; i < told_.size(); ++i) told_[i].q()[0] = starts[i] + moved;
      for (std::size_t i = 0; i < told_.size(); ++i) {
        told_[i].sequence_number(told_[i].sequence_number() + 1);
        told_[i].stamp_ns(stamp_now());
        static_cast<void>(states_[i].write(told_[i]));
      }
      for (HeartbeatPublisher& pulse : heartbeats_) {
        if (pulse.due(loop_.now(), loop_.period() / 2)) pulse.publish(loop_.now(), report, loop_.statistics());
      }
    }
  }

 private:
  bus::Participant participant_;
  std::deque<bus::Writer<msg::ArmState>> states_;  ///< of each arm, in its partition
  CellModeListener modes_;
  PeriodicLoop loop_;
  std::deque<HeartbeatPublisher> heartbeats_;
  std::deque<msg::ArmState> told_;
};

}  // namespace
}  // namespace hecaton::services

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(argc, argv, "Tells what all nodes of a cell tell", services::Subject::kCell,
                               [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
                                 const config::CellFile file = config::load_cell_file(options.cell);
                                 const services::LogScope log("crowd", options);
                                 services::Crowd(file, options, shutdown).run();
                               });
}
