// What a later hold or stop does to orders that wait or are under way.
#include "services/client/mode_orders.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace hecaton::client {
namespace {

constexpr auto kPatience = std::chrono::seconds(60);

/// A supervisor that answers when it is let.
class Supervisor {
 public:
  Receipt receive(ModeOrder order, const ModeOrders::Arms& arms, const std::stop_token& interrupted) {
    static const std::map<ModeOrder, std::string> kNames{
        {ModeOrder::kStop, "stop"}, {ModeOrder::kHold, "hold"}, {ModeOrder::kResume, "resume"}};
    std::string line = kNames.at(order);
    for (const std::string& arm : arms) line += " " + arm;
    std::unique_lock lock(mutex_);
    received_.push_back(line);
    changed_.notify_all();
    changed_.wait(lock, interrupted, [&] { return answers_; });
    if (!answers_) throw std::runtime_error("interrupted");
    return {};
  }
  void answer(bool answers) {
    const std::scoped_lock lock(mutex_);
    answers_ = answers;
    changed_.notify_all();
  }
  bool has_received(std::size_t count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return received_.size() >= count; });
  }
  std::vector<std::string> received() {
    const std::scoped_lock lock(mutex_);
    return received_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<std::string> received_;
  bool answers_ = false;
};

class ModeOrdersTest : public testing::Test {
 protected:
  /// Gives the order; its outcome is a line of outcomes(): "NAME" when it was carried out, otherwise "NAME: why not".
  void give(const std::string& name, ModeOrder order, const ModeOrders::Arms& arms, std::uint64_t giver = 1) {
    orders_->give(order, arms, giver, [this, name](const ModeOutcome& outcome) {
      const std::scoped_lock lock(mutex_);
      outcomes_.push_back(outcome.done ? name : name + ": " + outcome.text.substr(0, outcome.text.find(':')));
      told_.notify_all();
    });
  }
  std::vector<std::string> outcomes(std::size_t count) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(told_.wait_for(lock, kPatience, [&] { return outcomes_.size() >= count; })) << "of " << count;
    return outcomes_;
  }

  Supervisor supervisor_;
  std::mutex mutex_;
  std::condition_variable told_;
  std::vector<std::string> outcomes_;
  std::optional<ModeOrders> orders_{std::in_place,
                                    [this](ModeOrder order, const ModeOrders::Arms& arms, const std::stop_token& stop) {
                                      return supervisor_.receive(order, arms, stop);
                                    }};
};

using Lines = std::vector<std::string>;

TEST_F(ModeOrdersTest, AStopWithdrawsTheResumesOfItsArmsThatWait) {
  give("hold", ModeOrder::kHold, {"north"});
  ASSERT_TRUE(supervisor_.has_received(1));
  give("resume north", ModeOrder::kResume, {"north"});  // waits for the hold
  give("resume west", ModeOrder::kResume, {"west"});
  give("stop", ModeOrder::kStop, {"north", "east"});
  EXPECT_EQ(outcomes(1), Lines{"resume north: not carried out"});
  ASSERT_TRUE(supervisor_.has_received(2)) << "the stop does not wait for the hold";
  supervisor_.answer(true);
  ASSERT_EQ(outcomes(4).back(), "resume west");
  EXPECT_EQ(supervisor_.received(), (Lines{"hold north", "stop east north", "resume west"}));
}

TEST_F(ModeOrdersTest, AStopInterruptsAResumeUnderWay) {
  give("resume", ModeOrder::kResume, {});
  ASSERT_TRUE(supervisor_.has_received(1));
  give("stop", ModeOrder::kStop, {"north"});
  EXPECT_EQ(outcomes(1), Lines{"resume: not carried out"}) << "a repetition of the request could follow the stop";
  ASSERT_TRUE(supervisor_.has_received(2));
  supervisor_.answer(true);
  EXPECT_EQ(outcomes(2).back(), "stop");
}

TEST_F(ModeOrdersTest, AHoldOfAnotherArmLetsAResumeGoOn) {
  give("resume", ModeOrder::kResume, {"west"});
  ASSERT_TRUE(supervisor_.has_received(1));
  give("hold", ModeOrder::kHold, {"north"});
  ASSERT_TRUE(supervisor_.has_received(2));
  supervisor_.answer(true);
  const Lines all = outcomes(2);
  EXPECT_EQ(std::count(all.begin(), all.end(), "resume"), 1);
}

TEST_F(ModeOrdersTest, AResumeFollowsTheHoldThatWasGivenBeforeIt) {
  give("hold", ModeOrder::kHold, {});
  give("resume", ModeOrder::kResume, {});
  ASSERT_TRUE(supervisor_.has_received(1));
  supervisor_.answer(true);
  EXPECT_EQ(outcomes(2), (Lines{"hold", "resume"}));
  EXPECT_EQ(supervisor_.received(), (Lines{"hold", "resume"}));
}

// No number of stops of arms delays the stop of the cell or refuses it.
TEST_F(ModeOrdersTest, StopsThatWaitAreSentAsOne) {
  give("first", ModeOrder::kStop, {"north"});
  ASSERT_TRUE(supervisor_.has_received(1));
  for (int i = 0; i < 400; ++i) give("stop", ModeOrder::kStop, {i % 2 == 0 ? "west" : "east"});
  give("cell", ModeOrder::kStop, {});
  supervisor_.answer(true);
  const Lines all = outcomes(402);
  EXPECT_EQ(std::count(all.begin(), all.end(), "stop"), static_cast<long>(ModeOrders::kMostAnswers));
  EXPECT_EQ(supervisor_.received(), (Lines{"stop north", "stop"}));
}

TEST_F(ModeOrdersTest, ResumesOfAGiverThatIsGoneAreWithdrawn) {
  give("hold", ModeOrder::kHold, {"north"});
  ASSERT_TRUE(supervisor_.has_received(1));
  give("resume of 1", ModeOrder::kResume, {"north"}, 1);
  give("resume of 2", ModeOrder::kResume, {"north"}, 2);
  orders_->withdraw(1);
  EXPECT_EQ(outcomes(1), Lines{"resume of 1: not carried out"});
  supervisor_.answer(true);
  EXPECT_EQ(outcomes(3).back(), "resume of 2");
}

TEST_F(ModeOrdersTest, TellEachOrderWhenTheyEnd) {
  give("hold", ModeOrder::kHold, {"north"});
  ASSERT_TRUE(supervisor_.has_received(1));
  give("resume", ModeOrder::kResume, {"north"});
  orders_.reset();
  Lines all = outcomes(2);
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, (Lines{"hold: interrupted", "resume: not carried out"}));
}

}  // namespace
}  // namespace hecaton::client
