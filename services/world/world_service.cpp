#include "services/world/world_service.hpp"

#include <algorithm>

#include "planner/simulation/arm_in_world.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

/// In a longer stall the world loses time, so that obstacles do not jump [s].
constexpr double kLongestStep = 0.1;

std::vector<world::ArmBodies> bodies_of(const planner::Cell& cell) {
  std::vector<world::ArmBodies> bodies;
  for (const planner::PlannedArm& planned : cell.arms) bodies.push_back(planner::live_arm_bodies(planned.arm));
  return bodies;
}

}  // namespace

WorldService::WorldService(const config::CellFile& file, const ServiceOptions& options, const ShutdownSignal& shutdown)
    : file_(file),
      participant_(make_participant(file, options, Role::kWorld, world_node(), &mailbox_)),
      modes_(participant_, &mailbox_),
      heartbeat_(participant_,
                 {world_node(), msg::NodeKind::NODE_WORLD, "", options.host.empty() ? file.world_host : options.host},
                 heartbeat_timing(file, options)),
      loop_(nanoseconds(file.cell.timing.world_period), shutdown),
      persistence_(file, options.checkpoint),
      world_(persistence_.scene(file), bodies_of(file.cell)),
      arms_(file, participant_, mailbox_),
      edits_(participant_, mailbox_),
      grasps_(participant_, mailbox_),
      obstacles_(participant_),
      scans_(file, participant_),
      contacts_(participant_) {}

void WorldService::run() {
  log_info("world started",
           {{"obstacles", world_.obstacles().size()}, {"period_ms", file_.cell.timing.world_period * 1e3}});
  if (!persistence_.unusable()) {
    if (const auto contacts = persistence_.restore(world_)) contacts_.restore(*contacts);
    for (const world::Obstacle& obstacle : world_.obstacles()) obstacles_.publish_shapes(world_, obstacle.name, term());
  }
  while (loop_.next()) {
    static_cast<void>(mailbox_.take_events());
    modes_.update();
    if (heartbeat_.due(loop_.now(), loop_.period() / 2)) publish_heartbeat();
    // The world does not know where the arms are and no planner gets its obstacles, so no time passes in it.
    if (participant_.recovering()) continue;
    arms_.update(world_, loop_.now());
    const Edited edited{world_, {file_.cell.arms, arms_.q()}, persistence_, obstacles_, term()};
    edits_.apply(edited);
    grasps_.apply(edited);
    persistence_.update(loop_.now());
    edits_.reply(persistence_.writer());
    if (!persistence_.unusable()) step();  // else the arms hold without a world
  }
  contacts_.publish(world_, false, term());
  contacts_.finish();
  log_info("world shuts down", {{"contacts", world_.contact_monitor().report().contacts}});
}

void WorldService::step() {
  world_.step(std::min(file_.cell.timing.world_period * static_cast<double>(1 + loop_.skipped()), kLongestStep));
  obstacles_.publish_states(world_, term());
  scans_.publish(world_, arms_);
  if (!contacts_.due(world_.contact_monitor().report(), loop_.now())) return;
  persistence_.write(world_);  // before a contact is published
  contacts_.publish(world_, true, term());
}

void WorldService::publish_heartbeat() {
  HealthReport report;
  report.term = term();
  for (std::size_t i = 0; i < arms_.arrivals().size(); ++i) {
    const std::string& name = file_.cell.arms[i].arm.name;
    const auto& measured = arms_.arrivals()[i];
    if (!measured) {
      report.state = msg::NodeState::NODE_DEGRADED;
      report.cause =
          make_cause(msg::CauseKind::CAUSE_ARM_STATE_OLD, name,
                     "no state of arm " + name + " received yet; the contact monitor does not check this arm");
      continue;
    }
    const double age = std::chrono::duration<double>(loop_.now() - *measured).count();
    if (age <= report.oldest_input_age) continue;
    report.oldest_input_age = age;
    report.oldest_input = "ArmState/" + name;
  }
  if (persistence_.failure()) {
    report.state = msg::NodeState::NODE_DEGRADED;
    report.cause = not_persisted("edits are ", *persistence_.failure());
  }
  if (persistence_.unusable()) {
    report.state = msg::NodeState::NODE_FAILED;
    report.cause = make_cause(msg::CauseKind::CAUSE_NODE_FAILED, world_node(), *persistence_.unusable());
  }
  heartbeat_.publish(loop_.now(), report, loop_.statistics());
}

}  // namespace hecaton::services
