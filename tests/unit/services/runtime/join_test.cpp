// The machines to which processes of a cell announce themselves.
#include "services/runtime/join.hpp"

#include <map>
#include <string>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace hecaton::services
