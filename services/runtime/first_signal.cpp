#include "services/runtime/first_signal.hpp"

#include <atomic>
#include <cstdint>
#include <ctime>

namespace hecaton::services::first_signal {
namespace {

constexpr std::int64_t kEcho_ns = 200'000'000;

std::atomic<int> first{0};
std::atomic<std::int64_t> first_ns{0};  // 0: none yet
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free,
              "a signal handler may use lock-free atomics only");

std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

Arrival arrived(int number) {
  std::int64_t expected = 0;
  const std::int64_t now = monotonic_ns();
  if (first_ns.compare_exchange_strong(expected, now)) {
    first.store(number);
    return Arrival::kFirst;
  }
  return now - expected > kEcho_ns ? Arrival::kSecond : Arrival::kEcho;
}

int number() {
  return first.load();
}

void forget() {
  first.store(0);
  first_ns.store(0);
}

}  // namespace hecaton::services::first_signal
