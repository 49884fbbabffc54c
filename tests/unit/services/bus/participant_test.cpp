// Participants: joining a domain, discovery, partitions.
#include "services/bus/participant.hpp"

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <idl/arm.h>
#include <idl/health.h>
#include <idl/world.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::bus {
namespace {

std::string refusal(int domain, const ParticipantOptions& options) {
  try {
    const Participant participant(domain, "test", options);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Participant, RefusesBadOptionsWithASentence) {
  EXPECT_EQ(refusal(233, {}), "bus: participant \"test\": domain = 233 must be between 0 and 232");
  EXPECT_EQ(refusal(-1, {}), "bus: participant \"test\": domain = -1 must be between 0 and 232");
  ParticipantOptions options;
  options.interfaces = {"198.51.100.77"};  // reserved for documentation: no host has it
  EXPECT_NE(refusal(1, options).find("\"198.51.100.77\" must be an address of this host: 127.0.0.1"), std::string::npos)
      << refusal(1, options);
  options = {};
  options.peers = {{"cell-controller"}};
  EXPECT_EQ(refusal(1, options), "bus: peers: \"cell-controller\" must be an IPv4 address, e.g. \"10.0.0.2\"");
  options.peers = {{"10.0.0.2", 120}};
  EXPECT_EQ(refusal(1, options), "bus: peers: 10.0.0.2: participants = 120 must be between 1 and 119");
}

TEST(Participant, RefusesADomainWhosePortAnotherProgramHolds) {
  const test::FreeDomain domain;
  const int other = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const int port = 7400 + 250 * domain.number();
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  ASSERT_EQ(::bind(other, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  EXPECT_EQ(
      refusal(domain.number(), one_host()),
      "bus: participant \"test\": UDP port " + std::to_string(port) + " of domain " + std::to_string(domain.number()) +
          " is taken by another program; choose another domain, preferably below 101: the system gives the ports of "
          "higher domains to any program");
  ::close(other);
  EXPECT_EQ(refusal(domain.number(), one_host()), "accepted");
  const Participant first(domain.number(), "first", one_host());
  EXPECT_EQ(refusal(domain.number(), one_host()), "accepted") << "participants share it";
}

// No server runs at these addresses, so clients of them would never discover each other.
TEST(Participant, IgnoresDiscoveryServersOfTheEnvironment) {
  const test::FreeDomain domain;
  const char* const servers = "127.0.0.1:9;127.0.0.1:10";
  ::setenv("ROS_DISCOVERY_SERVER", servers, 1);
  Participant here(domain.number(), "here", one_host());
  EXPECT_EQ(std::getenv("ROS_DISCOVERY_SERVER"), nullptr) << "child processes would become clients";
  Participant there(domain.number(), "there", one_host());
  const Writer<msg::CellMode> writer(here);
  const Reader<msg::CellMode> reader(there);
  EXPECT_TRUE(writer.wait_matched(1, kPatience));
  EXPECT_TRUE(reader.wait_matched(1, kPatience));

  ::setenv("ROS_DISCOVERY_SERVER", servers, 1);
  ::setenv("FASTDDS_ENVIRONMENT_FILE", "servers.json", 1);
  const std::vector<std::string> both{std::string("ROS_DISCOVERY_SERVER=") + servers,
                                      "FASTDDS_ENVIRONMENT_FILE=servers.json"};
  EXPECT_EQ(ignore_discovery_servers(), both);
  EXPECT_TRUE(ignore_discovery_servers().empty());
}

/// Fast DDS's shared-memory segments that this process has mapped.
int mapped_segments() {
  std::ifstream maps("/proc/self/maps");
  int count = 0;
  for (std::string line; std::getline(maps, line);) {
    if (line.find("/dev/shm/fast") != std::string::npos) ++count;
  }
  return count;
}

TEST(Participant, MapsNoSharedMemoryUnlessAskedTo) {
  const test::FreeDomain domain;
  {
    Participant here(domain.number(), "here", one_host());
    Participant there(domain.number(), "there", one_host());
    Writer<msg::ContactReport> writer(here);
    Reader<msg::ContactReport> reader(there);
    ASSERT_TRUE(writer.write({}));
    ASSERT_TRUE(wait_until(reader, [&] { return !reader.latest().empty(); }));
    EXPECT_EQ(mapped_segments(), 0);
  }
  auto options = one_host();
  options.shared_memory = true;
  const Participant with(domain.number(), "with", options);
  EXPECT_GT(mapped_segments(), 0) << "the test detects them";
}

// With the default mask a participant's listener takes the callbacks of readers.
TEST(Participant, LeavesReadersTheirCallbacks) {
  const test::FreeDomain domain;
  Mailbox participants;
  auto options = one_host();
  options.mailbox = &participants;
  Participant here(domain.number(), "here", options);
  auto there = std::make_unique<Participant>(domain.number(), "there", one_host());
  Writer<msg::ContactReport> writer(*there);
  Reader<msg::ContactReport> reader(here);
  ASSERT_TRUE(writer.write({}));
  EXPECT_TRUE(wait_until(reader, [&] { return !reader.latest().empty(); }));

  const auto reported = [&](EventKind kind) {
    const auto until = Clock::now() + kPatience;
    while (Clock::now() < until) {
      for (const auto& event : participants.take_events()) {
        if (event.kind == kind && event.key == "there") return true;
      }
      [[maybe_unused]] const bool arrived = participants.wait(until - Clock::now());
    }
    return false;
  };
  EXPECT_TRUE(reported(EventKind::kParticipantFound));
  { const auto gone = std::move(writer); }
  there.reset();
  EXPECT_TRUE(reported(EventKind::kParticipantLost));
}

TEST(Participant, IgnoresOtherPartitions) {
  const test::FreeDomain domain;
  auto options = one_host();
  options.partition = "cell1";
  Participant one(domain.number(), "one", options);
  Participant two(domain.number(), "two", options);
  options.partition = "cell2";
  Participant other(domain.number(), "other", options);
  Reader<msg::CellMode> reader(one);
  Writer<msg::CellMode> foreign(other);
  Writer<msg::CellMode> own(two);
  ASSERT_TRUE(own.wait_matched(1, kPatience));
  ASSERT_TRUE(reader.wait_matched(1, kPatience));
  EXPECT_EQ(foreign.matched(), 0);
  EXPECT_EQ(reader.matched(), 1);
}

TEST(Participant, FindsUnicastPeersWithoutMulticast) {
  const test::FreeDomain domain;
  auto options = one_host();
  options.peers = {{"127.0.0.1"}};
  Participant here(domain.number(), "here", options);
  Participant there(domain.number(), "there", options);
  Writer<msg::CellMode> writer(here);
  Reader<msg::CellMode> reader(there);
  EXPECT_TRUE(writer.wait_matched(1, kPatience));
  EXPECT_TRUE(reader.wait_matched(1, kPatience));
}

// Fast DDS aborts when a departure is announced in the instant in which it checks a lease. With many departures at
// about that time it aborted in most runs. So the bus ignores announced departures, and leases expire.
class ParticipantsThatLeave : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Participant, ParticipantsThatLeave, testing::Bool(),
                         [](const auto& test) { return test.param ? "Announced" : "Silently"; });

TEST_P(ParticipantsThatLeave, AreDroppedAtTheEndOfTheirLease) {
  const test::FreeDomain domain;
  Mailbox mailbox;
  auto options = one_host();
  options.lease = 500ms;
  options.mailbox = &mailbox;
  const Participant host(domain.number(), "host", options);
  options.mailbox = nullptr;
  options.announce_departure = GetParam();
  constexpr int kGuests = 20;
  std::vector<Participant> guests;
  for (int i = 0; i < kGuests; ++i) guests.emplace_back(domain.number(), "guest", options);
  std::set<EndpointId> here;  // a set: a stall of the machine may drop a guest that comes back
  bool all_came = false;
  Clock::time_point last_left;
  const auto until = Clock::now() + kPatience;
  while (!(guests.empty() && here.empty()) && Clock::now() < until) {
    for (const auto& event : mailbox.take_events()) {
      if (event.kind == EventKind::kParticipantFound) here.insert(event.peer);
      if (event.kind == EventKind::kParticipantLost) here.erase(event.peer);
    }
    all_came = all_came || here.size() == kGuests;
    if (all_came && !guests.empty()) {
      guests.pop_back();
      last_left = Clock::now();
    }
    [[maybe_unused]] const bool arrived = mailbox.wait(std::min<Clock::duration>(until - Clock::now(), 25ms));
  }
  EXPECT_TRUE(all_came);
  EXPECT_TRUE(here.empty());
  EXPECT_GT(Clock::now() - last_left, options.lease / 4) << "a departure was believed";
}

TEST(Participant, ReceivesFromASuccessorOfAParticipantThatLeftUnannounced) {
  const test::FreeDomain domain;
  Participant service(domain.number(), "service", one_host());
  Reader<msg::WorldEditRequest> requests(service);
  auto options = one_host();
  options.announce_departure = false;
  options.lease = std::chrono::minutes(10);  // the service remembers each client for longer than the test lasts
  for (const std::string name : {"first", "second", "third"}) {
    Participant client(domain.number(), name, options);
    Writer<msg::WorldEditRequest> writer(client);
    ASSERT_TRUE(writer.wait_matched(1, kPatience)) << name;
    msg::WorldEditRequest request;
    request.client(name);
    ASSERT_TRUE(writer.write(request));
    std::string heard;
    EXPECT_TRUE(wait_until(requests, [&] {
      for (const auto& sample : requests.take()) heard = sample.value.client();
      return heard == name;
    })) << name;
  }
}

TEST(Participant, LivesAsLongAsItsEndpoints) {
  const test::FreeDomain domain;
  auto participant = std::make_unique<Participant>(domain.number(), "brief", one_host());
  Writer<msg::ArmState> writer(*participant);
  participant.reset();
  msg::ArmState state;
  state.arm("arm1");
  EXPECT_TRUE(writer.write(state));
}

class RemovedEndpoints : public BusTest {};

// Fast DDS 2.9.1 reads the listener of an endpoint twice while it pairs the endpoint with a remote one, and removes it
// in between: the process crashes.
TEST_F(RemovedEndpoints, MayBePairedAtTheSameTime) {
  std::atomic<bool> done = false;
  std::thread remote([&] {
    while (!done) {
      const Writer<msg::ArmState> writer(there_);
      const Reader<msg::ArmCommand> reader(there_);
    }
  });
  for (const auto until = Clock::now() + std::chrono::seconds(3); Clock::now() < until;) {
    const Reader<msg::ArmState> reader(here_);
    const Writer<msg::ArmCommand> writer(here_);
  }
  done = true;
  remote.join();
}

}  // namespace
}  // namespace hecaton::bus
