// The machines to which processes of a cell announce themselves, and their keys.
#include "services/runtime/join.hpp"

#include <chrono>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "services/security/keystore.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::services {
namespace {

/// Participants of clients on every machine.
constexpr int kSpare = 8;

/// The number of participants by address.
std::map<std::string, int> peers(const std::string& network, const std::string& hosts,
                                 const std::vector<std::string>& interfaces = {}) {
  const std::string text = "name: cell\nnetwork: " + network + "\nhosts: " + hosts +
                           "\nworld: {host: b}\nsupervision: {host: b, standby_host: a}\n"
                           "defaults: {urdf: urdf/planar_2r.urdf, poses: {home: [0, 1]}}\n"
                           "arms: [{name: left, host: a, standby_host: b},"
                           " {name: right, host: a, base: {xyz: [9, 0, 0]}}]\n";
  const auto file = config::parse_cell_file(text, std::string(HECATON_SOURCE_DIR) + "/tests/data/bad/inline.yaml");
  std::map<std::string, int> found;
  for (const bus::Peer& peer : peers_of(file, interfaces)) {
    EXPECT_TRUE(found.emplace(peer.address, peer.participants).second) << "twice: " << peer.address;
  }
  return found;
}

using Peers = std::map<std::string, int>;

TEST(PeersTest, AreEmptyWithMulticast) {
  EXPECT_EQ(peers("{}", "{a: 10.0.0.1, b: 10.0.0.2}"), Peers{});
}

// a: agent, two drivers, two planners, a standby supervisor; b: agent, world, supervisor, a standby planner.
TEST(PeersTest, AreTheHostsAndThisMachineWithUnicast) {
  EXPECT_EQ(peers("{discovery: unicast}", "{a: 10.0.0.1, b: 10.0.0.2}"),
            (Peers{{"10.0.0.1", 6 + kSpare}, {"10.0.0.2", 4 + kSpare}, {"127.0.0.1", 10 + kSpare}}));
}

TEST(PeersTest, IncludeThisMachinesInterface) {
  EXPECT_EQ(peers("{discovery: unicast, interface: 10.0.0.2}", "{a: 10.0.0.1, b: 10.0.0.2}", {"10.0.0.2"}),
            (Peers{{"10.0.0.1", 6 + kSpare}, {"10.0.0.2", 10 + kSpare}}));
}

TEST(PeersTest, AddUpHostsOnOneMachine) {
  EXPECT_EQ(peers("{discovery: unicast}", "{a: 10.0.0.1, b: 10.0.0.1}"),
            (Peers{{"10.0.0.1", 10 + kSpare}, {"127.0.0.1", 10 + kSpare}}));
}

TEST(PeersTest, IncludeFurtherMachines) {
  EXPECT_EQ(
      peers("{peers: [10.0.0.9]}", "{a: 10.0.0.1, b: 10.0.0.2}"),
      (Peers{
          {"10.0.0.1", 6 + kSpare}, {"10.0.0.2", 4 + kSpare}, {"10.0.0.9", 10 + kSpare}, {"127.0.0.1", 10 + kSpare}}));
}

TEST(PeersTest, LeaveOutNamesThatCannotBeResolved) {
  EXPECT_EQ(peers("{discovery: unicast}", "{a: localhost, b: cell-b.invalid}"), (Peers{{"127.0.0.1", 10 + kSpare}}));
}

TEST(IdentityTest, MissingOneIsNamedWithTheCommandThatMakesIt) {
  const test::TemporaryFolder folder;
  const std::string keys = folder.path("keys");
  const auto file = config::parse_cell_file(
      "name: cell\nhosts: {a: 10.0.0.1}\nsecurity: {keystore: " + keys +
          "}\ndefaults: {urdf: urdf/planar_2r.urdf, poses: {home: [0, 1]}}\narms: [{name: left}]\n",
      std::string(HECATON_SOURCE_DIR) + "/tests/data/bad/inline.yaml");
  create_keystore(keys, std::chrono::days(10));
  add_identities(keys, "a", std::chrono::days(1), {{Role::kWorld, {}}});
  const auto problem = [&](const std::string& host, Role role) -> std::string {
    try {
      static_cast<void>(identity_of(file, host, role));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(identity_of(file, "a", Role::kWorld), enclave_folder(keys, "a", Role::kWorld));
  EXPECT_EQ(identity_of(file, "", Role::kWorld), enclave_folder(keys, "a", Role::kWorld));
  const std::string none = file.path + ": security.keystore = " + keys + " has no identity of the role ";
  const auto advice = [&](const std::string& host) {
    return "; make it with `hecaton keystore add DIR " + host + " --for " + file.path +
           "` where the private key of the authority is, and copy DIR/enclaves/" + host + " to this machine";
  };
  EXPECT_EQ(problem("a", Role::kDriver), none + "driver for host a" + advice("a"));
  EXPECT_EQ(problem("", Role::kOperator), none + "operator" + advice("people"));
  EXPECT_EQ(problem("", Role::kPlanner), none + "planner" + advice("HOST"));

  // An identity that lacks a file gives the name of the file.
  std::filesystem::remove(enclave_folder(keys, "a", Role::kWorld) / "key.pem");
  EXPECT_NE(problem("a", Role::kWorld).find("key.pem"), std::string::npos);
}

}  // namespace
}  // namespace hecaton::services
