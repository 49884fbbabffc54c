#include "services/world/referee_message.hpp"

#include "services/messages/convert.hpp"

namespace hecaton::services {

msg::RefereeReport referee_message(const world::RefereeReport& report, double time, bool running) {
  msg::RefereeReport message;
  message.running(running);
  message.time(time);
  message.contacts(report.contacts);
  message.judged(report.judged);
  if (report.judged) message.smallest(messages::to_message(report.smallest));
  for (int kind = 0; kind < world::kContactKinds; ++kind) {
    const world::KindReport& of_kind = report.kinds[static_cast<std::size_t>(kind)];
    msg::KindSummary& summary = message.kinds().emplace_back();
    summary.kind(static_cast<msg::ContactKind>(kind));
    summary.judged(of_kind.judged);
    summary.contacts(of_kind.contacts);
    if (of_kind.judged) summary.smallest(messages::to_message(of_kind.smallest));
  }
  for (const world::Separation& event : report.events) message.events().push_back(messages::to_message(event));
  return message;
}

}  // namespace hecaton::services
