// A step of the wall clock must neither lose samples that wait for a repeated one nor stop the process
// (source_time.hpp).
#include <atomic>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include <idl/health.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "services/bus/source_time.hpp"
#include "tests/unit/services/bus/bus_test.hpp"

namespace {

std::atomic<std::time_t> wall_offset = 0;  // [s]

}  // namespace

/// Replaces the clocks of this process, also for its libraries.
extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const auto result = static_cast<int>(syscall(SYS_clock_gettime, clock, time));
  if (clock == CLOCK_REALTIME) time->tv_sec += wall_offset;
  return result;
}

namespace hecaton::bus {
namespace {

TEST(ClockStep, AffectsThisProcess) {
  const auto before = std::chrono::system_clock::now();
  wall_offset = -86400;
  EXPECT_LT(std::chrono::system_clock::now(), before);
  wall_offset = 0;
}

TEST(ClockStep, LeavesSourceTimesMonotonicAndNearTheWallClock) {
  const auto begin = source_time();
  wall_offset = -86400;
  EXPECT_GE(source_time(), begin);
  wall_offset = 0;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  EXPECT_LT(std::chrono::abs(now - source_time()), std::chrono::hours(1));
}

/// The links of four writers are lossy, so that samples wait for repeated ones in the reader's history.
TEST(ClockStep, LosesNoSampleOnLossyLinks) {
  const test::FreeDomain domain;
  Participant there(domain.number(), "there", one_host());
  Reader<msg::Fault> reader(there);
  std::vector<std::unique_ptr<Participant>> hosts;
  std::vector<std::unique_ptr<Writer<msg::Fault>>> writers;
  for (int i = 0; i < 4; ++i) {
    auto lossy = one_host();
    lossy.discard = one_in(3);  // each counts its own datagrams
    hosts.push_back(std::make_unique<Participant>(domain.number(), "host" + std::to_string(i), lossy));
    writers.push_back(std::make_unique<Writer<msg::Fault>>(*hosts.back()));
  }
  for (const auto& writer : writers) ASSERT_TRUE(writer->wait_matched(1, kPatience));
  ASSERT_TRUE(reader.wait_matched(4, kPatience));

  constexpr int kFaults = 40;
  for (int round = 0; round < 25; ++round) {
    for (int i = 0; i < kFaults; ++i) {
      wall_offset = i % 3 == 0 ? 86400 * (i % 2) : -60 * i;
      msg::Fault fault;
      fault.id(std::to_string(i));  // a key is used again when all samples of its round have arrived
      ASSERT_TRUE(writers[static_cast<std::size_t>(i) % writers.size()]->write(fault));
    }
    const auto wanted = static_cast<std::uint64_t>(round + 1) * kFaults;
    ASSERT_TRUE(wait_until(reader, [&] { return reader.counters().received >= wanted; }))
        << reader.counters().received << " of " << wanted;
  }
  wall_offset = 0;
}

}  // namespace
}  // namespace hecaton::bus
