#include "services/world/world_memory.hpp"

#include <cmath>

#include "services/world/referee_message.hpp"

namespace hecaton::services {
namespace {

messages::Converted<world::RefereeReport> report_from(const msg::RefereeReport& message) {
  if (message.kinds().size() != world::kContactKinds) return {{}, "referee: another number of kinds of contacts"};
  world::RefereeReport report;
  for (std::size_t i = 0; i < world::kContactKinds; ++i) {
    const msg::KindSummary& summary = message.kinds()[i];
    world::KindReport& kind = report.kinds[i];
    kind.contacts = summary.contacts();
    kind.judged = summary.judged();
    if (!kind.judged) continue;
    const auto smallest = messages::from_message(summary.smallest(), "referee: smallest");
    if (!smallest) return {{}, smallest.error};
    kind.smallest = *smallest;
  }
  for (const msg::Separation& event : message.events()) {
    const auto contact = messages::from_message(event, "referee: contact");
    if (!contact) return {{}, contact.error};
    report.events.push_back(*contact);
  }
  return {report, {}};
}

}  // namespace

msg::WorldMemory memory_of(const world::BulletWorld& world) {
  msg::WorldMemory memory;
  memory.time(world.time());
  memory.edition(world.snapshot().edition);
  for (const world::Obstacle& obstacle : world.obstacles_now()) {
    memory.obstacles().push_back(messages::to_message(obstacle));
  }
  const world::RefereeMemory account = world.referee().remember();
  memory.referee(referee_message(account.report, world.time(), true));
  for (const world::LastingPair& pair : account.lasting) {
    msg::LastingPair& lasting = memory.lasting().emplace_back();
    lasting.a(pair.a);
    lasting.b(pair.b);
    lasting.which(static_cast<std::uint32_t>(pair.which));
    lasting.touching(pair.touching);
    lasting.fresh(pair.fresh);
    lasting.excused(pair.excused);
    lasting.excused_at(pair.excused_at);
  }
  return memory;
}

messages::Converted<Continuation> continuation(const msg::WorldMemory& memory, const world::Scene& scene) {
  if (!std::isfinite(memory.time())) return {{}, "time must be finite"};
  Continuation next;
  next.scene = scene;
  next.scene.obstacles.clear();
  for (const msg::Obstacle& message : memory.obstacles()) {
    const auto obstacle = messages::from_message(message);
    if (!obstacle) return {{}, obstacle.error};
    next.scene.obstacles.push_back(*obstacle);
  }
  const auto report = report_from(memory.referee());
  if (!report) return {{}, report.error};
  next.account.report = *report;
  for (const msg::LastingPair& pair : memory.lasting()) {
    next.account.lasting.push_back({pair.a(), pair.b(), static_cast<int>(pair.which()), pair.touching(), pair.fresh(),
                                    pair.excused(), pair.excused_at()});
  }
  next.time = memory.time();
  next.stamp_ns = memory.stamp_ns();
  next.edition = memory.edition();
  return {next, {}};
}

}  // namespace hecaton::services
