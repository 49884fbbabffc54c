// The world dies. Its successor continues with all edits and with the report of the contact monitor.

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "planner/model/kinematics.hpp"
#include "services/messages/convert.hpp"
#include "tests/cell/supervision/health_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::services::testing {
namespace {

msg::WorldEditRequest request(msg::EditKind kind, const std::string& name) {
  msg::WorldEditRequest message;
  message.kind(kind);
  message.name(name);
  message.X_WO().qw(1.0);
  return message;
}

msg::WorldEditRequest add_ball(const std::string& name, double radius, const Eigen::Vector3d& place) {
  world::Obstacle obstacle;
  obstacle.name = name;
  obstacle.shapes.push_back({world::Sphere{radius}});
  obstacle.X_WO.translation() = place;
  msg::WorldEditRequest message = request(msg::EditKind::EDIT_ADD, name);
  message.obstacle(messages::to_message(obstacle));
  return message;
}

/// Position of the tool of arm "left" in its posture `named` [m].
Eigen::Vector3d tool_at(const HealthCell& cell, const std::string& named) {
  const planner::Arm& arm = cell.file().cell.arms[0].arm;
  planner::Kinematics kinematics;
  planner::forward_kinematics(*arm.model, arm.X_WB, arm.named.at(named), kinematics);
  return kinematics.X_WT.translation();
}

const msg::ObstacleStatus* obstacle(const msg::CellStatus& status, const std::string& name) {
  for (const msg::ObstacleStatus& known : status.obstacles()) {
    if (known.name() == name) return &known;
  }
  return nullptr;
}

class HealthWorld : public ::testing::Test {
 protected:
  int pid_of_world() {
    const auto process = process_of(cell_.await_healthy(), "world");
    EXPECT_TRUE(process);
    return process ? process->pid() : 0;
  }
  void kill_world_and_await_its_successor() {
    const int pid = pid_of_world();
    ASSERT_GT(pid, 0);
    ASSERT_TRUE(test::signal_process(pid, SIGKILL));
    cell_.await("another world", [&](const msg::CellStatus& status) {
      const auto process = process_of(status, "world");
      return process && process->kind() == msg::ProcessEventKind::PROCESS_STARTED && process->pid() != pid;
    });
    cell_.await_healthy();
  }
  HealthCell cell_;
};

TEST_F(HealthWorld, EditsContactsAndTimeSurviveTheDeathOfTheWorld) {
  cell_.await_healthy();
  ASSERT_TRUE(cell_.edit(add_ball("crate", 0.1, tool_at(cell_, "away"))).done());
  ASSERT_TRUE(cell_.edit(add_ball("far", 0.1, {3.0, 0.0, 0.5})).done());
  msg::WorldEditRequest move = request(msg::EditKind::EDIT_MOVE, "far");
  move.X_WO().position().x(4.0);
  ASSERT_TRUE(cell_.edit(move).done());
  ASSERT_TRUE(cell_.edit(request(msg::EditKind::EDIT_REMOVE, "ball")).done());
  // The arm stands and has no goal. Its shoulder is above (0, 2) at about 0.66 m, and a ball rolls through it. The
  // ball's position follows the world's time: now it is 1.5 m before the arm.
  const double way = std::fmod(cell_.await_healthy().contact_report().time(), 10.0);
  msg::WorldEditRequest runner = add_ball("runner", 0.1, {-1.5 - way, 2.0, 0.66});
  runner.obstacle().motion().kind(msg::MotionKind::MOTION_CONVEYOR);
  runner.obstacle().motion().direction_W().x(1.0);
  runner.obstacle().motion().speed(1.0);
  runner.obstacle().motion().length(10.0);
  const auto rolls = cell_.edit(runner);
  ASSERT_TRUE(rolls.done()) << rolls.cause().text();
  cell_.await("a contact", [](const msg::CellStatus& status) { return status.contact_report().contacts() > 0; });
  ASSERT_TRUE(cell_.edit(request(msg::EditKind::EDIT_REMOVE, "runner")).done());
  cell_.await("a hold", [](const msg::CellStatus& status) {
    return status.mode().mode() == msg::Mode::MODE_HOLD &&
           causes_text(status.mode()).find("touched") != std::string::npos;
  });
  const msg::Fault touch = cell_.await_fault(
      "the contact", [](const msg::Fault& f) { return f.cause().kind() == msg::CauseKind::CAUSE_CONTACT; });
  EXPECT_NE(touch.cause().text().find("runner"), std::string::npos) << touch.cause().text();
  ASSERT_TRUE(cell_.call(msg::RequestKind::REQUEST_RESUME)->done());
  const auto gone = cell_.await("no runner", [](const msg::CellStatus& status) { return !obstacle(status, "runner"); });
  const auto before = cell_.await("the whole report", [&](const msg::CellStatus& status) {
    return status.contact_report().time() > gone.contact_report().time();
  });

  for (int deaths = 0; deaths < 2; ++deaths) {
    kill_world_and_await_its_successor();
    const auto after = cell_.await("a report of the successor", [&](const msg::CellStatus& status) {
      return status.contact_report().time() > before.contact_report().time();
    });
    EXPECT_EQ(after.contact_report().contacts(), before.contact_report().contacts());
    EXPECT_EQ(after.contact_report().smallest(), before.contact_report().smallest());
    ASSERT_EQ(after.obstacles().size(), 2U) << "the removed obstacle stays removed";
    ASSERT_TRUE(obstacle(after, "crate"));
    ASSERT_TRUE(obstacle(after, "far"));
    EXPECT_EQ(obstacle(after, "far")->X_WO().position().x(), 4.0);
  }
  // The planners know the crate, too.
  cell_.send_goal("left", "into the crate", "away");
  const auto refused = cell_.await_goal("into the crate", [](const msg::GoalStatus& status) {
    return status.state() == msg::GoalState::GOAL_REJECTED || status.state() == msg::GoalState::GOAL_BLOCKED;
  });
  EXPECT_NE((refused.cause().text() + refused.binding_other()).find("crate"), std::string::npos)
      << refused.cause().text();
}

/// The checkpoint file of a service.
std::string checkpoint_of(int pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/cmdline");
  for (std::string word; std::getline(file, word, '\0');) {
    if (word == "--checkpoint" && std::getline(file, word, '\0')) return word;
  }
  return {};
}

/// While it exists, the process can open no further files.
class NoFiles {
 public:
  explicit NoFiles(int pid) : pid_(pid) {
    prlimit(pid_, RLIMIT_NOFILE, nullptr, &before_);
    const rlimit none{3, before_.rlim_max};  // those of every process
    EXPECT_EQ(prlimit(pid_, RLIMIT_NOFILE, &none, nullptr), 0);
  }
  ~NoFiles() { prlimit(pid_, RLIMIT_NOFILE, &before_, nullptr); }
  NoFiles(const NoFiles&) = delete;
  NoFiles& operator=(const NoFiles&) = delete;

 private:
  int pid_;
  rlimit before_{};
};

/// Heartbeat of the world.
msg::Heartbeat world_in(const msg::CellStatus& status) {
  for (const msg::NodeStatus& node : status.nodes()) {
    if (node.heartbeat().node() == "world") return node.heartbeat();
  }
  return {};
}

TEST_F(HealthWorld, ReportsEditsThatItCannotPersistAndKeepsTheRest) {
  const int pid = pid_of_world();
  ASSERT_GT(pid, 0);
  const std::string not_persisted = "not persisted and will be lost when the world restarts: " + checkpoint_of(pid) +
                                    " cannot be written: Too many open files";
  EXPECT_EQ(cell_.edit(add_ball("first", 0.1, {3.0, 0.0, 0.5})).cause().text(), "");
  {
    const NoFiles none(pid);
    const auto second = cell_.edit(add_ball("second", 0.1, {3.0, 1.0, 0.5}));
    EXPECT_TRUE(second.done());
    EXPECT_EQ(second.cause().text(), "the edit is " + not_persisted);
    const auto status = cell_.await("that the world says so", [](const msg::CellStatus& seen) {
      return world_in(seen).state() == msg::NodeState::NODE_DEGRADED;
    });
    EXPECT_EQ(world_in(status).cause().text(), "edits are " + not_persisted);
    EXPECT_TRUE(obstacle(status, "second"));
  }
  cell_.await("that it remembers again", [](const msg::CellStatus& seen) {
    return world_in(seen).state() == msg::NodeState::NODE_RUNNING && is_none(world_in(seen).cause());
  });
  const NoFiles none(pid);
  EXPECT_EQ(cell_.edit(add_ball("third", 0.1, {3.0, 2.0, 0.5})).cause().text(), "the edit is " + not_persisted);
  kill_world_and_await_its_successor();
  const auto after = cell_.await("what the successor has", [](const msg::CellStatus& seen) {
    return world_in(seen).state() == msg::NodeState::NODE_RUNNING && obstacle(seen, "second") &&
           !obstacle(seen, "third");
  });
  EXPECT_TRUE(obstacle(after, "first"));
}

TEST_F(HealthWorld, HoldsTheCellWhenItsCheckpointCannotBeUsed) {
  const int pid = pid_of_world();
  const std::string checkpoint = checkpoint_of(pid);
  cell_.await("the checkpoint " + checkpoint,
              [&](const msg::CellStatus&) { return std::filesystem::exists(checkpoint); });
  ASSERT_TRUE(test::signal_process(pid, SIGSTOP));  // so that it writes no more
  std::ofstream(checkpoint, std::ios::trunc) << "not a checkpoint";
  ASSERT_TRUE(test::signal_process(pid, SIGKILL));
  const auto status = cell_.await("the failure", [](const msg::CellStatus& seen) {
    return open_faults(seen, "node_failed", "world") == 1 && seen.mode().mode() == msg::Mode::MODE_HOLD;
  });
  EXPECT_EQ(causes_text(status.mode()), "world: the edits before the world's restart cannot be restored (" +
                                            checkpoint + " is damaged); shut the cell down and start it again");
  const auto refused = cell_.edit(add_ball("crate", 0.1, {3.0, 0.0, 0.5}));
  EXPECT_FALSE(refused.done());
  EXPECT_EQ("world: " + refused.cause().text(), causes_text(status.mode()));
}

}  // namespace
}  // namespace hecaton::services::testing
