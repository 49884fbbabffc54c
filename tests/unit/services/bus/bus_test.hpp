#pragma once
/// Shared by the tests of the bus: a free domain, time-outs and waiting.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

#include <gtest/gtest.h>

#include "services/bus/endpoint.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton::bus {

/// A time-out for any machine; tests wait for events and fail only when one never comes.
inline constexpr auto kPatience = std::chrono::seconds(20);

inline constexpr auto kOnceMore = std::chrono::milliseconds(50);

/// A cell on one host.
inline ParticipantOptions one_host() {
  ParticipantOptions options;
  options.interfaces = {"127.0.0.1"};
  return options;
}

/// For ParticipantOptions::discard: true for one call in n, at random, the same ones in every run. (Losing every n-th
/// datagram would lose the same message of a periodic protocol again and again.) [Steele14]
inline std::function<bool()> one_in(std::uint64_t n) {
  return [n, calls = std::make_shared<std::atomic<std::uint64_t>>(0)] {
    std::uint64_t z = ++*calls * 0x9E37'79B9'7F4A'7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58'476D'1CE4'E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D0'49BB'1331'11EBULL;
    return (z ^ (z >> 31)) % n == 0;
  };
}

/// Waits on the reader's mailbox until `done()` holds. It is evaluated at every event, and after kOnceMore without one:
/// a best-effort sample that `done()` writes may get lost.
template <class T, class Condition>
[[nodiscard]] bool wait_until(Reader<T>& reader, Condition done) {
  const auto until = Clock::now() + kPatience;
  while (!done()) {
    const auto left = until - Clock::now();
    if (left <= Clock::duration::zero()) return false;
    [[maybe_unused]] const bool arrived = reader.wait_for_data(std::min<Clock::duration>(left, kOnceMore));
  }
  return true;
}

/// Two participants of one domain that communicate over UDP, as two processes do.
class BusTest : public testing::Test {
 protected:
  test::FreeDomain domain_;
  Participant here_{domain_.number(), "here", one_host()};
  Participant there_{domain_.number(), "there", one_host()};

  template <class T>
  void expect_matched(const Writer<T>& writer, const Reader<T>& reader) {
    ASSERT_TRUE(writer.wait_matched(1, kPatience));
    ASSERT_TRUE(reader.wait_matched(1, kPatience));
  }
};

}  // namespace hecaton::bus
