#include "services/security/keystore.hpp"

#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/temporary_folder.hpp"

namespace hecaton::services {
namespace {

using std::chrono::days;
namespace fs = std::filesystem;

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const KeystoreError& error) {
    return error.what();
  }
  return "done";
}

class Keystore : public testing::Test {
 protected:
  void SetUp() override { create_keystore(keystore_, days(100)); }
  [[nodiscard]] std::string use(const std::string& host, Role role) const {
    return refusal([&] { require_identity(enclave_folder(keystore_, host, role)); });
  }

  test::TemporaryFolder folder_;
  fs::path keystore_ = fs::path(folder_.path()) / "keys";
};

TEST_F(Keystore, MakesAUsableIdentityOfEachRole) {
  add_host(keystore_, "north-pc", days(10));
  add_host(keystore_, "south-pc", days(10));
  const auto all = identities_in(keystore_);
  ASSERT_EQ(all.size(), 2 * kRoles.size());
  for (const IdentityState& one : all) {
    EXPECT_EQ(one.problem, std::nullopt) << one.host << " " << one.role;
    const auto left = one.expires - std::chrono::system_clock::now();
    EXPECT_GT(left, days(9));
    EXPECT_LE(left, days(10));
  }
  EXPECT_EQ(all.front().host, "north-pc");
  EXPECT_EQ(all.front().role, "agent");
}

TEST_F(Keystore, KeepsKeysForTheirOwner) {
  add_host(keystore_, "north-pc", days(10));
  for (const auto& entry : fs::recursive_directory_iterator(keystore_)) {
    const auto others = fs::perms::group_all | fs::perms::others_all;
    EXPECT_EQ(entry.status().permissions() & others, fs::perms::none) << entry.path();
  }
}

TEST_F(Keystore, RefusesKeysThatCannotBeUsed) {
  EXPECT_NE(use("north-pc", Role::kWorld).find("is missing, empty or not readable"), std::string::npos);
  add_host(keystore_, "north-pc", days(10));
  EXPECT_EQ(use("north-pc", Role::kWorld), "done");
  const fs::path world = enclave_folder(keystore_, "north-pc", Role::kWorld);
  fs::copy_file(enclave_folder(keystore_, "north-pc", Role::kDriver) / "key.pem", world / "key.pem",
                fs::copy_options::overwrite_existing);
  EXPECT_NE(use("north-pc", Role::kWorld).find("key.pem: is not the key of cert.pem"), std::string::npos);

  const fs::path other = fs::path(folder_.path()) / "other";
  create_keystore(other, days(100));
  fs::copy_file(other / "public" / "ca.cert.pem",
                enclave_folder(keystore_, "north-pc", Role::kPlanner) / "identity_ca.cert.pem",
                fs::copy_options::overwrite_existing);
  EXPECT_NE(use("north-pc", Role::kPlanner).find("cert.pem: is not signed by"), std::string::npos);

  std::ofstream(enclave_folder(keystore_, "north-pc", Role::kAgent) / "cert.pem") << "nonsense";
  EXPECT_NE(use("north-pc", Role::kAgent).find("cert.pem: is no certificate"), std::string::npos);
}

TEST_F(Keystore, RefusesExpiredIdentities) {
  add_host(keystore_, "north-pc", days(0));
  EXPECT_NE(use("north-pc", Role::kWorld).find("cert.pem: has expired on "), std::string::npos);
  add_host(keystore_, "north-pc", days(1));
  EXPECT_EQ(use("north-pc", Role::kWorld), "done") << "new identities replace them";
  EXPECT_NE(refusal([&] { add_host(keystore_, "south-pc", days(101)); }).find("expires before"), std::string::npos);
}

TEST_F(Keystore, RefusesBadFoldersAndNames) {
  EXPECT_NE(refusal([&] { create_keystore(keystore_, days(1)); }).find("exists and is not empty"), std::string::npos);
  for (const std::string name : {"", "..", "a/b", "a b", "a,CN=b"}) {
    EXPECT_NE(refusal([&] { add_host(keystore_, name, days(1)); }).find("the name of a host has"), std::string::npos)
        << name;
  }
  EXPECT_NE(refusal([&] { add_host(folder_.path(), "north-pc", days(1)); }).find("ca.cert.pem: is missing"),
            std::string::npos);
  EXPECT_NE(refusal([&] { static_cast<void>(identities_in(folder_.path())); }).find("is this a keystore?"),
            std::string::npos);
}

// These repeat the design: a change of the table of topics that lets another role move an arm is deliberate.
TEST(Permissions, LetOnlyPlannersCommandAndOnlySupervisorsSetTheMode) {
  const auto publishes = [](Role role, const std::string& topic) {
    const std::string xml = permissions_xml(role, "CN=/host/role", {}, {});
    const auto begin = xml.find("<publish>");
    return begin != std::string::npos &&
           xml.substr(begin, xml.find("</publish>") - begin).find("<topic>hecaton/" + topic + "</topic>") !=
               std::string::npos;
  };
  for (const Role role : kRoles) {
    EXPECT_EQ(publishes(role, "ArmCommand"), role == Role::kPlanner) << role_name(role);
    EXPECT_EQ(publishes(role, "CellMode"), role == Role::kSupervisor) << role_name(role);
    EXPECT_EQ(publishes(role, "ArmState"), role == Role::kDriver) << role_name(role);
    EXPECT_EQ(publishes(role, "Goal"), role == Role::kOperator) << role_name(role);
    EXPECT_EQ(publishes(role, "WorldEditRequest"), role == Role::kOperator) << role_name(role);
    EXPECT_TRUE(publishes(role, "Heartbeat")) << role_name(role);
  }
}

}  // namespace
}  // namespace hecaton::services
