#include "services/supervisor/host_watch.hpp"

#include <algorithm>

namespace hecaton::services {

void HostWatch::judge() {
  judge_own();
  const Time now = clock_.now();
  for (const ExpectedNode& agent : nodes_) {
    if (agent.role != msg::NodeKind::NODE_AGENT) continue;
    if (silent_for(agent.host, pause())) silences_[agent.host] = now;
    if (!liveness_.last_heard(agent.name)) continue;  // who never came is not lost
    if (silent_for(agent.host, limits_.host_lease)) absences_[agent.host] = {now, now, {}};
    const auto absence = absences_.find(agent.host);
    if (absence != absences_.end() && liveness_.presence(agent.name) != Presence::kAlive) absence->second.away = now;
  }
  for (const ExpectedNode& node : nodes_) {
    const auto absence = absences_.find(node.host);
    const auto steady = absence == absences_.end() ? std::nullopt : liveness_.steady_since(node.name);
    const bool is_back =
        steady && *steady > absence->second.silent && *liveness_.last_heard(node.name) - *steady >= limits_.sure_return;
    if (is_back) absence->second.back.insert(node.name);
  }
}

void HostWatch::judge_own() {
  const auto alone = alone_for();
  // Who fell silent with the others returns like them, one after the other. Who was silent before does not.
  if (alone && *alone >= loneliness()) {
    const bool is_ours = unheard();
    for (const ExpectedNode& node : nodes_) {
      const bool with_them =
          liveness_.last_heard(node.name) &&
          (is_ours ? !lost_before(node.host) : liveness_.silence(node.name) <= *alone + limits_.host_lease);
      if (node.host != own_ && with_them) meets_anew_[node.name] = clock_.now();
    }
  }
  const auto is_well = [&](const ExpectedNode& node) {
    return node.role == msg::NodeKind::NODE_AGENT && node.host != own_ &&
           liveness_.presence(node.name) == Presence::kAlive;
  };
  if (alone && *alone > limits_.host_lease) {
    cut_off_ = true;
  } else if (cut_off_) {
    cut_off_ = std::none_of(nodes_.begin(), nodes_.end(), is_well);
  }
  std::erase_if(meets_anew_, [&](const auto& entry) { return has_met(entry.first, entry.second); });
  if (!cut_off_) return;
  for (auto& [node, since] : meets_anew_) since = clock_.now();  // a stray beat is no return
}

const ExpectedNode* HostWatch::agent_of(const std::string& host) const {
  const auto found = std::find_if(nodes_.begin(), nodes_.end(), [&](const ExpectedNode& node) {
    return node.role == msg::NodeKind::NODE_AGENT && node.host == host;
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
    if (agent.role != msg::NodeKind::NODE_AGENT) continue;
    ++hosts;
    heard += liveness_.last_heard(agent.name) && !silent_for(agent.host, limits_.node.silence) ? 1 : 0;
  }
  return 2 * heard > hosts;
}

std::optional<Time> HostWatch::alone_for() const {
  if (!agent_of(own_)) return std::nullopt;
  std::vector<Time> silences;
  for (const ExpectedNode* agent : others()) silences.push_back(liveness_.silence(agent->name));
  if (silences.size() < 2) return std::nullopt;
  const Time shortest = *std::min_element(silences.begin(), silences.end());
  if (unheard()) return shortest;
  const auto with_the_last = [&](Time silence) { return silence <= shortest + limits_.host_lease; };
  return std::count_if(silences.begin(), silences.end(), with_the_last) < 2 ? std::nullopt : std::optional(shortest);
}

void HostWatch::begin_to_lead(std::uint64_t term, std::set<std::string> lost) {
  echo_.begin(term, clock_.now());
  lost_before_ = std::move(lost);
}

bool HostWatch::unanswered() const {
  const auto since = echo_.unanswered_for(clock_.now());
  return since && *since <= limits_.host_return && (!echo_.followed() || *since > limits_.unheard);
}

bool HostWatch::unanswered_for_long() const {
  return unanswered() && *echo_.unanswered_for(clock_.now()) > limits_.unheard;
}

// Who has left us alone meanwhile, or is about to, returns in its own time.
void HostWatch::heard_mode(const std::string& host, const HeardMode& mode) {
  if (host == own_ || !echo_.answers(mode)) return;
  const auto left_us = unanswered_for_long() ? others() : std::vector<const ExpectedNode*>();
  echo_.answered();
  lost_before_.clear();
  for (const ExpectedNode* agent : left_us) meet_anew(agent->host);
}

bool HostWatch::lost_before(const std::string& host) const {
  if (!echo_.followed()) return lost_before_.contains(host);
  const ExpectedNode* agent = agent_of(host);
  const auto since = echo_.unanswered_for(clock_.now());
  return agent && since && liveness_.silence(agent->name) > *since + limits_.host_lease;
}

std::vector<const ExpectedNode*> HostWatch::others() const {
  std::vector<const ExpectedNode*> agents;
  for (const ExpectedNode& node : nodes_) {
    const bool counts = node.role == msg::NodeKind::NODE_AGENT && node.host != own_ && liveness_.last_heard(node.name);
    if (counts && !(unanswered() && lost_before(node.host))) agents.push_back(&node);
  }
  return agents;
}

bool HostWatch::explain(const ExpectedNode& node) const {
  const ExpectedNode* agent = agent_of(node.host);
  if (!agent || agent->name == node.name || !liveness_.last_heard(agent->name)) return false;
  if (silent(node.host) || returns(node) || put_down_to_us(node)) return true;
  // Nor do nodes return in the same instant from a silence that was too short for a loss.
  const auto last = silences_.find(node.host);
  return last != silences_.end() && clock_.now() - last->second <= limits_.node.recovery;
}

void HostWatch::meet_anew(const std::string& host) {
  for (const ExpectedNode& node : nodes_) {
    if (node.host == host && liveness_.last_heard(node.name)) meets_anew_[node.name] = clock_.now();
  }
}

// For longer than a late turn of everybody's; but none may be told as lost before the last of the others falls silent,
// whose beats are not in phase.
Time HostWatch::loneliness() const {
  return std::min(std::max(limits_.node.silence, limits_.node.recovery), limits_.host_lease / 2);
}

// Who is heard for a moment and lost again begins its return anew, once.
bool HostWatch::has_met(const std::string& node, Time since) const {
  const auto last = liveness_.last_heard(node);
  if (!last) return true;  // another process took its place
  if (*last - std::max(*liveness_.steady_since(node), since) >= limits_.sure_return) return true;
  const Time now = clock_.now();
  return now - std::max(*last, since) > limits_.host_return || now - since > 2 * limits_.host_return;
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
  return !absence.back.contains(node.name) && clock_.now() - absence.away <= limits_.host_return;
}

}  // namespace hecaton::services
