// Detection on a network that loses heartbeats.

#include <map>
#include <random>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/unit/services/supervisor/detection/virtual_cell.hpp"

namespace hecaton::services::testing {
namespace {

/// Nodes send heartbeats with phases of their own and some delay, and some are lost. The supervisor is on a third host.
class LossyCell {
 public:
  explicit LossyCell(unsigned seed)
      : random_(seed), detector(nodes_of(), {"arm1", "arm2", "arm3"}, cell_limits(), 0ms, "h3") {
    for (const ExpectedNode& node : detector.nodes()) {
      beats_[node.name].due = any_time(10ms);
      states_[node.name].due = any_time(5ms);
    }
  }

  void run_for(Time duration) {
    for (const Time end = now_ + duration; now_ < end;) {
      now_ += 5ms;
      detector.advance(now_);
      for (const ExpectedNode& node : detector.nodes()) send(node);
      detector.judge(now_);
    }
  }
  [[nodiscard]] bool has_fault() const {
    return !detector.faults().open().empty() || !detector.faults().cleared().empty();
  }

 private:
  struct Sender {
    Time due{0};
    std::uint64_t number = 0;
  };
  static std::vector<ExpectedNode> nodes_of() {
    std::vector<ExpectedNode> nodes = cell_nodes();
    nodes.push_back({"agent/h3", msg::NodeKind::NODE_AGENT, {}, "h3"});
    return nodes;
  }
  Time any_time(Time below) { return Time(std::uniform_int_distribution<Time::rep>(0, below.count() - 1)(random_)); }
  void send(const ExpectedNode& node) {
    if (hung.contains(node.name)) return;
    const bool far = node.host != "h3" && (lossy.empty() || lossy == node.host);
    if (node.role == msg::NodeKind::NODE_AGENT) send_row(node.host);
    for (Sender& beat = beats_[node.name]; beat.due <= now_; beat.due += 10ms) {
      ++beat.number;
      if (!far || !is_lost()) detector.heard(node.name, {1, beat.due, beat.number});
    }
    if (node.role != msg::NodeKind::NODE_DRIVER && node.role != msg::NodeKind::NODE_WORLD) return;
    for (Sender& state = states_[node.name]; state.due <= now_; state.due += 5ms) {
      ++state.number;
      if (!far || !is_lost()) detector.stream_heard(node.name, state.due, state.number);
    }
  }
  void send_row(const std::string& observer) {
    for (const char* host : {"h1", "h2", "h3"}) {
      if (!hung.contains("agent/" + std::string(host))) newest_[host] = now_;
    }
    std::vector<HostAge> ages;
    for (const auto& [host, newest] : newest_) {
      if (host != observer) ages.push_back({host, now_ - newest});
    }
    detector.row_heard(observer, ages, now_);
  }
  bool is_lost() { return std::bernoulli_distribution(lost)(random_); }

  std::mt19937 random_;
  std::map<std::string, Sender> beats_, states_;
  std::map<std::string, Time> newest_;  // of each host's agent
  Time now_{0};

 public:
  FaultDetector detector;
  double lost = 0.0;
  std::string lossy;  ///< what this host sends is lost; empty: what comes to the supervisor
  std::set<std::string> hung;
};

/// Of a hundred onsets of loss, the number with a fault within two seconds.
int false_faults(double lost, const std::string& lossy) {
  int faults = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    LossyCell cell(seed);
    cell.run_for(1s);
    cell.lost = lost;
    cell.lossy = lossy;
    cell.run_for(2s);
    faults += cell.has_fault() ? 1 : 0;
  }
  return faults;
}

// Two lost heartbeats of a planner before any other loss cannot be distinguished from a hanging loop.
TEST(PacketLoss, ReportsNoFaultForLostPackets) {
  for (const double lost : {0.01, 0.1, 0.3}) {
    EXPECT_LE(false_faults(lost, ""), 1) << lost << " of packets to the supervisor";
    EXPECT_LE(false_faults(lost, "h1"), 1) << lost << " of packets from h1";
  }
}

TEST(PacketLoss, ReportsAHangDespiteLosses) {
  LossyCell cell(1);
  cell.run_for(1s);
  cell.lost = 0.3;
  cell.run_for(1s);
  ASSERT_FALSE(cell.has_fault());
  cell.hung.insert("planner/arm1");
  cell.run_for(240ms);  // 22 heartbeats of 10 ms at most, and a turn
  ASSERT_EQ(cell.detector.faults().open().size(), 1U);
  const FaultRecord fault = cell.detector.faults().open().front();
  EXPECT_EQ(fault.subject, "planner/arm1");
  EXPECT_TRUE(fault.description.ends_with(" ms, while the network loses others")) << fault.description;
}

TEST(PacketLoss, ReportsAHangWithinTheLimitOnceLossesHaveEnded) {
  LossyCell cell(1);
  cell.run_for(1s);
  cell.lost = 0.3;
  cell.run_for(1s);
  cell.lost = 0.0;
  cell.run_for(9s);
  cell.hung.insert("planner/arm1");
  cell.run_for(25ms);
  EXPECT_TRUE(cell.has_fault());
}

TEST(PacketLoss, CountsALostHostAsNoPacketLoss) {
  LossyCell cell(1);
  cell.run_for(1s);
  for (const auto* node : {"agent/h2", "driver/arm3", "planner/arm3"}) cell.hung.insert(node);
  cell.run_for(105ms);
  ASSERT_EQ(cell.detector.faults().open().size(), 1U);
  EXPECT_EQ(cell.detector.faults().open().front().description, "host h2: no host has heard it for 100 ms");
  cell.hung.clear();
  cell.run_for(1s);
  cell.hung.insert("planner/arm1");
  cell.run_for(25ms);
  ASSERT_EQ(cell.detector.faults().open().size(), 1U) << "ten heartbeats of each were missed, and none was lost";
}

}  // namespace
}  // namespace hecaton::services::testing
