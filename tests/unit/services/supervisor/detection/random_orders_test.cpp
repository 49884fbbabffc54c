// Random histories of a cell, with fixed seeds. Invariants:
// - while stop is latched nothing is on run;
// - a key has at most one open fault;
// - an arm one of whose nodes is known to be faulty is not on run;
// - after a while without failures every fault is cleared, and the mode is the ordered one.

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/services/supervisor/detection/virtual_cell.hpp"

namespace hecaton::services::testing {
namespace {

class RandomHistory : public ::testing::TestWithParam<unsigned> {
 protected:
  int below(int limit) { return std::uniform_int_distribution<>(0, limit - 1)(random_); }
  std::string any_node() {
    const auto& nodes = cell_.detector.nodes();
    return nodes[static_cast<std::size_t>(below(static_cast<int>(nodes.size())))].name;
  }
  std::vector<std::string> any_arms() {
    std::vector<std::string> arms;
    for (const auto* arm : {"arm1", "arm2", "arm3"}) {
      if (below(4) == 0) arms.emplace_back(arm);
    }
    return arms;
  }

  void order() {
    const auto arms = any_arms();
    msg::Cause refusal;
    switch (below(3)) {
      case 0:
        refusal = cell_.detector.mode().hold(arms);
        break;
      case 1:
        refusal = cell_.detector.mode().stop(arms);
        if (arms.empty()) stopped_ = true;
        break;
      default:
        refusal = cell_.detector.mode().resume(arms);
        if (arms.empty()) stopped_ = false;
    }
    EXPECT_TRUE(is_none(refusal) || refusal.kind() == msg::CauseKind::CAUSE_NOT_ALLOWED_NOW);
  }

  void happen() {
    const std::string node = any_node();
    switch (below(8)) {
      case 0:
        if (!node.starts_with("agent")) cell_.kill(node, 9);
        break;
      case 1:
        cell_.kill(node, 6, false);
        break;
      case 2:
      case 3:
        if (cell_.dead.contains(node)) cell_.start(node, below(2) == 0);
        break;
      case 4:
        if (cell_.running(node)) cell_.hung.insert(node);
        break;
      case 5:
        cell_.hung.clear();
        break;
      case 6:
        if (!cell_.mute.erase(node)) cell_.mute.insert(node);
        break;
      default:
        order();
    }
  }

  void check() {
    const msg::CellMode decision = cell_.detector.mode().decide();
    if (stopped_) {
      EXPECT_EQ(decision.mode(), msg::Mode::MODE_STOP);
      for (const auto* arm : {"arm1", "arm2", "arm3"})
        EXPECT_EQ(cell_.detector.mode().mode_of(arm), msg::Mode::MODE_STOP);
    }
    std::set<std::string> subjects;
    for (const FaultRecord& fault : cell_.detector.faults().open()) {
      EXPECT_TRUE(subjects.insert(fault.subject).second) << fault.subject;
      const auto slash = fault.subject.find('/');
      const std::string arm = slash == std::string::npos ? fault.subject : fault.subject.substr(slash + 1);
      if (arm.starts_with("arm")) {
        EXPECT_NE(cell_.detector.mode().mode_of(arm), msg::Mode::MODE_RUN) << fault.description;
      }
      if (fault.subject == "world") {
        EXPECT_NE(decision.mode(), msg::Mode::MODE_RUN) << fault.description;
      }
    }
  }

  void heal() {
    cell_.hung.clear();
    cell_.mute.clear();
    while (!cell_.dead.empty()) cell_.start(std::string(*cell_.dead.begin()));
    cell_.run_for(1s);
    EXPECT_TRUE(cell_.detector.faults().open().empty());
    for (const FaultRecord& fault : cell_.detector.faults().cleared()) EXPECT_TRUE(fault.cleared_at.has_value());
    const Orders& orders = cell_.detector.mode().orders();
    EXPECT_EQ(cell_.detector.mode().decide().mode(), orders.cell);
    for (const auto* arm : {"arm1", "arm2", "arm3"}) {
      const auto own = orders.arms.find(arm);
      const msg::Mode ordered = own == orders.arms.end() ? msg::Mode::MODE_RUN : own->second;
      EXPECT_EQ(cell_.detector.mode().mode_of(arm), std::max(ordered, orders.cell));
    }
  }

  std::mt19937 random_{GetParam()};
  VirtualCell cell_;
  bool stopped_ = false;
};

TEST_P(RandomHistory, KeepsItsInvariants) {
  cell_.run_for(100ms);
  for (int episode = 0; episode < 10; ++episode) {
    for (int event = 0; event < 40; ++event) {
      happen();
      const int turns = below(40);
      for (int turn = 0; turn < turns; ++turn) {
        cell_.turn(below(50) == 0 ? Time(below(300) * 1ms) + 5ms : 5ms);
        check();
      }
      if (HasFailure()) FAIL() << "episode " << episode << ", event " << event;
    }
    heal();
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomHistory, ::testing::Range(1U, 21U));

}  // namespace
}  // namespace hecaton::services::testing
