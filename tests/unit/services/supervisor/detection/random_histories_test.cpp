// Random histories of links and processes, judged by the supervisors of two hosts and by a reference that knows the
// true state. No false fault is reported, and every fault is reported within its limit.

#include <algorithm>
#include <array>
#include <cstdio>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "services/supervisor/detection/fault_detector.hpp"

namespace hecaton::services::testing {
namespace {

using namespace std::chrono_literals;

enum class Kind { kHang, kKill, kMute, kDeaf, kCut, kLink, kPause };
constexpr std::array kKindNames{"hang", "kill", "mute", "deaf", "cut", "link", "pause"};

struct Injection {
  Kind kind{};
  int host = 0;   // of a link: from
  int other = 0;  // of a link: to
  int process = 0;
  Time begin{0};
  Time end{0};
  [[nodiscard]] bool active(Time at) const { return at >= begin && at < end; }
};

struct Setting {
  int hosts = 3;
  int faults = 1;
  double loss = 0.0;
  /// A process that has not heard another for 1.6 s ignores it for 2.5 s (services/bus/peer_quarantine.hpp).
  bool drops_peers = false;
};

constexpr int kProcesses = 3;  // of each host: agent, driver, planner
constexpr Time kStep = 1ms;
constexpr Time kTurn = 5ms;

class History {
 public:
  History(const Setting& setting, unsigned seed) : setting_(setting), random_(seed) {
    const Time shortest = setting.drops_peers ? 300ms : 800ms;
    const Time longest = setting.drops_peers ? 3000ms : 1500ms;
    std::set<int> processes;
    while (static_cast<int>(injections.size()) < setting.faults) {
      Injection one;
      one.kind = static_cast<Kind>(below(7));
      one.host = below(setting.hosts);
      one.other = (one.host + 1 + below(setting.hosts - 1)) % setting.hosts;
      one.process = one.host * kProcesses + below(kProcesses);
      one.begin = 1000ms + below(1500) * 1ms;
      one.end = one.begin + shortest + below(static_cast<int>((longest - shortest) / 1ms)) * 1ms;
      if (processes.insert(one.process).second) injections.push_back(one);
    }
    std::vector<ExpectedNode> nodes;
    std::vector<std::string> arms;
    for (int host = 0; host < setting.hosts; ++host) {
      const std::string name = host_name(host);
      arms.push_back("arm" + name);
      nodes.push_back({"agent/" + name, msg::NodeKind::NODE_AGENT, "", name});
      nodes.push_back({"driver/arm" + name, msg::NodeKind::NODE_DRIVER, arms.back(), name});
      nodes.push_back({"planner/arm" + name, msg::NodeKind::NODE_PLANNER, arms.back(), name});
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      processes_.push_back({nodes[i].name, static_cast<std::int64_t>(i) + 1, 0, below(10000) * 1us});
    }
    for (int judge = 0; judge < 2; ++judge) {
      detectors.push_back(std::make_unique<FaultDetector>(nodes, arms, DetectionLimits{}, 0ms, host_name(judge)));
    }
    inbox_.resize(2);
    row_.resize(static_cast<std::size_t>(setting.hosts));
  }

  void run() {
    const Time end = setting_.drops_peers ? 14s : 5s;
    for (; now < end; now += kStep) {
      change_processes();
      for (std::size_t i = 0; i < processes_.size(); ++i) send(static_cast<int>(i));
      deliver();
      if (now % kTurn == Time(0)) {
        note_truth();
        for (int judge = 0; judge < 2; ++judge) turn(judge);
      }
    }
  }

  [[nodiscard]] static std::string host_name(int host) { return "h" + std::to_string(host); }

  std::vector<Injection> injections;
  std::vector<std::unique_ptr<FaultDetector>> detectors;
  struct Told {
    int judge = 0;
    msg::CauseKind kind{};
    std::string subject;
    Time at{0};
    bool right = false;
  };
  std::vector<Told> told;
  Time now{0};

 private:
  struct Process {
    std::string name;
    std::int64_t pid = 0;
    std::uint64_t number = 0;
    Time due{0};
    bool runs = true;
  };
  struct Packet {
    Time at{0};
    int process = 0;
    std::int64_t pid = 0;
    std::uint64_t number = 0;
    std::vector<HostAge> row;
  };
  struct Peer {
    Time heard{0};
    Time shunned_until{0};
  };

  int below(int limit) { return std::uniform_int_distribution<>(0, limit - 1)(random_); }

  [[nodiscard]] bool any(Kind kind, int host, Time at) const {
    return std::any_of(injections.begin(), injections.end(),
                       [&](const Injection& one) { return one.kind == kind && one.host == host && one.active(at); });
  }
  [[nodiscard]] bool paused(int host) const { return any(Kind::kPause, host, now); }
  /// What `from` sends reaches `to`.
  [[nodiscard]] bool up(int from, int to) const {
    if (from == to) return !paused(from);
    const bool cut = std::any_of(injections.begin(), injections.end(), [&](const Injection& one) {
      return one.kind == Kind::kLink && one.host == from && one.other == to && one.active(now);
    });
    return !cut && !any(Kind::kMute, from, now) && !any(Kind::kCut, from, now) && !paused(from) &&
           !any(Kind::kDeaf, to, now) && !any(Kind::kCut, to, now) && !paused(to);
  }
  static int host_of(int process) { return process / kProcesses; }

  void change_processes() {
    for (const Injection& one : injections) {
      Process& process = processes_[static_cast<std::size_t>(one.process)];
      if (one.kind == Kind::kHang && now == one.begin) process.runs = false;
      if (one.kind == Kind::kKill && now == one.begin)
        process.runs = false, events_.push_back({now + 2ms, one.process, process.pid, true});
      if (one.kind != Kind::kHang && one.kind != Kind::kKill) continue;
      if (now != one.end) continue;
      process.runs = true;
      if (one.kind == Kind::kHang) continue;
      process.pid += 1000;
      process.number = 0;
      events_.push_back({now, one.process, process.pid, false});
    }
  }

  void send(int index) {
    Process& process = processes_[static_cast<std::size_t>(index)];
    if (now < process.due) return;
    process.due += 10ms;
    const int host = host_of(index);
    if (!process.runs || paused(host) || away(index)) return;
    Packet packet{now, index, process.pid, ++process.number, {}};
    const bool agent = index % kProcesses == 0;
    if (agent) {
      for (int other = 0; other < setting_.hosts; ++other) {
        const auto& newest = row_[static_cast<std::size_t>(host)];
        const auto heard = newest.find(other);
        if (other != host && heard != newest.end()) packet.row.push_back({host_name(other), now - heard->second});
      }
    }
    for (int to = 0; to < setting_.hosts; ++to) {
      const auto is_lost = [&] { return to != host && std::bernoulli_distribution(setting_.loss)(random_); };
      if (!up(host, to)) continue;
      packet.at = now + (to == host ? Time(200us) : Time(500us + below(2500) * 1us));
      // To an agent, and to the supervisor of the host.
      if (agent && to != host && !is_lost()) wire_.emplace(packet.at, std::pair(to * kProcesses, packet));
      if (to < 2 && !is_lost()) wire_.emplace(packet.at, std::pair(-1 - to, packet));
    }
  }

  /// Of a receiver (an agent, or −1 − judge) and a sender.
  [[nodiscard]] bool hears(int receiver, int sender) {
    const int host = receiver < 0 ? -1 - receiver : host_of(receiver);
    if (!setting_.drops_peers || host == host_of(sender)) return true;
    Peer& peer = peers_[{receiver, sender}];
    if (now < peer.shunned_until) return false;
    if (peer.heard > Time(0) && now - peer.heard > 1600ms && peer.shunned_until < peer.heard) {
      peer.shunned_until = now + 2500ms;
      return false;
    }
    peer.heard = now;
    return true;
  }
  /// A process that stood still for more than a second recovers before it uses the network again.
  [[nodiscard]] bool away(int process) const {
    return setting_.drops_peers && std::any_of(injections.begin(), injections.end(), [&](const Injection& one) {
             const bool hit = one.kind == Kind::kPause ? one.host == host_of(process)
                                                       : one.kind == Kind::kHang && one.process == process;
             return hit && one.end - one.begin > 1s && now >= one.end && now < one.end + 2500ms;
           });
  }

  void look_for_silent_peers() {
    for (auto& [pair, peer] : peers_) {
      const bool silent = now - peer.heard > 1600ms && now >= peer.shunned_until && peer.heard > peer.shunned_until;
      if (silent) peer.shunned_until = now + 2500ms;
    }
  }

  void deliver() {
    if (setting_.drops_peers && now % 50ms == Time(0)) look_for_silent_peers();
    while (!wire_.empty() && wire_.begin()->first <= now) {
      auto [receiver, packet] = std::move(wire_.begin()->second);
      wire_.erase(wire_.begin());
      if (!hears(receiver, packet.process)) continue;
      if (receiver < 0) {
        if (!judge_away(-1 - receiver)) inbox_[static_cast<std::size_t>(-1 - receiver)].push_back(std::move(packet));
      } else if (!away(receiver) && processes_[static_cast<std::size_t>(receiver)].runs) {
        row_[static_cast<std::size_t>(host_of(receiver))][host_of(packet.process)] = packet.at;
      }
    }
    // An agent's clock does not count the time in which its host stood still.
    for (int host = 0; host < setting_.hosts; ++host) {
      const bool stands = paused(host) || !processes_[static_cast<std::size_t>(host * kProcesses)].runs;
      if (!stands) continue;
      for (auto& [other, newest] : row_[static_cast<std::size_t>(host)]) newest += kStep;
    }
  }

  [[nodiscard]] bool judge_away(int judge) const {
    return std::any_of(injections.begin(), injections.end(), [&](const Injection& one) {
      if (one.kind != Kind::kPause || one.host != judge) return false;
      const bool is_long = setting_.drops_peers && one.end - one.begin > 1s;
      return now >= one.begin && now < one.end + (is_long ? 2500ms : 0ms);
    });
  }

  void turn(int judge) {
    if (judge_away(judge)) return;
    FaultDetector& detector = *detectors[static_cast<std::size_t>(judge)];
    detector.advance(now);
    // Events are reliable: they wait until the link is back.
    for (auto& event : events_) {
      if (event.at > now || event.heard[static_cast<std::size_t>(judge)] || !up(host_of(event.process), judge))
        continue;
      event.heard[static_cast<std::size_t>(judge)] = true;
      const std::string& name = processes_[static_cast<std::size_t>(event.process)].name;
      if (event.exited) {
        detector.process_exited(name, {event.pid, -1, 9, false});
      } else {
        detector.process_started(name, event.pid);
      }
    }
    for (Packet& packet : inbox_[static_cast<std::size_t>(judge)]) {
      detector.heard(processes_[static_cast<std::size_t>(packet.process)].name, {packet.pid, packet.at, packet.number});
      const std::string& name = processes_[static_cast<std::size_t>(packet.process)].name;
      if (packet.process % kProcesses == 1) detector.stream_heard(name, packet.at, packet.number);
      if (packet.process % kProcesses == 0)
        detector.row_heard(host_name(host_of(packet.process)), packet.row, packet.at);
    }
    inbox_[static_cast<std::size_t>(judge)].clear();
    detector.judge(now);
    for (const FaultRecord& record : detector.faults().take_changes()) {
      if (!record.cleared_at) told.push_back({judge, record.kind, record.subject, now, is_right(judge, record)});
    }
  }

  struct Truth {
    Time at{0};
    std::vector<std::vector<bool>> up;
    std::vector<bool> agents;  // that run
  };
  void note_truth() {
    Truth truth{now, {}, {}};
    for (int from = 0; from < setting_.hosts; ++from) {
      truth.agents.push_back(processes_[static_cast<std::size_t>(from * kProcesses)].runs);
      truth.up.emplace_back();
      for (int to = 0; to < setting_.hosts; ++to) truth.up.back().push_back(up(from, to));
    }
    truths_.push_back(std::move(truth));
    const Time kept = setting_.drops_peers ? Time(10s) : Time(400ms);
    while (truths_.front().at < now - kept) truths_.pop_front();
  }

  // The reference: what was true at some instant within the time that a judgement may take.
  [[nodiscard]] bool is_right(int judge, const FaultRecord& record) const {
    const auto was = [&](Time within, const std::function<bool(const Truth&)>& holds) {
      return std::any_of(truths_.begin(), truths_.end(),
                         [&](const Truth& truth) { return truth.at >= now - within && holds(truth); });
    };
    const auto all_others = [&](int host, const std::function<bool(std::size_t)>& holds) {
      for (int other = 0; other < setting_.hosts; ++other) {
        if (other != host && !holds(static_cast<std::size_t>(other))) return false;
      }
      return true;
    };
    const auto host = static_cast<std::size_t>(record.subject[1] - '0');
    const auto own = static_cast<std::size_t>(judge);
    // Processes drop a host that was away, and match it again, one after the other.
    const Time dropped = setting_.drops_peers ? Time(9s) : Time(400ms);
    switch (record.kind) {
      case msg::CauseKind::CAUSE_PROCESS_DIED:
      case msg::CauseKind::CAUSE_NODE_SILENT:
        return std::any_of(injections.begin(), injections.end(), [&](const Injection& one) {
          const bool hit = processes_[static_cast<std::size_t>(one.process)].name == record.subject;
          const Time after = setting_.drops_peers ? Time(9s) : Time(400ms);
          return hit && (one.kind == Kind::kHang || one.kind == Kind::kKill) && now >= one.begin &&
                 now < one.end + after;
        });
      case msg::CauseKind::CAUSE_HOST_LOST:
        // A host whose agent hangs is heard by no other agent: with its link to the supervisor it looks lost.
        return was(dropped, [&](const Truth& truth) {
          const bool agent = !truth.agents[host] && !truth.up[host][own];
          return agent || all_others(static_cast<int>(host), [&](std::size_t other) {
                   return !truth.up[host][other] || (other != own && !truth.up[other][own]);
                 });
        });
      case msg::CauseKind::CAUSE_HOST_ISOLATED:
        return was(dropped, [&](const Truth& truth) {
          const bool deaf =
              all_others(static_cast<int>(host), [&](std::size_t other) { return !truth.up[other][host]; });
          const bool mute = host == own && all_others(judge, [&](std::size_t other) {
                              return !truth.up[own][other] || !truth.up[other][own];
                            });
          return deaf || mute;
        });
      case msg::CauseKind::CAUSE_LINK_LOST: {
        const auto other = static_cast<std::size_t>(record.subject.back() - '0');
        return was(400ms, [&](const Truth& truth) { return !truth.up[host][other] || !truth.up[other][host]; });
      }
      default:
        return false;
    }
  }

  Setting setting_;
  std::mt19937 random_;
  std::vector<Process> processes_;
  std::multimap<Time, std::pair<int, Packet>> wire_;
  std::vector<std::vector<Packet>> inbox_;
  std::vector<std::map<int, Time>> row_;  // by host: newest packet from each other
  std::map<std::pair<int, int>, Peer> peers_;
  struct Event {
    Time at{0};
    int process = 0;
    std::int64_t pid = 0;
    bool exited = false;
    std::array<bool, 2> heard{};
  };
  std::vector<Event> events_;
  std::deque<Truth> truths_;
};

std::string text(const History& history, const Setting& setting, unsigned seed) {
  std::string text = std::to_string(setting.hosts) + " hosts, loss " + std::to_string(setting.loss) + ", seed " +
                     std::to_string(seed) + ":";
  for (const Injection& one : history.injections) {
    text += std::string("\n  ") + kKindNames[static_cast<std::size_t>(one.kind)] + " h" + std::to_string(one.host) +
            " (to h" + std::to_string(one.other) + ", process " + std::to_string(one.process % kProcesses) + ") " +
            std::to_string(one.begin / 1ms) + " to " + std::to_string(one.end / 1ms) + " ms";
  }
  for (const auto& told : history.told) {
    text += "\n  judge " + std::to_string(told.judge) + " at " + std::to_string(told.at / 1ms) +
            " ms: " + std::string(cause_name(told.kind)) + " " + told.subject + (told.right ? "" : "  WRONG");
  }
  return text;
}

/// What the judge must report about the only fault of a history, and within which time; without a kind: nothing.
struct Due {
  std::vector<msg::CauseKind> kinds;
  std::string subject;
  Time within{0};
};
Due due_of(const Injection& one, const Setting& setting, int judge) {
  const bool lossy = setting.loss > 0.0;
  const bool two = setting.hosts == 2;
  const bool own = one.host == judge;
  const std::string host = History::host_name(one.host);
  const auto link = [&](int other) {
    const std::string name = History::host_name(other);
    return std::min(host, name) + "<->" + std::max(host, name);
  };
  const Time process = lossy ? 150ms : one.process % kProcesses == 0 ? 130ms : 50ms;
  const std::string node =
      std::array{"agent/", "driver/arm", "planner/arm"}[static_cast<std::size_t>(one.process % kProcesses)] + host;
  switch (one.kind) {
    case Kind::kHang:
      return {{msg::CauseKind::CAUSE_NODE_SILENT}, node, process};
    case Kind::kKill:
      return {{msg::CauseKind::CAUSE_PROCESS_DIED}, node, 10ms};
    case Kind::kPause:
      if (own) return {};
      [[fallthrough]];
    case Kind::kMute:
    case Kind::kCut:
      if (two) return {{msg::CauseKind::CAUSE_LINK_LOST}, link(1 - one.host), lossy ? 300ms : 200ms};
      return {
          {own ? msg::CauseKind::CAUSE_HOST_ISOLATED : msg::CauseKind::CAUSE_HOST_LOST}, host, lossy ? 200ms : 150ms};
    case Kind::kDeaf:
      if (two) return {{msg::CauseKind::CAUSE_LINK_LOST}, link(1 - one.host), lossy ? 300ms : 200ms};
      return {{msg::CauseKind::CAUSE_HOST_ISOLATED}, host, lossy ? 250ms : 180ms};
    case Kind::kLink:
      return {{msg::CauseKind::CAUSE_LINK_LOST}, link(one.other), lossy ? 300ms : 220ms};
  }
  return {};
}

struct Counts {
  int wrong = 0;
  int onsets = 0;  // of losses, with a fault of a process
  int missed = 0;
  int histories = 0;
  std::map<std::string, std::vector<double>> latency;  // [ms], by class
};

void judge_history(const Setting& setting, unsigned seed, Counts& counts) {
  History history(setting, seed);
  history.run();
  ++counts.histories;
  bool shown = false;
  const auto show = [&](const char* what) {
    if (!std::exchange(shown, true)) ADD_FAILURE() << what << " in " << text(history, setting, seed);
  };
  for (const auto& told : history.told) {
    if (told.right) continue;
    // Two heartbeats of a process that are lost before any other is missed look like a hang.
    const bool onset = setting.loss > 0.0 && told.at < 500ms && told.kind == msg::CauseKind::CAUSE_NODE_SILENT;
    ++(onset ? counts.onsets : counts.wrong);
    if (onset) continue;
    show("false fault");
  }
  for (int judge = 0; judge < 2; ++judge) {
    if (!history.detectors[static_cast<std::size_t>(judge)]->faults().open().empty()) show("a fault without an end");
    if (setting.faults > 1) continue;
    const Injection& one = history.injections.front();
    const Due due = due_of(one, setting, judge);
    if (due.kinds.empty() || one.end - one.begin < 800ms) continue;
    const auto found = std::find_if(history.told.begin(), history.told.end(), [&](const auto& told) {
      return told.judge == judge && told.subject == due.subject && told.kind == due.kinds.front();
    });
    if (found == history.told.end() || found->at - one.begin > due.within) {
      ++counts.missed;
      show("a fault that was not told in time");
      continue;
    }
    const bool agent = one.process % kProcesses == 0;
    const std::string name = kKindNames[static_cast<std::size_t>(one.kind)];
    counts.latency[name + (one.kind == Kind::kHang && agent ? " of an agent" : "")].push_back(
        std::chrono::duration<double, std::milli>(found->at - one.begin).count());
  }
}

void print(const Counts& counts, const char* title) {
  std::printf("%s: %d histories, %d wrong, %d missed, %d onsets of loss with a fault\n", title, counts.histories,
              counts.wrong, counts.missed, counts.onsets);
  EXPECT_LE(counts.onsets * 20, counts.histories);
  for (auto [name, values] : counts.latency) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    };
    std::printf("  %-18s %4zu  told after [ms] median %.0f, p99 %.0f, max %.0f\n", name.c_str(), values.size(), at(0.5),
                at(0.99), values.back());
  }
}

TEST(RandomHistories, ReportsOneFaultInTimeAndNoOther) {
  for (const double loss : {0.0, 0.01, 0.05}) {
    Counts counts;
    for (const int hosts : {2, 3, 5, 8}) {
      for (unsigned seed = 0; seed < 5; ++seed) judge_history({hosts, 1, loss}, seed, counts);
    }
    print(counts, ("one fault, loss " + std::to_string(loss).substr(0, 4)).c_str());
  }
}

TEST(RandomHistories, ReportsNoHealthyComponentAmongSeveralFaults) {
  for (const int faults : {2, 3}) {
    Counts counts;
    for (const int hosts : {2, 3, 5, 8}) {
      for (const double loss : {0.0, 0.05}) {
        for (unsigned seed = 0; seed < 4; ++seed) judge_history({hosts, faults, loss}, 1000 + seed, counts);
      }
    }
    print(counts, faults == 2 ? "two faults" : "three faults");
  }
}

TEST(RandomHistories, ReportsNoFaultForPeersThatAreDroppedAndMatchedAgain) {
  for (const int faults : {1, 2}) {
    Counts counts;
    for (const int hosts : {2, 3, 5}) {
      for (unsigned seed = 0; seed < 5; ++seed) judge_history({hosts, faults, 0.0, true}, 2000 + seed, counts);
    }
    print(counts, faults == 1 ? "one fault, peers are dropped" : "two faults, peers are dropped");
  }
}

}  // namespace
}  // namespace hecaton::services::testing
