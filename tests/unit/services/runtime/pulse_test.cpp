// When a loop's heartbeats are due, whatever its turns' jitter.
#include "services/runtime/pulse.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <random>
#include <vector>

#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// A loop of this period that beats every 10 ms, in a time of its own; each of its turns is up to 0.2 ms late.
class PulseOfALoop : public bus::BusTest {
 protected:
  /// How far its beats are from each other.
  std::vector<Clock::duration> intervals(std::chrono::nanoseconds turn) {
    Pulse pulse(here_, {"supervisor", msg::NodeKind::NODE_SUPERVISOR, {}, "h1"}, {});
    std::uniform_int_distribution<int> late_us(0, 200);
    const Vital vital;
    const LoopStatistics loop;
    std::vector<Clock::duration> intervals;
    std::optional<Clock::time_point> last;
    for (int i = 0; i < 1000; ++i) {
      const Clock::time_point now = Clock::time_point(1h) + i * turn + std::chrono::microseconds(late_us(random_));
      if (!pulse.due(now, turn / 2)) continue;
      pulse.beat(now, vital, loop);
      if (last) intervals.push_back(now - *last);
      last = now;
    }
    return intervals;
  }

 private:
  std::mt19937 random_{7};
};

// Two of a supervisor's turns are a period. Who was 0.1 ms early against its last beat waited for a third, and whoever
// was late besides was silent for longer than the default limit of 20 ms.
TEST_F(PulseOfALoop, NoBeatIsATurnLate) {
  for (const auto turn : {5ms, 2ms, 4ms}) {
    const auto between = intervals(turn);
    ASSERT_GT(between.size(), 100U);
    EXPECT_LT(*std::max_element(between.begin(), between.end()), 10ms + turn / 2 + 1ms) << turn.count() << " ms";
    EXPECT_GT(*std::min_element(between.begin(), between.end()), 10ms - turn / 2 - 1ms) << turn.count() << " ms";
  }
}

}  // namespace
}  // namespace hecaton::services
