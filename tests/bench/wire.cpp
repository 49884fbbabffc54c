#include <idl/arm.h>

#include "services/bus/type_support.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

constexpr int kSamples = 2000;
/// A reading of the clock costs a tenth of one check.
constexpr int kAtOnce = 100;

/// The check of the state of a six-joint arm against its rules, beside its decoding, which follows in a reader. Times
/// are of kAtOnce samples.
void arm_state(benchmark::State& state) {
  msg::ArmState arm;
  arm.arm("north");
  arm.planner("planner/north");
  arm.q(std::vector<double>(6, 0.5));
  arm.qd(std::vector<double>(6, 0.5));
  bus::GuardedType<msg::ArmState> type;
  const std::string bytes = type.bytes_of(arm);
  const std::span<const std::uint8_t> raw(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  const bus::TopicRule& rule = *bus::topic_rule("ArmState");
  msg::ArmState decoded;
  Timings check;
  Timings decoding;
  for (auto _ : state) {
    set_iteration_time(state, check.measure([&] {
      for (int i = 0; i < kAtOnce; ++i) benchmark::DoNotOptimize(bus::check_sample(rule, raw));
    }));
    decoding.measure([&] {
      for (int i = 0; i < kAtOnce; ++i) type.read(bytes, decoded);
      benchmark::DoNotOptimize(decoded);
    });
  }
  report(state, check, decoding);
}
BENCHMARK(arm_state)->Name("wire/100_arm_states")->Iterations(kSamples)->UseManualTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
