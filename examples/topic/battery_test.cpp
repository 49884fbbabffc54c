// The programs of this folder, and the rules of the bus for a topic of another folder.
#include <csignal>
#include <cstdlib>

#include <gtest/gtest.h>

#include "examples/topic/battery_topic.hpp"
#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/join.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/free_domain.hpp"

namespace example {
namespace {

namespace bus = hecaton::bus;
using hecaton::test::ChildProcess;

constexpr auto kLimit = std::chrono::seconds(20);
constexpr const char* kCell = HECATON_SOURCE_DIR "/examples/topic/cell.yaml";

class BatteryTopic : public testing::Test {
 protected:
  BatteryTopic() {
    ::setenv("HECATON_DOMAIN", std::to_string(domain_.number()).c_str(), 1);  // of the programs, too
  }

  /// Waits for data or events of the reader until `done()` holds; false after kLimit.
  template <class Condition>
  bool await(Condition done) {
    const auto until = bus::Clock::now() + kLimit;
    while (!done()) {
      if (!mailbox_.wait(until - bus::Clock::now())) return false;
    }
    return true;
  }
  bus::Participant join(const std::string& name, bus::Mailbox* mailbox) const {
    hecaton::services::ServiceOptions options;
    options.domain = domain_.number();
    return hecaton::services::make_participant(file_, options, hecaton::services::Role::kOperator, name, mailbox);
  }
  bool has_event(bus::EventKind kind, const std::string& key) {
    for (const auto& event : mailbox_.take_events()) {
      if (event.kind == kind && event.key == key) return true;
    }
    return false;
  }

  hecaton::test::FreeDomain domain_;
  bus::Mailbox mailbox_;
  const hecaton::config::CellFile file_ = hecaton::config::load_cell_file(kCell);
  bus::Participant participant_ = join("test", &mailbox_);
  bus::Reader<BatteryState> reader_{participant_, &mailbox_};
};

TEST_F(BatteryTopic, GaugePublishesTheCharge) {
  ChildProcess gauge("example_battery_gauge", {kCell, "arm", "0.8"});
  ASSERT_TRUE(await([&] { return reader_.latest("arm") != nullptr; }));
  EXPECT_EQ(reader_.latest("arm")->value.charge(), 0.8);
}

TEST_F(BatteryTopic, ReaderMissesAGaugeThatEnds) {
  ChildProcess gauge("example_battery_gauge", {kCell, "arm", "0.8"});
  ASSERT_TRUE(await([&] { return reader_.latest("arm") != nullptr; }));
  gauge.signal(SIGTERM);
  EXPECT_TRUE(await([&] { return has_event(bus::EventKind::kPeerLost, "arm"); }));
  EXPECT_EQ(gauge.wait(kLimit).code, 0);
}

TEST_F(BatteryTopic, WatchEndsWhenTheChargeIsLow) {
  ChildProcess watch("example_battery_watch", {kCell, "0.2"});
  ChildProcess gauge("example_battery_gauge", {kCell, "arm", "0.15"});
  EXPECT_EQ(watch.wait(kLimit).code, 1);
  EXPECT_NE(watch.standard_output().find("arm: 15 %"), std::string::npos) << watch.standard_output();
}

TEST_F(BatteryTopic, DropsSamplesOfAnotherSchema) {
  bus::Participant other = join("other", nullptr);
  bus::Writer<BatteryState> writer(other);
  BatteryState state;
  EXPECT_EQ(state.schema(), 1U);
  state.arm("old");
  state.schema(2);
  ASSERT_TRUE(writer.write(state));
  state.arm("new");
  state.schema(1);
  ASSERT_TRUE(writer.write(state));
  ASSERT_TRUE(await([&] { return reader_.latest("new") != nullptr; }));
  EXPECT_EQ(reader_.latest("old"), nullptr);
  EXPECT_EQ(reader_.counters().unreadable, 1U);
}

}  // namespace
}  // namespace example
