#include "services/supervisor/host_watch.hpp"

#include <algorithm>

namespace hecaton::services {

void HostWatch::judge() {
  const Time now = clock_.now();
  const bool alone = alone_for().value_or(Time(0)) >= limits_.node.silence;  // the others return one after the other
  for (const ExpectedNode& agent : nodes_) {
    if (agent.role != NodeRole::kAgent) continue;
    if (alone && agent.host != own_) meet_anew(agent.host);
    if (silent_for(agent.host, pause())) silences_[agent.host] = now;
    if (!liveness_.last_heard(agent.name)) continue;  // who never came is not lost
    if (silent_for(agent.host, limits_.host_lease)) absences_[agent.host] = {now, now};
    const auto absence = absences_.find(agent.host);
    if (absence != absences_.end() && liveness_.presence(agent.name) != Presence::kAlive) absence->second.away = now;
  }
}

const ExpectedNode* HostWatch::agent_of(const std::string& host) const {
  const auto found = std::find_if(nodes_.begin(), nodes_.end(), [&](const ExpectedNode& node) {
    return node.role == NodeRole::kAgent && node.host == host;
  });
  return found == nodes_.end() ? nullptr : &*found;
}

bool HostWatch::silent(const std::string& host) const {
  return silent_for(host, limits_.heartbeat_period * 9 / 10);  // beats of different nodes are not in phase
}

bool HostWatch::silent_for(const std::string& host, Time duration) const {
  return std::all_of(nodes_.begin(), nodes_.end(), [&](const ExpectedNode& node) {
    return node.host != host || !liveness_.last_heard(node.name) || liveness_.silence(node.name) >= duration;
  });
}

bool HostWatch::most_are_heard() const {
  int hosts = 0;
  int heard = 0;
  for (const ExpectedNode& agent : nodes_) {
    if (agent.role != NodeRole::kAgent) continue;
    ++hosts;
    heard += liveness_.last_heard(agent.name) && !silent_for(agent.host, limits_.node.silence) ? 1 : 0;
  }
  return 2 * heard > hosts;
}

std::optional<Time> HostWatch::alone_for() const {
  int others = 0;
  Time shortest = Time::max();
  for (const ExpectedNode& node : nodes_) {
    if (node.host == own_ || !liveness_.last_heard(node.name)) continue;
    others += node.role == NodeRole::kAgent ? 1 : 0;
    shortest = std::min(shortest, liveness_.silence(node.name));
  }
  return own_.empty() || others < 2 ? std::nullopt : std::optional(shortest);
}

bool HostWatch::explain(const ExpectedNode& node) const {
  const ExpectedNode* agent = agent_of(node.host);
  if (!agent || agent->name == node.name || !liveness_.last_heard(agent->name)) return false;
  if (silent(node.host) || returns(node) || is_ours(node)) return true;
  // Nor do nodes return in the same instant from a silence that was too short for a loss.
  const auto last = silences_.find(node.host);
  return last != silences_.end() && clock_.now() - last->second <= limits_.node.recovery;
}

// Until it has been heard for long enough that the reunion will not take it away again.
bool HostWatch::is_ours(const ExpectedNode& node) const {
  const auto since = met_anew_.find(node.host);
  if (since == met_anew_.end() || clock_.now() - since->second > limits_.host_return) return false;
  const auto steady = liveness_.steady_since(node.name);
  return !steady || *liveness_.last_heard(node.name) - std::max(*steady, since->second) < limits_.sure_return;
}

// A node beats a little before the host falls silent, and a little after it is heard again: so a silence that is
// shorter than a node's may be is the host's, too. One lost beat of the only one that is heard is none.
Time HostWatch::pause() const {
  return std::min(limits_.node.silence, std::max(limits_.node.silence / 2, 2 * limits_.heartbeat_period));
}

// One or the other may be heard for a moment before the network has come to terms with the loss, or return later.
bool HostWatch::returns(const ExpectedNode& node) const {
  const auto found = absences_.find(node.host);
  if (found == absences_.end()) return false;
  const Absence& absence = found->second;
  const auto steady = liveness_.steady_since(node.name);
  const bool is_back =
      steady && *steady > absence.silent && *liveness_.last_heard(node.name) - *steady >= limits_.sure_return;
  return !is_back && clock_.now() - absence.away <= limits_.host_return;
}

}  // namespace hecaton::services
