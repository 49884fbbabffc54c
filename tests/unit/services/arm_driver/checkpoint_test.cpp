// State that survives a driver's process: its lease, and the simulated arm's position.
#include <array>
#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/arm_driver/command_gate.hpp"
#include "services/arm_driver/devices/simulated/simulated_arm.hpp"
#include "services/bus/wire_rules.hpp"
#include "services/runtime/atomic_file.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

class CheckpointTest : public ::testing::Test {
 protected:
  ~CheckpointTest() override { std::filesystem::remove(path_); }

  /// An arm that starts at `start` without a checkpoint.
  [[nodiscard]] std::unique_ptr<device::ArmDevice> arm(const planner::JointVector& start) const {
    const auto n = start.size();
    device::DeviceSetup setup;
    setup.limits = {planner::JointVector::Constant(n, -3.0), planner::JointVector::Constant(n, 3.0),
                    planner::JointVector::Constant(n, 1.0), planner::JointVector::Constant(n, 10.0)};
    setup.start = start;
    setup.period = 2ms;
    setup.checkpoint = path_;
    return device::make_simulated_arm(setup);
  }

  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("hecaton_checkpoint_" + std::to_string(getpid()))).string();
  const ArmLease first_{"planner/arm1@beta", 7};
  const ArmLease second_{"planner/arm1", 8};
};

TEST_F(CheckpointTest, IsEmptyInANewFile) {
  EXPECT_FALSE(LeaseCheckpoint(path_).recall());
}

TEST_F(CheckpointTest, IsEmptyWithoutAFile) {
  LeaseCheckpoint checkpoint("");
  checkpoint.remember(first_);
  EXPECT_FALSE(checkpoint.recall());
}

// With such a lease the driver would refuse every planner and cell mode, also after the next restart.
TEST_F(CheckpointTest, IsNoLeaseWithAnUnusableTerm) {
  LeaseCheckpoint checkpoint(path_);
  for (const std::uint64_t term : {bus::kLargestTerm, ~std::uint64_t{0}}) {
    checkpoint.remember({"planner/arm1", term});
    EXPECT_EQ(checkpoint.recall(), ArmLease()) << term;
  }
}

TEST_F(CheckpointTest, HasTheLastLease) {
  LeaseCheckpoint checkpoint(path_);
  for (int i = 0; i < 5; ++i) {
    checkpoint.remember(first_);
    EXPECT_EQ(checkpoint.recall(), first_);
    checkpoint.remember(second_);
    EXPECT_EQ(checkpoint.recall(), second_);
  }
}

TEST_F(CheckpointTest, KeepsTheLeaseOfAKilledProcess) {
  const pid_t child = fork();
  if (child == 0) {
    LeaseCheckpoint checkpoint(path_);
    checkpoint.remember(first_);
    checkpoint.remember(second_);
    std::raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  LeaseCheckpoint successor(path_);
  EXPECT_EQ(successor.recall(), second_);
  successor.remember(first_);
  EXPECT_EQ(successor.recall(), first_) << "the successor continues with it";
}

TEST_F(CheckpointTest, FindsTheLeaseBesideASlotOfAnotherLayout) {
  using Other = std::array<std::uint64_t, 33>;  // of a lease record's size
  MappedRecord<Other> other(path_, 1, "a test's record");
  for (int i = 0; i < 3; ++i) other.remember({});
  LeaseCheckpoint checkpoint(path_);
  EXPECT_FALSE(checkpoint.recall());
  checkpoint.remember(first_);
  EXPECT_EQ(checkpoint.recall(), first_);
}

// A cut name would belong to no planner, and no planner could command the arm.
TEST_F(CheckpointTest, KeepsTheTermAloneOfAnOverlongName) {
  LeaseCheckpoint checkpoint(path_);
  checkpoint.remember({std::string(256, 'p'), 9});
  EXPECT_EQ(checkpoint.recall(), (ArmLease{"", 9}));
  checkpoint.remember({std::string(255, 'p'), 9});
  EXPECT_EQ(checkpoint.recall(), (ArmLease{std::string(255, 'p'), 9}));
}

TEST_F(CheckpointTest, RefusesAFolder) {
  const std::string folder = std::filesystem::temp_directory_path().string();
  try {
    LeaseCheckpoint checkpoint(folder);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), folder + ": the driver's lease cannot be kept there: Is a directory");
  }
}

TEST_F(CheckpointTest, KeepsThePositionOfASimulatedArm) {
  const planner::JointVector start = planner::JointVector::Constant(2, 0.1);
  device::Clock::time_point now{1h};
  const pid_t child = fork();
  if (child == 0) {
    auto moved = arm(start);
    for (int i = 0; i < 1000; ++i) {
      (void)moved->read(now += 2ms);
      (void)moved->write({planner::JointVector::Constant(2, 0.7), planner::JointVector::Zero(2)}, 12ms);
    }
    std::raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  const device::DeviceState found = arm(start)->read(now);
  EXPECT_NEAR(found.measured.q[0], 0.7, 1e-6);
  EXPECT_TRUE(found.measured.qd.isZero());
}

TEST_F(CheckpointTest, IgnoresThePositionOfAnArmWithOtherJoints) {
  device::Clock::time_point now{1h};
  (void)arm(planner::JointVector::Constant(2, 0.5))->read(now);
  EXPECT_EQ(arm(planner::JointVector::Constant(3, 0.1))->read(now).measured.q, planner::JointVector::Constant(3, 0.1));
}

}  // namespace
}  // namespace hecaton::services
