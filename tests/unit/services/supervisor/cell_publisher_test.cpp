// When a supervisor repeats its cell mode.
#include "services/supervisor/cell_publisher.hpp"

#include "tests/unit/services/bus/bus_test.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

class CellPublisherTest : public bus::BusTest {
 protected:
  /// The times [ms] at which a supervisor with a turn of 5 ms publishes `mode`, of the 100 ms from `begin` on.
  std::vector<int> published(CellPublisher& publisher, const msg::CellMode& mode, bus::Clock::time_point begin) {
    std::vector<int> times;
    for (int ms = 0; ms < 100; ms += 5) {
      const auto now = begin + std::chrono::milliseconds(ms);
      auto next = publisher.next(mode, now);
      if (!next) continue;
      EXPECT_EQ(next->sequence_number(), ++number_);
      publisher.publish(*std::move(next), now);
      times.push_back(ms);
    }
    return times;
  }

  std::uint64_t number_ = 0;
};

// The topic has no acknowledgements: repetition makes up for a lost datagram.
TEST_F(CellPublisherTest, RepeatsAChangedModeAtOnceAndThenPeriodically) {
  CellPublisher publisher(here_, "supervisor");
  const auto begin = bus::Clock::now();
  msg::CellMode mode;
  mode.term(1);
  mode.node("supervisor");
  const std::vector<int> expected{0, 5, 10, 15, 40, 65, 90};
  EXPECT_EQ(published(publisher, mode, begin), expected);
  mode.mode(msg::Mode::MODE_STOP);
  EXPECT_EQ(published(publisher, mode, begin + 1s), expected);
}

}  // namespace
}  // namespace hecaton::services
