#include "services/security/keystore.hpp"

#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "services/security/certificate.hpp"
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

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
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

TEST_F(Keystore, RenewsIdentitiesAsAWhole) {
  add_host(keystore_, "north-pc", days(10));
  const fs::path world = enclave_folder(keystore_, "north-pc", Role::kWorld);
  const std::string key = content(world / "key.pem");
  fs::remove_all(enclave_folder(keystore_, "north-pc", Role::kViewer));
  fs::create_directory(world.parent_path() / ".world.new");  // of a run that was interrupted
  std::ofstream(world.parent_path() / ".world.new" / "cert.pem") << "half";

  renew_host(keystore_, "north-pc", days(50));
  EXPECT_EQ(use("north-pc", Role::kWorld), "done");
  EXPECT_NE(content(world / "key.pem"), key);
  EXPECT_GT(expiry_of(world) - std::chrono::system_clock::now(), days(49));
  EXPECT_FALSE(fs::exists(world.parent_path() / ".world.new"));
  EXPECT_FALSE(fs::exists(enclave_folder(keystore_, "north-pc", Role::kViewer))) << "the host has no such identity";
  EXPECT_NE(refusal([&] { renew_host(keystore_, "south-pc", days(1)); }).find("has no identities of host south-pc"),
            std::string::npos);
}

TEST_F(Keystore, KeepsIdentitiesWhenRenewalFails) {
  add_host(keystore_, "north-pc", days(10));
  const fs::path world = enclave_folder(keystore_, "north-pc", Role::kWorld);
  const std::string certificate = content(world / "cert.pem");
  fs::remove(keystore_ / "enclaves" / "governance.p7s");
  EXPECT_NE(refusal([&] { renew_host(keystore_, "north-pc", days(20)); }).find("governance.p7s"), std::string::npos);
  EXPECT_EQ(content(world / "cert.pem"), certificate);
  EXPECT_EQ(use("north-pc", Role::kWorld), "done");
  fs::remove_all(keystore_ / "private");
  EXPECT_NE(refusal([&] { renew_host(keystore_, "north-pc", days(20)); }).find("ca.key.pem"), std::string::npos);
}

TEST_F(Keystore, RefusesExpiredPermissions) {
  add_host(keystore_, "north-pc", days(10));
  const fs::path world = enclave_folder(keystore_, "north-pc", Role::kWorld);
  std::string permissions = content(world / "permissions.p7s");
  const auto at = permissions.find("<not_after>") + std::string("<not_after>").size();
  std::ofstream(world / "permissions.p7s") << permissions.replace(at, 4, "2001");
  EXPECT_NE(use("north-pc", Role::kWorld).find("permissions.p7s: has expired on 2001-"), std::string::npos);
  EXPECT_LT(expiry_of(world), std::chrono::system_clock::now());
}

TEST_F(Keystore, RevokesAllCertificatesOfAHost) {
  add_host(keystore_, "north-pc", days(10));
  add_host(keystore_, "south-pc", days(10));
  const fs::path old = fs::path(folder_.path()) / "old";  // what the host keeps, with the list that it gets
  fs::copy(keystore_, old, fs::copy_options::recursive);
  renew_host(keystore_, "north-pc", days(20));
  const fs::path renewed = fs::path(folder_.path()) / "renewed";
  fs::copy(keystore_, renewed, fs::copy_options::recursive);

  RevocationWatch watch(enclave_folder(old, "south-pc", Role::kWorld));
  EXPECT_TRUE(watch.update().empty());
  revoke_host(keystore_, "north-pc");
  EXPECT_EQ(hosts_in(keystore_), std::vector<std::string>{"south-pc"});
  EXPECT_EQ(use("south-pc", Role::kWorld), "done");
  for (const fs::path& host : {old, renewed}) {
    fs::copy_file(revocations_file(keystore_), revocations_file(host));
    const std::string said = refusal([&] { require_identity(enclave_folder(host, "north-pc", Role::kWorld)); });
    EXPECT_NE(said.find("cert.pem: is revoked"), std::string::npos) << said;
  }
  EXPECT_EQ(std::set(watch.update().begin(), watch.update().end()).size(), kRoles.size());
  EXPECT_EQ(watch.problem(), "");

  revoke_host(keystore_, "south-pc");
  EXPECT_NE(refusal([&] { revoke_host(keystore_, "west-pc"); }).find("has no identities of host west-pc"),
            std::string::npos);
  RevocationWatch both(enclave_folder(old, "south-pc", Role::kWorld));
  fs::copy_file(revocations_file(keystore_), revocations_file(old), fs::copy_options::overwrite_existing);
  EXPECT_EQ(std::set(both.update().begin(), both.update().end()).size(), 2 * kRoles.size());
}

TEST_F(Keystore, GivesARevokedHostAnotherName) {
  add_host(keystore_, "north-pc", days(10));
  revoke_host(keystore_, "north-pc");
  add_host(keystore_, "north-pc", days(10));
  const fs::path world = enclave_folder(keystore_, "north-pc", Role::kWorld);
  EXPECT_EQ(use("north-pc", Role::kWorld), "done");
  EXPECT_NE(content(world / "permissions.xml").find("<subject_name>CN=/north-pc/world/2</subject_name>"),
            std::string::npos);
  renew_host(keystore_, "north-pc", days(10));
  EXPECT_NE(content(world / "permissions.xml").find("CN=/north-pc/world/2<"), std::string::npos);
  RevocationWatch watch(world);
  const auto first = watch.update();
  revoke_host(keystore_, "north-pc");
  add_host(keystore_, "north-pc", days(10));
  EXPECT_EQ(std::set(watch.update().begin(), watch.update().end()).size(), 2 * kRoles.size());
}

TEST_F(Keystore, IgnoresRevocationsOfAnotherAuthority) {
  add_host(keystore_, "north-pc", days(10));
  const fs::path other = fs::path(folder_.path()) / "other";
  create_keystore(other, days(100));
  add_host(other, "north-pc", days(10));
  revoke_host(other, "north-pc");
  fs::copy_file(revocations_file(other), revocations_file(keystore_));
  RevocationWatch watch(enclave_folder(keystore_, "north-pc", Role::kWorld));
  EXPECT_TRUE(watch.update().empty());
  EXPECT_NE(watch.problem().find("crl.pem: is not signed by the authority"), std::string::npos);
  EXPECT_NE(use("north-pc", Role::kWorld).find("crl.pem: is not signed by"), std::string::npos);
  std::ofstream(revocations_file(keystore_)) << "half";
  EXPECT_TRUE(watch.update().empty());
  EXPECT_NE(watch.problem().find("crl.pem: is no list"), std::string::npos);
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
    EXPECT_EQ(publishes(role, "DeviceRequest"), role == Role::kOperator) << role_name(role);
    EXPECT_EQ(publishes(role, "RecorderRequest"), role == Role::kOperator) << role_name(role);
    EXPECT_EQ(publishes(role, "RecorderReply"), role == Role::kViewer) << role_name(role);
    EXPECT_EQ(publishes(role, "ToolState"), role == Role::kDriver) << role_name(role);
    EXPECT_EQ(publishes(role, "Goal"), role == Role::kOperator) << role_name(role);
    EXPECT_EQ(publishes(role, "WorldEditRequest"), role == Role::kOperator) << role_name(role);
    EXPECT_TRUE(publishes(role, "Heartbeat")) << role_name(role);
  }
}

TEST(Permissions, NameTheArmsOfAPlannerAndOfADriver) {
  const std::vector<std::string> arms{"north", "west"};
  for (const Role role : {Role::kPlanner, Role::kDriver}) {
    const std::string xml = permissions_xml(role, "CN=/host/role", {}, {}, arms);
    EXPECT_EQ(arms_in(xml), arms);
    const auto topic = xml.find("<topic>hecaton/ArmCommand</topic>");
    ASSERT_NE(topic, std::string::npos);
    const auto partitions = xml.find("<partitions>", topic);
    EXPECT_EQ(xml.substr(partitions, xml.find("</partitions>", topic) - partitions),
              "<partitions><partition>*/north</partition><partition>*/west</partition>");
    EXPECT_TRUE(arms_in(permissions_xml(role, "CN=/host/role", {}, {})).empty());
  }
  EXPECT_TRUE(arms_in(permissions_xml(Role::kWorld, "CN=/host/role", {}, {}, arms)).empty());
}

TEST_F(Keystore, KeepsTheArmsOfAHostWhenItIsRenewed) {
  add_host(keystore_, "north-pc", days(10), {"north"});
  renew_host(keystore_, "north-pc", days(20));
  for (const IdentityState& one : identities_in(keystore_)) {
    const bool of_arms = one.role == "planner" || one.role == "driver";
    EXPECT_EQ(one.arms, of_arms ? std::vector<std::string>{"north"} : std::vector<std::string>()) << one.role;
  }
  EXPECT_NE(refusal([&] { add_host(keystore_, "north-pc", days(1), {"*"}); }).find("the name of an arm has"),
            std::string::npos);
  EXPECT_NE(refusal([&] { add_host(keystore_, "north-pc", days(1)); }).find("north-pc may command north only"),
            std::string::npos);
}

TEST_F(Keystore, ReplacesNoIdentityByOneForOtherDuties) {
  const std::vector<Duty> first{{Role::kDriver, {"north"}}};
  const std::vector<Duty> more{{Role::kWorld, {}}, {Role::kDriver, {"west"}}};
  add_identities(keystore_, "north-pc", days(10), first);
  const fs::path driver = enclave_folder(keystore_, "north-pc", Role::kDriver);
  const std::string key = content(driver / "key.pem");
  for (const auto& refused : {refusal([&] { require_addable(keystore_, "north-pc", more); }),
                              refusal([&] { add_identities(keystore_, "north-pc", days(10), more); })}) {
    EXPECT_EQ(refused, driver.string() +
                           ": exists already; `hecaton keystore renew` makes new keys for north-pc; for other roles or "
                           "arms, use `hecaton keystore revoke` first");
  }
  EXPECT_EQ(identities_in(keystore_).size(), 1U);
  EXPECT_EQ(content(driver / "key.pem"), key);
  require_addable(keystore_, "south-pc", more);

  revoke_host(keystore_, "north-pc");
  add_identities(keystore_, "north-pc", days(10), more);
  EXPECT_EQ(identities_in(keystore_).size(), 2U);
  EXPECT_EQ(use("north-pc", Role::kDriver), "done");
}

TEST(Permissions, AllDutiesGiveArmsToPlannersAndDriversOnly) {
  const std::vector<std::string> arms{"north"};
  const std::vector<Duty> wanted{{Role::kAgent, {}},    {Role::kSupervisor, {}}, {Role::kWorld, {}},
                                 {Role::kDriver, arms}, {Role::kPlanner, arms},  {Role::kOperator, {}},
                                 {Role::kViewer, {}}};
  EXPECT_EQ(all_duties(arms), wanted);
  for (const Duty& duty : all_duties()) EXPECT_TRUE(duty.arms.empty()) << role_name(duty.role);
}

TEST_F(Keystore, MakesIdentitiesForSomeDutiesAndKeepsTheOthers) {
  add_identities(keystore_, "north-pc", days(10), {{Role::kDriver, {"north"}}, {Role::kPlanner, {"north", "west"}}});
  add_identities(keystore_, "north-pc", days(10), {{Role::kWorld, {}}});
  renew_host(keystore_, "north-pc", days(20));
  std::map<std::string, std::vector<std::string>> arms;
  for (const IdentityState& one : identities_in(keystore_)) {
    EXPECT_FALSE(one.problem) << *one.problem;
    arms[one.role] = one.arms;
  }
  const std::map<std::string, std::vector<std::string>> wanted{
      {"driver", {"north"}}, {"planner", {"north", "west"}}, {"world", {}}};
  EXPECT_EQ(arms, wanted);
  EXPECT_NE(refusal([&] {
              add_identities(keystore_, "north-pc", days(1), {{Role::kDriver, {"a b"}}});
            }).find("the name of an arm has"),
            std::string::npos);
}

/// Takes the lines with `topic` from the permissions of an identity, as a program wrote them that did not know it.
void forget_topic(const fs::path& keystore, const fs::path& enclave, const std::string& topic) {
  std::istringstream lines(pki::read_file(enclave / "permissions.xml"));
  std::string old;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("hecaton/" + topic + "<") == std::string::npos) old += line + "\n";
  }
  const pki::Certificate authority = pki::read_certificate(keystore / "public" / "ca.cert.pem");
  const pki::Key key = pki::read_key(keystore / "private" / "ca.key.pem");
  pki::write_file(enclave / "permissions.xml", old);
  pki::write_signed(enclave / "permissions.p7s", old, authority.get(), key.get());
}

TEST_F(Keystore, SaysThatPermissionsAreOlderThanTheProgramUntilTheyAreRenewed) {
  add_host(keystore_, "north-pc", days(10), {"north"});
  const fs::path viewer = enclave_folder(keystore_, "north-pc", Role::kViewer);
  const fs::path planner = enclave_folder(keystore_, "north-pc", Role::kPlanner);
  for (const IdentityState& one : identities_in(keystore_)) EXPECT_FALSE(one.outdated) << *one.outdated;
  forget_topic(keystore_, viewer, "RecorderReply");
  forget_topic(keystore_, planner, "PlannedMotion");
  forget_topic(keystore_, planner, "PlannerTick");
  EXPECT_EQ(outdated_permissions(viewer),
            "permissions are older than this program: the identity may not read hecaton/RecorderReply and 1 more; "
            "`hecaton keystore renew` makes new ones");
  EXPECT_NE(outdated_permissions(planner).value().find("may not write hecaton/PlannedMotion and 1 more"),
            std::string::npos);
  EXPECT_EQ(use("north-pc", Role::kViewer), "done") << "it can be used for all else";
  for (const IdentityState& one : identities_in(keystore_)) {
    EXPECT_EQ(one.outdated.has_value(), one.role == "viewer" || one.role == "planner") << one.role;
    EXPECT_FALSE(one.problem) << *one.problem;
  }
  renew_host(keystore_, "north-pc", days(10));
  for (const IdentityState& one : identities_in(keystore_)) EXPECT_FALSE(one.outdated) << *one.outdated;
  EXPECT_NE(pki::read_file(viewer / "permissions.p7s").find("hecaton/RecorderReply"), std::string::npos);
}

}  // namespace
}  // namespace hecaton::services
