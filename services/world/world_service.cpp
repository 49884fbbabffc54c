#include "services/world/world_service.hpp"

#include <algorithm>

#include "planner/simulation/arm_bodies.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

/// Longer stalls cost the world time instead of making obstacles jump [s].
constexpr double kLongestStep = 0.1;

std::vector<world::ArmBodies> bodies_of(const planner::Cell& cell) {
  std::vector<world::ArmBodies> bodies;
  for (const planner::PlannedArm& planned : cell.arms) bodies.push_back(planner::arm_bodies(planned.arm));
  return bodies;
}

}  // namespace

WorldService::WorldService(const config::CellFile& file, const ServiceOptions& options, const ShutdownSignal& shutdown)
    : file_(file),
      participant_(make_participant(file, options, world_node(), &mailbox_)),
      modes_(participant_, &mailbox_),
      pulse_(participant_,
             {world_node(), msg::NodeKind::NODE_WORLD, "", options.host.empty() ? file.world_host : options.host},
             pulse_timing(file, options)),
      loop_(nanoseconds(file.cell.timing.world_period), shutdown),
      persistence_(file, options.memory),
      world_(persistence_.scene(file), bodies_of(file.cell)),
      arms_(file, participant_, mailbox_),
      edits_(participant_, mailbox_),
      obstacles_(participant_),
      scans_(file, participant_),
      contacts_(participant_) {}

void WorldService::run() {
  log_info("world started",
           {{"obstacles", world_.obstacles().size()}, {"period_ms", file_.cell.timing.world_period * 1e3}});
  if (!persistence_.lost()) {
    if (const auto contacts = persistence_.go_on(world_)) contacts_.go_on(*contacts);
    for (const world::Obstacle& obstacle : world_.obstacles()) obstacles_.publish_shapes(world_, obstacle.name, term());
  }
  while (loop_.next()) {
    static_cast<void>(mailbox_.take_events());
    modes_.update();
    if (pulse_.due(loop_.now(), loop_.period() / 2)) beat();
    // A world that was cut off knows neither where the arms are nor who sees its obstacles: no time passes in it.
    if (participant_.away()) continue;
    arms_.update(world_);
    edits_.obey({world_, {file_.cell.arms, arms_.q()}, persistence_, obstacles_, term()});
    persistence_.look(loop_.now());
    edits_.reply(persistence_.writer());
    if (!persistence_.lost()) step();  // else planners stand still without a world, and the supervisor says why
  }
  contacts_.publish(world_, false, term());
  contacts_.finish();
  log_info("world ends", {{"contacts", world_.referee().report().contacts}});
}

void WorldService::step() {
  world_.step(std::min(file_.cell.timing.world_period * static_cast<double>(1 + loop_.skipped()), kLongestStep));
  obstacles_.publish_states(world_, term());
  scans_.publish(world_, arms_);
  if (!contacts_.due(world_.referee().report(), loop_.now())) return;
  persistence_.write(world_);  // before anybody hears of a contact
  contacts_.publish(world_, true, term());
}

void WorldService::beat() {
  Vital vital;
  vital.term = term();
  for (std::size_t i = 0; i < arms_.arrivals().size(); ++i) {
    const std::string& name = file_.cell.arms[i].arm.name;
    const auto& measured = arms_.arrivals()[i];
    if (!measured) {
      vital.state = msg::NodeState::NODE_DEGRADED;
      vital.cause = make_cause(msg::CauseKind::CAUSE_ARM_STATE_OLD, name,
                               "the state of arm " + name + " was never heard: the contact monitor does not judge it");
      continue;
    }
    const double age = std::chrono::duration<double>(loop_.now() - *measured).count();
    if (age <= vital.oldest_input_age) continue;
    vital.oldest_input_age = age;
    vital.oldest_input = "ArmState/" + name;
  }
  if (persistence_.failure()) {
    vital.state = msg::NodeState::NODE_DEGRADED;
    vital.cause = not_persisted("edits are ", *persistence_.failure());
  }
  if (persistence_.lost()) {
    vital.state = msg::NodeState::NODE_FAILED;
    vital.cause = make_cause(msg::CauseKind::CAUSE_NODE_FAILED, world_node(), *persistence_.lost());
  }
  pulse_.beat(loop_.now(), vital, loop_.statistics());
}

}  // namespace hecaton::services
