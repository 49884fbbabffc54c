#pragma once
/// A cell of two arms on one host and a third arm on another, in virtual time.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "services/supervisor/detection/fault_detector.hpp"

namespace hecaton::services::testing {

using namespace std::chrono_literals;

inline std::vector<ExpectedNode> cell_nodes() {
  return {{"agent/h1", msg::NodeKind::NODE_AGENT, "", "h1"},
          {"agent/h2", msg::NodeKind::NODE_AGENT, "", "h2"},
          {"world", msg::NodeKind::NODE_WORLD, "", "h1"},
          {"driver/arm1", msg::NodeKind::NODE_DRIVER, "arm1", "h1"},
          {"planner/arm1", msg::NodeKind::NODE_PLANNER, "arm1", "h1"},
          {"driver/arm2", msg::NodeKind::NODE_DRIVER, "arm2", "h1"},
          {"planner/arm2", msg::NodeKind::NODE_PLANNER, "arm2", "h1"},
          {"driver/arm3", msg::NodeKind::NODE_DRIVER, "arm3", "h2"},
          {"planner/arm3", msg::NodeKind::NODE_PLANNER, "arm3", "h2"}};
}

inline std::vector<ExpectedNode> nodes_of_three_hosts() {
  std::vector<ExpectedNode> nodes = cell_nodes();
  nodes.push_back({"agent/h3", msg::NodeKind::NODE_AGENT, {}, "h3"});
  return nodes;
}

inline DetectionLimits cell_limits() {
  DetectionLimits limits;
  limits.node.grace = 1s;
  return limits;
}

/// The limits of a machine that a whole cell shares.
inline DetectionLimits patient_limits() {
  DetectionLimits limits = cell_limits();
  limits.node.silence = limits.arm_stream = limits.world_stream = 250ms;
  limits.node.lost = limits.host_lease = 1s;
  return limits;
}

/// The input of a detector: each process sends a heartbeat every 10 ms, an agent also the row of its host, a driver and
/// the world also states every 5 ms. All links work unless a test cuts them.
class VirtualCell {
 public:
  using Link = std::pair<std::string, std::string>;  ///< from a host to another
  static constexpr Time kBegin = 1h;                 ///< the clock of a machine does not begin with the supervisor

  /// `host`: of the supervisor.
  explicit VirtualCell(std::vector<ExpectedNode> nodes = cell_nodes(), const DetectionLimits& limits = cell_limits(),
                       const std::string& host = {})
      : own(host), detector(std::move(nodes), {"arm1", "arm2", "arm3"}, limits, kBegin, host) {
    std::int64_t pid = 100;
    for (const ExpectedNode& node : detector.nodes()) pids[node.name] = ++pid;
  }

  /// One turn of the supervisor's loop.
  void turn(Time step = 5ms) {
    now += step;
    detector.advance(now);
    const bool beat = ++turns % 2 == 0 || step > 5ms;
    for (const ExpectedNode& node : detector.nodes()) {
      if (!running(node.name)) continue;
      if (beat && node.role == msg::NodeKind::NODE_AGENT) send_row(node.host);
      if (cut.contains({node.host, own})) continue;
      const bool streams = node.role == msg::NodeKind::NODE_DRIVER || node.role == msg::NodeKind::NODE_WORLD;
      if (streams && !mute.contains(node.name)) detector.stream_heard(node.name, now);
      if (beat) detector.heard(node.name, {pids[node.name], now, 0, std::nullopt, keys_of(node.name)});
    }
    detector.judge(now);
  }
  void run_for(Time duration) {
    for (const Time end = now + duration; now < end;) turn();
  }

  [[nodiscard]] bool running(const std::string& node) const { return !hung.contains(node) && !dead.contains(node); }
  void kill(const std::string& node, int signal, bool told = true) {
    dead.insert(node);
    hung.erase(node);
    if (told) detector.process_exited(node, {pids[node], -1, signal, false});
  }
  void start(const std::string& node, bool told = true) {
    dead.erase(node);
    hung.erase(node);
    pids[node] += 1000;
    if (told) detector.process_started(node, pids[node]);
  }
  void fall_silent(const std::string& host) {
    for (const ExpectedNode& node : detector.nodes()) {
      if (node.host == host) hung.insert(node.name);
    }
  }
  void cut_link(const std::string& from, const std::string& to) { cut.insert({from, to}); }
  /// Sends nothing to other hosts, hears nothing from them.
  void mute_host(const std::string& host) {
    for (const std::string& other : hosts()) cut_link(host, other);
  }
  void deafen_host(const std::string& host) {
    for (const std::string& other : hosts()) cut_link(other, host);
  }
  [[nodiscard]] std::vector<std::string> faulty() {
    std::vector<std::string> subjects;
    for (const FaultRecord& fault : detector.faults().open()) subjects.push_back(fault.subject);
    return subjects;
  }
  [[nodiscard]] std::vector<std::string> held() { return arms_on(detector.mode().decide(), msg::Mode::MODE_HOLD); }

  std::string own;
  FaultDetector detector;
  std::map<std::string, std::int64_t> pids;
  std::set<std::string> hung;  ///< alive, but their loops stand still
  std::set<std::string> dead;
  std::set<std::string> mute;  ///< nodes that send heartbeats, but no states
  std::set<Link> cut;
  std::map<std::string, KeyExpiry> keys;  ///< by node
  Time now = kBegin;
  int turns = 0;

 private:
  [[nodiscard]] std::optional<KeyExpiry> keys_of(const std::string& node) const {
    const auto found = keys.find(node);
    return found == keys.end() ? std::nullopt : std::optional(found->second);
  }
  [[nodiscard]] std::set<std::string> hosts() const {
    std::set<std::string> hosts;
    for (const ExpectedNode& node : detector.nodes()) hosts.insert(node.host);
    return hosts;
  }
  void send_row(const std::string& observer) {
    std::vector<HostAge> ages;
    for (const std::string& subject : hosts()) {
      if (subject == observer) continue;
      const bool arrives = running("agent/" + subject) && !cut.contains({subject, observer});
      if (arrives) newest_[{subject, observer}] = now;
      const auto newest = newest_.find({subject, observer});
      if (newest != newest_.end()) ages.push_back({subject, now - newest->second});
    }
    if (!cut.contains({observer, own})) detector.row_heard(observer, ages, now);
  }

  std::map<Link, Time> newest_;  // packet that an agent has heard from another host's
};

using Names = std::vector<std::string>;

class FaultDetectorTest : public ::testing::Test, protected VirtualCell {
 protected:
  FaultDetectorTest() { run_for(200ms); }

  // The only open fault; fails the test when there is another number of them.
  FaultRecord the_fault() {
    const auto open = detector.faults().open();
    EXPECT_EQ(open.size(), 1U);
    return open.empty() ? FaultRecord{} : open.front();
  }
};

}  // namespace hecaton::services::testing
