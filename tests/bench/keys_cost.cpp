/// What keys cost: processor time to find each other, and for each state of an arm that four others read; its latency,
/// from write() to the moment when a reader's thread has it.
///
/// usage: keys-cost DOMAIN [KEYSTORE]
///
/// KEYSTORE has the host localhost. Without it the participants are open.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <thread>
#include <vector>

#include <idl/arm.h>

#include "services/bus/endpoint.hpp"
#include "services/security/keystore.hpp"

namespace hecaton::bench {
namespace {

constexpr int kReaders = 4;
constexpr int kSamples = 2000;
constexpr std::chrono::milliseconds kPeriod{2};
constexpr std::chrono::seconds kPatience{60};

double processor_seconds(clockid_t clock) {
  timespec spent{};
  clock_gettime(clock, &spent);
  return static_cast<double>(spent.tv_sec) + 1e-9 * static_cast<double>(spent.tv_nsec);
}

int run(int domain, const std::filesystem::path& keystore) {
  const auto participant = [&](const std::string& name, services::Role role) {
    bus::ParticipantOptions options;
    options.interfaces = {"127.0.0.1"};
    options.lease = std::chrono::seconds(20);
    if (!keystore.empty()) options.identity = services::enclave_folder(keystore, "localhost", role);
    return bus::Participant(domain, name, options);
  };
  const double begin = processor_seconds(CLOCK_PROCESS_CPUTIME_ID);
  bus::Participant driver = participant("driver", services::Role::kDriver);
  bus::Writer<msg::ArmState> states(driver);
  std::deque<bus::Participant> planners;
  std::deque<bus::Reader<msg::ArmState>> readers;
  for (int i = 0; i < kReaders; ++i)
    readers.emplace_back(planners.emplace_back(participant("planner", services::Role::kPlanner)));
  if (!states.wait_matched(kReaders, kPatience)) {
    std::fprintf(stderr, "keys-cost: not all participants were found within 60 s\n");
    return 1;
  }
  std::this_thread::sleep_for(std::chrono::seconds(3));  // the planners among each other
  const double started = processor_seconds(CLOCK_PROCESS_CPUTIME_ID);

  msg::ArmState state;
  state.arm("north");
  state.q(std::vector<double>(6, 0.5));
  state.qd(std::vector<double>(6, 0.5));
  double writing = 0;
  std::vector<bus::Clock::time_point> written;
  std::vector<double> latencies;  // [µs]
  auto next = bus::Clock::now();
  for (int i = 0; i < kSamples; ++i) {
    std::this_thread::sleep_until(next += kPeriod);
    state.sequence_number(static_cast<std::uint64_t>(i));
    const double before = processor_seconds(CLOCK_THREAD_CPUTIME_ID);
    written.push_back(bus::Clock::now());
    static_cast<void>(states.write(state));
    writing += processor_seconds(CLOCK_THREAD_CPUTIME_ID) - before;
    for (auto& reader : readers) {
      for (const auto& sample : reader.take()) {
        const auto latency = sample.received - written.at(sample.value.sequence_number());
        latencies.push_back(std::chrono::duration<double, std::micro>(latency).count());
      }
    }
  }
  const double all = processor_seconds(CLOCK_PROCESS_CPUTIME_ID) - started;
  std::printf("start of %d participants %.0f ms; a state: writer %.0f us, each reader %.0f us\n", kReaders + 1,
              1e3 * (started - begin), 1e6 * writing / kSamples, 1e6 * (all - writing) / kSamples / kReaders);
  std::sort(latencies.begin(), latencies.end());
  std::printf("latency of %zu states: p50 %.0f us, p99 %.0f us\n", latencies.size(), latencies.at(latencies.size() / 2),
              latencies.at(latencies.size() * 99 / 100));
  return 0;
}

}  // namespace
}  // namespace hecaton::bench

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) {
    std::fprintf(stderr, "usage: keys-cost DOMAIN [KEYSTORE]\n");
    return 2;
  }
  return hecaton::bench::run(std::atoi(argv[1]), argc == 3 ? argv[2] : "");
}
