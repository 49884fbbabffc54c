#include "services/bus/reception_gate.hpp"

#include <atomic>
#include <future>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

namespace hecaton::bus {
namespace {

constexpr auto kLimit = std::chrono::seconds(20);  // for any machine

TEST(ReceptionGate, IsQuietWhileNoThreadIsInside) {
  ReceptionGate gate;
  { const ReceptionGate::Pass pass(gate); }
  const ReceptionGate::Closure closure(gate, kLimit);
  EXPECT_TRUE(closure.quiet());
}

TEST(ReceptionGate, AwaitsTheThreadsInside) {
  ReceptionGate gate;
  std::optional<ReceptionGate::Pass> pass(gate);
  auto quiet = std::async(std::launch::async, [&] { return ReceptionGate::Closure(gate, kLimit).quiet(); });
  pass.reset();
  EXPECT_TRUE(quiet.get());
}

TEST(ReceptionGate, KeepsThreadsOutUntilTheLastClosureEnds) {
  ReceptionGate gate;
  std::optional<ReceptionGate::Closure> one(std::in_place, gate, kLimit);
  std::optional<ReceptionGate::Closure> two(std::in_place, gate, kLimit);
  std::atomic<int> closures = 2;
  auto seen = std::async(std::launch::async, [&] {
    const ReceptionGate::Pass pass(gate);
    return closures.load();
  });
  closures = 1;
  one.reset();
  closures = 0;
  two.reset();
  EXPECT_EQ(seen.get(), 0);
}

// A thread inside may wait for a lock of the one that closes the gate.
TEST(ReceptionGate, WaitsNoLongerThanItsLimit) {
  ReceptionGate gate;
  const ReceptionGate::Pass pass(gate);
  EXPECT_FALSE(ReceptionGate::Closure(gate, std::chrono::milliseconds(1)).quiet());
}

}  // namespace
}  // namespace hecaton::bus
