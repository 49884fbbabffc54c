#include "services/planner/failover.hpp"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

TEST(FailoverRole, IsInChargeWithTheFirstLeaseThatNamesIt) {
  FailoverRole role("p", true);
  EXPECT_FALSE(role.in_charge());
  role.update({});
  EXPECT_FALSE(role.in_charge());
  role.update({"p", 4});
  EXPECT_TRUE(role.in_charge());
  EXPECT_EQ(role.term(), 4U);
  role.update({"q", 6});
  EXPECT_FALSE(role.in_charge());
  role.update({"p", 4});
  EXPECT_FALSE(role.in_charge()) << "an old lease";
}

TEST(FailoverRole, IsInChargeOfTheFirstPlannerUnderALeaseWithoutPlanner) {
  FailoverRole only("p", true);
  only.update({{}, 2});
  EXPECT_TRUE(only.in_charge());
  FailoverRole second("q", false);
  second.update({{}, 2});
  EXPECT_FALSE(second.in_charge());
}

TEST(FailoverRole, EndsWhenTheDriverHasAnotherLease) {
  FailoverRole role("p", true);
  role.update({"p", 4});
  role.update_from_driver({{}, 4});
  EXPECT_TRUE(role.in_charge()) << "no planner has commanded under it yet";
  role.update_from_driver({"q", 4});
  EXPECT_FALSE(role.in_charge());
  role.update({"p", 5});
  EXPECT_TRUE(role.in_charge());
}

msg::GoalStatus status(const std::string& goal, msg::GoalState state) {
  msg::GoalStatus message;
  message.goal(goal);
  message.state(state);
  return message;
}

TEST(UnpublishedResults, KeepFinalStatusesThatWereNotPublished) {
  UnpublishedResults unpublished;
  unpublished.keep({status("a", msg::GoalState::GOAL_ACTIVE), status("a", msg::GoalState::GOAL_REACHED),
                    status("b", msg::GoalState::GOAL_REJECTED)});
  unpublished.on_published(status("a", msg::GoalState::GOAL_ACTIVE));
  unpublished.on_published(status("b", msg::GoalState::GOAL_REJECTED));
  const auto left = unpublished.take();
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].goal(), "a");
  EXPECT_EQ(left[0].state(), msg::GoalState::GOAL_REACHED);
  EXPECT_TRUE(unpublished.take().empty());
}

TEST(UnpublishedResults, ListUnpublishedResults) {
  UnpublishedResults unpublished;
  unpublished.keep({status("a", msg::GoalState::GOAL_REACHED), status("b", msg::GoalState::GOAL_CANCELLED),
                    status("c", msg::GoalState::GOAL_ACTIVE)});
  unpublished.on_published(status("a", msg::GoalState::GOAL_REACHED));
  EXPECT_EQ(unpublished.results(), (std::vector<GoalSnapshot::Result>{{"b", msg::GoalState::GOAL_CANCELLED}}));
}

TEST(UnpublishedResults, IgnoreResultsPublishedBefore) {
  UnpublishedResults unpublished;
  unpublished.on_published(status("a", msg::GoalState::GOAL_REACHED));
  unpublished.keep({status("a", msg::GoalState::GOAL_REACHED)});
  EXPECT_TRUE(unpublished.take().empty());
}

/// The checkpoint of a restarted planner, saved under term 4 and complete until 100 s on the clock of its host.
class JudgeCheckpoint : public ::testing::Test {
 protected:
  /// Planner "p" judges; `newest`: the lease that it knows.
  [[nodiscard]] static CheckpointValidity judge(const ArmLease& under, const ArmLease& newest,
                                                const std::optional<LastCommand>& last) {
    FailoverRole role("p", true);
    role.update(newest);
    return judge_checkpoint(under, kUntil, role, last);
  }
  /// The driver's last command, `later` than the checkpoint.
  [[nodiscard]] static LastCommand command(std::uint64_t term, std::chrono::milliseconds later) {
    return {term, kUntil + later};
  }
  static constexpr std::chrono::nanoseconds kUntil = std::chrono::seconds(100);
  const ArmLease ours_{"p", 4};
  const ArmLease others_{"q", 4};
};

TEST_F(JudgeCheckpoint, IsUndecidedBeforeTheFirstLease) {
  EXPECT_EQ(judge(ours_, {}, command(4, 0ms)), CheckpointValidity::kUndecided);
}

TEST_F(JudgeCheckpoint, IsValidUnderTheSameLease) {
  EXPECT_EQ(judge(ours_, ours_, std::nullopt), CheckpointValidity::kValid);
  EXPECT_EQ(judge(ours_, ours_, command(4, 0ms)), CheckpointValidity::kValid);
}

// A goal that ended while the other planner was in charge must not return.
TEST_F(JudgeCheckpoint, IsOutdatedAfterACommandOfTheOtherPlanner) {
  const ArmLease taken_over{"q", 6};
  EXPECT_EQ(judge(ours_, taken_over, std::nullopt), CheckpointValidity::kUndecided) << "it may be dead";
  EXPECT_EQ(judge(ours_, taken_over, command(4, 0ms)), CheckpointValidity::kUndecided) << "it may be dead";
  EXPECT_EQ(judge(ours_, taken_over, command(6, 10ms)), CheckpointValidity::kOutdated);
  const ArmLease given_back{"p", 8};
  EXPECT_EQ(judge(ours_, given_back, command(6, 10ms)), CheckpointValidity::kOutdated);
  EXPECT_EQ(judge(ours_, given_back, std::nullopt), CheckpointValidity::kUndecided);
  EXPECT_EQ(judge(ours_, given_back, command(4, 0ms)), CheckpointValidity::kValid)
      << "the other planner sent no command";
}

TEST_F(JudgeCheckpoint, IsValidWhenBothPlannersEndedTogether) {
  EXPECT_EQ(judge(others_, others_, std::nullopt), CheckpointValidity::kUndecided);
  EXPECT_EQ(judge(others_, others_, command(4, -20ms)), CheckpointValidity::kValid);
  EXPECT_EQ(judge(others_, others_, command(4, kSimultaneousLoss)), CheckpointValidity::kValid);
  EXPECT_EQ(judge(others_, others_, command(4, kSimultaneousLoss + 1ms)), CheckpointValidity::kOutdated)
      << "the other planner continued";
  const ArmLease ours_now{"p", 6};
  EXPECT_EQ(judge(others_, ours_now, command(4, 10ms)), CheckpointValidity::kValid);
  EXPECT_EQ(judge(others_, ours_now, command(4, 400ms)), CheckpointValidity::kOutdated);
}

TEST_F(JudgeCheckpoint, IsOutdatedWhenTheDriverHasNoCommand) {
  EXPECT_EQ(judge(others_, others_, command(0, -20ms)), CheckpointValidity::kOutdated);
}

class ActionFor : public ::testing::Test {
 protected:
  static msg::GoalStatus status_of(msg::GoalState state, std::uint64_t term) {
    msg::GoalStatus message = status("a", state);
    message.term(term);
    return message;
  }
  FailoverRole role_{"p", true};
};

TEST_F(ActionFor, DefersUntilTheRoleIsKnown) {
  EXPECT_EQ(action_for(status_of(msg::GoalState::GOAL_REACHED, 4), role_, true), StatusAction::kDefer);
  role_.update({"q", 4});
  EXPECT_EQ(action_for(status_of(msg::GoalState::GOAL_REACHED, 4), role_, false), StatusAction::kDefer)
      << "the checkpoint comes first";
  EXPECT_EQ(action_for(status_of(msg::GoalState::GOAL_REACHED, 4), role_, true), StatusAction::kApply);
}

TEST_F(ActionFor, AppliesStatusesOfThePlannerInChargeAndFinalOnes) {
  role_.update({"q", 4});
  EXPECT_EQ(action_for(status_of(msg::GoalState::GOAL_ACTIVE, 4), role_, true), StatusAction::kApply);
  EXPECT_EQ(action_for(status_of(msg::GoalState::GOAL_ACTIVE, 5), role_, true), StatusAction::kApply)
      << "a newer lease";
  EXPECT_EQ(action_for(status_of(msg::GoalState::GOAL_ACTIVE, 2), role_, true), StatusAction::kIgnore)
      << "the last status of an earlier term";
  EXPECT_EQ(action_for(status_of(msg::GoalState::GOAL_CANCELLED, 2), role_, true), StatusAction::kApply);
}

TEST_F(ActionFor, DefersStatusesOfALaterTermWhenInCharge) {
  role_.update({"p", 4});
  EXPECT_EQ(action_for(status_of(msg::GoalState::GOAL_REACHED, 3), role_, true), StatusAction::kIgnore);
  EXPECT_EQ(action_for(status_of(msg::GoalState::GOAL_REACHED, 6), role_, true), StatusAction::kDefer);
}

class GoalCheckpointTest : public ::testing::Test {
 protected:
  ~GoalCheckpointTest() override { std::filesystem::remove(path_); }

  static void expect_same(const std::optional<GoalCheckpoint::Saved>& got, const GoalCheckpoint::Saved& wanted) {
    ASSERT_TRUE(got);
    EXPECT_TRUE(got->snapshot == wanted.snapshot);
    EXPECT_EQ(got->lease, wanted.lease);
    EXPECT_EQ(got->stamp_ns, wanted.stamp_ns);
    EXPECT_EQ(got->until_ns, wanted.until_ns);
  }

  const std::string path_ =
      (std::filesystem::temp_directory_path() / ("hecaton_goals_" + std::to_string(getpid()))).string();
  const planner::JointVector q_ = (planner::JointVector(3) << 0.1, -0.2, 0.3).finished();
  const planner::ToolGoal tool_{.X_WT = world::pose_from_xyz_rpy({0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}),
                                .free_rotation = planner::FreeRotation::kYaw,
                                .position_tolerance = 0.005};
  const GoalCheckpoint::Saved busy_{{GoalSnapshot::Active{"g2", "cli/a-1", 17, 30.0, 1.5, q_, tool_},
                                     {{"g0", msg::GoalState::GOAL_CANCELLED}, {"g1", msg::GoalState::GOAL_REPLACED}},
                                     {5, 6, 7}},
                                    {"planner/arm1@beta", 7},
                                    123456789,
                                    123456800};
  const GoalCheckpoint::Saved idle_{
      {std::nullopt, {{"g2", msg::GoalState::GOAL_REACHED}}, {5, 6, 7, 8}}, {"", 8}, 200000000, 200000000};
};

TEST_F(GoalCheckpointTest, IsEmptyWhenNew) {
  EXPECT_FALSE(GoalCheckpoint(path_, 3).load());
}

TEST_F(GoalCheckpointTest, SavesNothingWithoutAFile) {
  GoalCheckpoint checkpoint("", 3);
  checkpoint.save(busy_);
  EXPECT_FALSE(checkpoint.load());
}

TEST_F(GoalCheckpointTest, LoadsTheLastSave) {
  GoalCheckpoint checkpoint(path_, 3);
  for (int i = 0; i < 3; ++i) {
    checkpoint.save(busy_);
    expect_same(checkpoint.load(), busy_);
    checkpoint.save(idle_);
    expect_same(checkpoint.load(), idle_);
  }
}

TEST_F(GoalCheckpointTest, SurvivesSigkill) {
  const pid_t child = fork();
  if (child == 0) {
    GoalCheckpoint checkpoint(path_, 3);
    checkpoint.save(idle_);
    checkpoint.save(busy_);
    std::raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  GoalCheckpoint successor(path_, 3);
  expect_same(successor.load(), busy_);
  successor.save(idle_);
  expect_same(successor.load(), idle_);
}

TEST_F(GoalCheckpointTest, ConfirmsTheLastSave) {
  GoalCheckpoint checkpoint(path_, 3);
  checkpoint.confirm(1);
  EXPECT_FALSE(checkpoint.load()) << "nothing was saved";
  checkpoint.save(busy_);
  checkpoint.confirm(123457000);
  GoalCheckpoint::Saved confirmed = busy_;
  confirmed.until_ns = 123457000;
  expect_same(checkpoint.load(), confirmed);
  checkpoint.save(idle_);
  expect_same(checkpoint.load(), idle_);
  GoalCheckpoint successor(path_, 3);
  successor.confirm(200000005);
  EXPECT_EQ(successor.load()->until_ns, 200000005);
}

TEST_F(GoalCheckpointTest, KeepsTheLongestNamesAndLists) {
  GoalCheckpoint::Saved longest = busy_;
  longest.snapshot.active->goal = std::string(GoalSnapshot::kLongestName, 'g');
  longest.snapshot.active->client = std::string(GoalSnapshot::kLongestName, 'c');
  longest.snapshot.results[0].goal = std::string(GoalSnapshot::kLongestName, 'e');
  longest.snapshot.handled.assign(GoalSnapshot::kHandled, 7);
  GoalCheckpoint checkpoint(path_, 3);
  checkpoint.save(longest);
  expect_same(checkpoint.load(), longest);
}

TEST_F(GoalCheckpointTest, RejectsTheFileOfAnotherArm) {
  GoalCheckpoint(path_, 3).save(busy_);
  EXPECT_FALSE(GoalCheckpoint(path_, 4).load());
}

}  // namespace
}  // namespace hecaton::services
