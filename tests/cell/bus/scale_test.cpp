// Discovery among many processes on one host, by multicast and by unicast peers.
#include <fstream>
#include <memory>

#include <idl/health.h>

#include "tests/cell/bus/peer_process.hpp"
#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::bus {
namespace {

double resident_mb(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/statm");
  double total = 0;
  double resident = 0;
  status >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

// By default Fast DDS tries only the first four participants of a unicast peer.
class Scale : public testing::TestWithParam<bool> {};

TEST_P(Scale, MatchesThirtySixProcessesOnOneHost) {
  const bool unicast = GetParam();
  const test::FreeDomain domain;
  constexpr int kProcesses = 36;
  std::vector<std::unique_ptr<PeerProcess>> peers;
  peers.reserve(kProcesses);
  const auto start = Clock::now();
  for (int i = 0; i < kProcesses; ++i) {
    peers.push_back(std::make_unique<PeerProcess>("heartbeat", domain.number(), "n" + std::to_string(i),
                                                  PeerOptions{.unicast = unicast}));
  }
  for (const auto& peer : peers) ASSERT_EQ(peer->line(), "ready");
  const auto ready = Clock::now();
  // It joins last, so that its number on this host is the highest.
  auto options = one_host();
  if (unicast) options.peers = {{"127.0.0.1"}};
  Participant here(domain.number(), "here", options);
  Reader<msg::Heartbeat> reader(here);
  ASSERT_TRUE(reader.wait_matched(kProcesses, kPatience)) << reader.matched();
  ASSERT_TRUE(wait_until(reader, [&] { return reader.latest().size() == kProcesses; })) << reader.latest().size();
  const auto ms = [](Clock::duration d) { return std::chrono::duration<double, std::milli>(d).count(); };
  std::printf("%d processes ready after %.0f ms, all received %.0f ms later; resident %.1f MB each\n", kProcesses,
              ms(ready - start), ms(Clock::now() - ready), resident_mb(peers[0]->pid()));
}

INSTANTIATE_TEST_SUITE_P(Discovery, Scale, testing::Values(false, true),
                         [](const auto& discovery) { return discovery.param ? "Unicast" : "Multicast"; });

// Participants with this lease announce themselves every 12 s, so a process that misses the answers to its first
// announcements is late. Without DatagramFilter one start in five was.
TEST(Match, GivesANewProcessTheStateOfAnother) {
  constexpr PeerOptions kRarelyAnnounced{.lease_ms = 120'000};
  const test::FreeDomain domain;
  PeerProcess agent("process", domain.number(), "host1", kRarelyAnnounced);
  ASSERT_EQ(agent.line(), "ready");
  for (int round = 0; round < 20; ++round) {
    PeerProcess newcomer("measure", domain.number(), "newcomer", kRarelyAnnounced);
    const auto taken = newcomer.line();
    ASSERT_FALSE(taken.empty());
    std::printf("from start to 30 keys: %s ms\n", taken.c_str());
    EXPECT_LT(std::stod(taken), 20'000.0) << "it gave up in round " << round;
  }
}

}  // namespace
}  // namespace hecaton::bus
