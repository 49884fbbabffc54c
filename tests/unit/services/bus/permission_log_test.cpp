#include "services/bus/permission_log.hpp"

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

TEST(PermissionLog, NamesTheParticipantAndTheReason) {
  const auto refused = refused_permissions(
      "Error checking create remote writer 01.0f.aa.00.10.02.03.04.05.06.07.ff|0.0.1.3 (hecaton/ArmCommand topic not "
      "found in allow rule.)");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->sender.text(), "010faa0010020304050607ff00000000");
  EXPECT_EQ(refused->text, "its keys do not allow this writer: hecaton/ArmCommand topic not found in allow rule.");
  EXPECT_EQ(refused->kind, RefusalKind::kMalformed);
  const auto participant = refused_permissions(
      "Error validating remote permissions for 1.f.a.0.1.2.3.4.5.6.7.f|0.0.1.c1 (Error: the issuer (of it) differs "
      "(./src/Permissions.cpp:544)).");
  ASSERT_TRUE(participant);
  EXPECT_EQ(participant->text, "its permissions are not valid: Error: the issuer (of it) differs");
  EXPECT_TRUE(refused_permissions("Error checking remote participant  1.f.a.0.1.2.3.4.5.6.7.f|0.0.1.c1"));
}

TEST(PermissionLog, IgnoresOtherEntries) {
  EXPECT_FALSE(refused_permissions(""));
  EXPECT_FALSE(refused_permissions("Cannot find remote writer 1.f.a.0.1.2.3.4.5.6.7.f|0.0.1.3"));
  EXPECT_FALSE(refused_permissions("Error checking create remote writer "));
  EXPECT_FALSE(refused_permissions("Error checking create remote writer |GUID UNKNOWN| (why)"));
  EXPECT_FALSE(refused_permissions("Error checking create remote writer 01.0f.aa.00"));
  EXPECT_FALSE(
      refused_permissions("Error checking create remote writer 01.0f.aa.00.1000.02.03.04.05.06.07.ff|0.0.1.3"));
}

}  // namespace
}  // namespace hecaton::bus
