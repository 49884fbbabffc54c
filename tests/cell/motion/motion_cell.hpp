#pragma once
/// A cell of real processes; the test is its supervisor and client. It waits for events, never for a fixed time.

#include <chrono>
#include <csignal>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton::test {

using namespace std::chrono_literals;

/// A time-out for any machine, also with sanitizers.
constexpr auto kLimit = 60s;

class MotionCell : public testing::Test {
 protected:
  /// Writes a cell file with `arms` PUMAs (arm1, arm2, … 1.2 m apart), obstacles as YAML list items, and further lines
  /// of the arms' defaults. With a urdf among these lines, they are all the defaults.
  explicit MotionCell(int arms = 1, const std::string& obstacles = "", const std::string& defaults = "");
  ~MotionCell() override;

  /// `checkpoint`: the driver's checkpoint file; empty: none.
  ChildProcess& start_driver(const std::string& arm = "arm1", const std::string& checkpoint = "");
  /// `checkpoint`: the planner's checkpoint file; empty: none.
  ChildProcess& start_planner(const std::string& arm = "arm1", const std::string& checkpoint = "");
  ChildProcess& start_world();
  /// Starts all services of all arms and waits until every arm runs.
  void start_all();

  /// Publishes the cell mode and reads all topics until `event` holds; false after kLimit.
  [[nodiscard]] bool await(const std::function<bool()>& event);

  void set_mode(msg::Mode mode, std::uint64_t term, const std::string& reason = "");
  msg::Goal joint_goal(const std::string& goal, const std::vector<double>& q, const std::string& arm = "arm1");
  void send(const msg::Goal& goal);
  msg::WorldEditReply edit(msg::WorldEditRequest request);
  [[nodiscard]] msg::Obstacle box(const std::string& name, double x, double y, double z) const;

  [[nodiscard]] const msg::ArmState* arm(const std::string& name = "arm1") const;
  [[nodiscard]] const msg::GoalStatus* status(const std::string& goal, const std::string& arm = "arm1") const;
  [[nodiscard]] bool is(const std::string& goal, msg::GoalState state, const std::string& arm = "arm1") const;
  [[nodiscard]] bool ever(const std::string& goal, msg::GoalState state) const;
  [[nodiscard]] bool moves(const std::string& arm = "arm1") const;

  static const std::vector<double> kHome;
  static const std::vector<double> kReady;

  FreeDomain domain_;
  std::string path_;  ///< of the cell file
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  bus::Writer<msg::CellMode> modes_;
  bus::Writer<msg::Goal> goals_;
  bus::Writer<msg::WorldEditRequest> requests_;
  bus::Reader<msg::WorldEditReply> replies_;
  bus::Reader<msg::ArmState> states_;
  bus::Reader<msg::GoalStatus> statuses_;
  bus::Reader<msg::ObstacleShapes> shapes_;
  bus::Reader<msg::ContactReport> reports_;
  bus::Reader<msg::Heartbeat> heartbeats_;

  std::vector<msg::ArmState> history_;                               ///< all states since the test cleared it
  std::map<std::string, std::vector<msg::GoalStatus>> statuses_of_;  ///< by goal, in order
  std::map<std::string, msg::Heartbeat> alive_;
  msg::CellMode mode_;
  std::vector<ChildProcess> processes_;
  int arm_count_;

 private:
  ChildProcess& start(const std::string& program, const std::string& arm, const std::string& checkpoint = "");
  void read_all();
  std::uint64_t goal_count_ = 0;
  std::uint64_t request_count_ = 0;
};

}  // namespace hecaton::test
