#include "services/runtime/cause.hpp"

#include <set>

#include <gtest/gtest.h>

#include "services/config/schema.hpp"

namespace hecaton::services {
namespace {

TEST(Cause, HasAUniqueNameForEachKind) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kCauseNames.size(); ++i) {
    const auto kind = static_cast<msg::CauseKind>(i);
    EXPECT_TRUE(names.insert(cause_name(kind)).second) << cause_name(kind);
    EXPECT_EQ(cause_kind(cause_name(kind)), kind);
  }
  EXPECT_EQ(cause_name(msg::CauseKind::CAUSE_HOST_LOST), "host_lost");
  EXPECT_EQ(cause_name(msg::CauseKind::CAUSE_PATH_BLOCKED), "path_blocked");
  EXPECT_EQ(cause_name(msg::CauseKind::CAUSE_NOT_PERSISTED), "not_persisted");
}

TEST(Cause, IsUnknownForAKindOfANewerVersion) {
  EXPECT_EQ(cause_name(static_cast<msg::CauseKind>(kCauseNames.size())), "unknown");
  EXPECT_EQ(cause_kind("no_such_kind"), std::nullopt);
}

TEST(Cause, KnowsItsSection) {
  EXPECT_FALSE(is_fault(msg::CauseKind::CAUSE_DEVICE_FAILED));
  EXPECT_TRUE(is_fault(msg::CauseKind::CAUSE_DRIVER_SILENT));
  EXPECT_TRUE(is_fault(msg::CauseKind::CAUSE_ARM_FAILED));
  for (const msg::CauseKind kind : kDeviceFaults) EXPECT_TRUE(is_fault(kind) && device_fault(kind) == kind);
  EXPECT_EQ(device_fault(msg::CauseKind::CAUSE_DEVICE_FAILED), msg::CauseKind::CAUSE_ARM_FAILED);
  EXPECT_EQ(device_fault(msg::CauseKind::CAUSE_COMMANDS_CEASED), std::nullopt);
  EXPECT_FALSE(is_fault(msg::CauseKind::CAUSE_NO_GOAL));
  EXPECT_FALSE(is_about_goal(msg::CauseKind::CAUSE_NO_GOAL));
  EXPECT_TRUE(is_about_goal(msg::CauseKind::CAUSE_GOAL_CANCELLED));
  EXPECT_FALSE(is_about_goal(msg::CauseKind::CAUSE_UNKNOWN_NAME));
}

TEST(Cause, NamesFaultsInTheCellFilesRecoveryKeys) {
  for (const std::string_view key : config::section::kRecovery.keys) {
    const auto kind = cause_kind(key);
    EXPECT_TRUE(kind && is_fault(*kind)) << key;
  }
}

}  // namespace
}  // namespace hecaton::services
