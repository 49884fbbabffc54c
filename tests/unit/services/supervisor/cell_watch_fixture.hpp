#pragma once
/// A cell of two arms on one host and a third on another, in virtual time.

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "services/supervisor/cell_watch.hpp"

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

inline WatchLimits cell_limits() {
  WatchLimits limits;
  limits.node.grace = 1s;
  return limits;
}

/// The processes that the watch is told of: each beats every 10 ms, drivers tell states every 5 ms.
class VirtualCell {
 public:
  /// `host`: where the supervisor is.
  explicit VirtualCell(std::vector<ExpectedNode> nodes = cell_nodes(), const WatchLimits& limits = cell_limits(),
                       std::string host = {})
      : watch(std::move(nodes), {"arm1", "arm2", "arm3"}, limits, 0ms, std::move(host)) {
    std::int64_t pid = 100;
    for (const ExpectedNode& node : watch.nodes()) pids[node.name] = ++pid;
  }

  /// One turn of the supervisor's loop.
  void turn(Time step = 5ms) {
    now += step;
    watch.advance(now);
    const bool beat = ++turns % 2 == 0;
    for (const ExpectedNode& node : watch.nodes()) {
      if (!running(node.name)) continue;
      const bool streams = node.role == msg::NodeKind::NODE_DRIVER || node.role == msg::NodeKind::NODE_WORLD;
      if (streams && !mute.contains(node.name)) watch.stream_heard(node.name, now);
      if (beat || step > 5ms) watch.heard(node.name, {pids[node.name], now});
    }
    watch.judge(now);
  }
  void run_for(Time duration) {
    for (const Time end = now + duration; now < end;) turn();
  }

  [[nodiscard]] bool running(const std::string& node) const { return !hung.contains(node) && !dead.contains(node); }
  void kill(const std::string& node, int signal, bool told = true) {
    dead.insert(node);
    hung.erase(node);
    if (told) watch.process_exited(node, {pids[node], -1, signal, false});
  }
  void start(const std::string& node, bool told = true) {
    dead.erase(node);
    hung.erase(node);
    pids[node] += 1000;
    if (told) watch.process_started(node, pids[node]);
  }

  CellWatch watch;
  std::map<std::string, std::int64_t> pids;
  std::set<std::string> hung;  ///< alive, but their loops stand still
  std::set<std::string> dead;
  std::set<std::string> mute;  ///< beat, but do not stream
  Time now{0};
  int turns = 0;
};

using Names = std::vector<std::string>;

class CellWatchTest : public ::testing::Test, protected VirtualCell {
 protected:
  CellWatchTest() { run_for(200ms); }

  // The one open fault, or a failure.
  FaultRecord the_fault() {
    const auto open = watch.faults().open();
    EXPECT_EQ(open.size(), 1U);
    return open.empty() ? FaultRecord{} : open.front();
  }
  Names held() { return arms_on(watch.mode().decide(), msg::Mode::MODE_HOLD); }
};

}  // namespace hecaton::services::testing
