#include "services/runtime/heartbeat_publisher.hpp"

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

/// A loop in virtual time that publishes a heartbeat every 10 ms; each of its turns is up to 0.2 ms late.
class HeartbeatPublisherTest : public bus::BusTest {
 protected:
  /// The intervals between heartbeats of a loop with this period.
  std::vector<Clock::duration> intervals(std::chrono::nanoseconds turn) {
    HeartbeatPublisher publisher(here_, {"supervisor", msg::NodeKind::NODE_SUPERVISOR, {}, "h1"}, {});
    std::uniform_int_distribution<int> late_us(0, 200);
    const HealthReport report;
    const LoopStatistics loop;
    std::vector<Clock::duration> intervals;
    std::optional<Clock::time_point> last;
    for (int i = 0; i < 1000; ++i) {
      const Clock::time_point now = Clock::time_point(1h) + i * turn + std::chrono::microseconds(late_us(random_));
      if (!publisher.due(now, turn / 2)) continue;
      publisher.publish(now, report, loop);
      if (last) intervals.push_back(now - *last);
      last = now;
    }
    return intervals;
  }

 private:
  std::mt19937 random_{7};
};

// Two turns of a supervisor are a heartbeat period. Without slack, a turn that is 0.1 ms early delays the heartbeat by
// a third turn, and together with other delays beyond the default deadline of 20 ms.
TEST_F(HeartbeatPublisherTest, IsNeverATurnLate) {
  for (const auto turn : {5ms, 2ms, 4ms}) {
    const auto between = intervals(turn);
    ASSERT_GT(between.size(), 100U);
    EXPECT_LT(*std::max_element(between.begin(), between.end()), 10ms + turn / 2 + 1ms) << turn.count() << " ms";
    EXPECT_GT(*std::min_element(between.begin(), between.end()), 10ms - turn / 2 - 1ms) << turn.count() << " ms";
  }
}

}  // namespace
}  // namespace hecaton::services
