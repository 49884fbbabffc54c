#include "services/bus/topics.hpp"

#include <set>

#include <gtest/gtest.h>
#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>

namespace hecaton::bus {
namespace {

TEST(Topics, HaveUniqueNames) {
  std::set<std::string_view> names;
  for (const auto& topic : kTopics) {
    EXPECT_TRUE(names.insert(topic.name).second) << topic.name;
    EXPECT_EQ(topic.name, "hecaton/" + std::string(topic.type));
    EXPECT_FALSE(topic.writers.empty()) << topic.name;
    EXPECT_FALSE(topic.readers.empty()) << topic.name;
  }
  EXPECT_EQ(names.size(), 28U);
}

// These tests repeat the design, so that a change of the table is deliberate.
TEST(Topics, SendStateBestEffortWithoutHistory) {
  for (const auto& qos : {Topic<msg::ArmState>::kInfo.qos, Topic<msg::ObstacleStates>::kInfo.qos}) {
    EXPECT_FALSE(qos.reliable);
    EXPECT_FALSE(qos.transient_local);
    EXPECT_EQ(qos.depth, 1);
    EXPECT_GT(qos.deadline, 0ms);
  }
}

TEST(Topics, SendCommandsReliablyFromAllWriters) {
  const auto qos = Topic<msg::ArmCommand>::kInfo.qos;
  EXPECT_TRUE(qos.reliable);
  EXPECT_EQ(qos.depth, 1);
  EXPECT_LE(qos.heartbeat, 5ms);
}

TEST(Topics, AreTransientLocalWhereLateJoinersNeedThem) {
  for (const auto& qos :
       {Topic<msg::ObstacleShapes>::kInfo.qos, Topic<msg::Goal>::kInfo.qos, Topic<msg::GoalStatus>::kInfo.qos,
        Topic<msg::ProcessEvent>::kInfo.qos, Topic<msg::Fault>::kInfo.qos}) {
    EXPECT_TRUE(qos.reliable);
    EXPECT_TRUE(qos.transient_local);
  }
}

TEST(Topics, DoNotReplayRequestsToLateServices) {
  EXPECT_FALSE(Topic<msg::WorldEditRequest>::kInfo.qos.transient_local);
  EXPECT_FALSE(Topic<msg::SupervisorRequest>::kInfo.qos.transient_local);
  EXPECT_FALSE(Topic<msg::RecorderRequest>::kInfo.qos.transient_local);
}

TEST(Topics, HaveRoomForManyKeys) {
  for (const auto& topic : kTopics) EXPECT_GE(topic.qos.instances, 512) << topic.name;
}

TEST(Topics, TakeKeysFromSamples) {
  msg::ArmState state;
  state.arm("arm1");
  EXPECT_EQ(key_of(state), "arm1");
  msg::Goal goal;
  goal.arm("arm1");
  goal.goal("g7");
  EXPECT_EQ(key_of(goal), "arm1/g7");
  EXPECT_EQ(key_of(msg::CellMode()), "");
}

TEST(Topics, PutTheSchemaIntoNewMessages) {
  EXPECT_EQ(msg::ArmState().schema(), msg::SCHEMA_VERSION);
  EXPECT_EQ(msg::Goal().schema(), msg::SCHEMA_VERSION);
  EXPECT_EQ(msg::Heartbeat().schema(), msg::SCHEMA_VERSION);
}

}  // namespace
}  // namespace hecaton::bus
