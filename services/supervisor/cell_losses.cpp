// How long each node may be silent because of what the network loses (docs/design/0003-supervision.md, 14).

#include <algorithm>
#include <map>
#include <string_view>

#include "services/supervisor/cell_watch.hpp"

namespace hecaton::services {

// At most as many as a node may hold back without being silent itself. When a host is lost, all of its heartbeats are
// late.
int CellWatch::late_beats(const ExpectedNode& node) const {
  if (node.host == hosts_.own() || !liveness_.last_heard(node.name)) return 0;
  const Time silence = liveness_.silence(node.name);
  const Time period = limits_.heartbeat_period;
  const auto beats = std::min((silence + period / 2) / period - 1, limits_.node.silence / period);
  if (beats <= 0 || silence > limits_.host_lease || hosts_.silent(node.host)) return 0;
  return static_cast<int>(beats);
}

void CellWatch::allow_for_losses() {
  const auto longest_row = [](double lost, Time period) {
    const int samples = Reception::longest_row(lost);
    return samples == 0 ? Time(0) : (samples + 1) * period + period / 2;
  };
  std::map<std::string_view, int> late;  // by host
  int all = 0;
  for (const ExpectedNode& node : nodes_) {
    const int beats = late_beats(node);
    late[node.host] += beats;
    all += beats;
  }
  for (const ExpectedNode& node : nodes_) {
    const bool agent = node.role == msg::NodeKind::NODE_AGENT;
    const int own = late_beats(node);  // says nothing of the way
    const Reception::Late others{late[node.host] - own, all - own};
    // A lease is long enough to go by what is known to be lost.
    const double lost = reception_.lost(node.host, agent ? Reception::Late{} : others);
    liveness_.allow(node.name, longest_row(lost, limits_.heartbeat_period));
    if (!find(node.name)->has_stream) continue;
    const Time period = node.role == msg::NodeKind::NODE_WORLD ? limits_.world_period : limits_.arm_period;
    liveness_.allow(stream_name(node.name), longest_row(lost, period));
  }
}

}  // namespace hecaton::services
