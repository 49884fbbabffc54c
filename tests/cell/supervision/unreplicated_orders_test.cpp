// A supervisor that no longer leads requests its unreplicated orders from the new leader. The test acts as that leader,
// the supervisor on beta: its terms are odd.

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/cell/supervision/health_cell.hpp"

namespace hecaton::services::testing {
namespace {

class OtherLeader {
 public:
  OtherLeader(HealthCell& cell, std::uint64_t term)
      : cell_(cell), modes_(cell.participant()), requests_(cell.participant(), &cell.mailbox()) {
    mode_.term(term);
    mode_.node("supervisor@elsewhere");
  }
  msg::CellMode& mode() { return mode_; }

  /// Leads until the supervisor has sent a request that satisfies `wanted`. False after kPatience.
  bool receives_request(const std::function<bool(const msg::SupervisorRequest&)>& wanted) {
    for (const auto until = bus::Clock::now() + kPatience; bus::Clock::now() < until;) {
      publish();
      const auto taken = requests_.take();
      const auto is_it = [&](const auto& sample) {
        return !sample.disposed && sample.value.client() == "supervisor" && wanted(sample.value);
      };
      if (std::any_of(taken.begin(), taken.end(), is_it)) return true;
      static_cast<void>(cell_.mailbox().wait(20ms));
      static_cast<void>(cell_.mailbox().take_events());
    }
    return false;
  }
  void publish() {
    mode_.sequence_number(mode_.sequence_number() + 1);
    EXPECT_TRUE(modes_.write(mode_));
  }

 private:
  HealthCell& cell_;
  msg::CellMode mode_;
  bus::Writer<msg::CellMode> modes_;
  bus::Reader<msg::SupervisorRequest> requests_;
};

TEST(UnreplicatedOrders, AreRequestedFromTheNewLeaderUntilItPublishesThem) {
  HealthCell cell({"--host", "alpha"}, "standby_cell.yaml");
  const auto before = cell.await_left_running();
  ASSERT_TRUE(cell.call(msg::RequestKind::REQUEST_STOP, {"left"})->done());
  {
    OtherLeader other(cell, before.mode().term() + 1001);
    EXPECT_TRUE(other.receives_request([](const msg::SupervisorRequest& request) {
      return request.kind() == msg::RequestKind::REQUEST_STOP && request.arms() == std::vector<std::string>{"left"};
    }));
    other.mode().ordered(msg::Mode::MODE_HOLD);  // another order: this leader ends before it executes the request
    other.mode().mode(msg::Mode::MODE_HOLD);
    EXPECT_TRUE(
        other.receives_request([](const auto& request) { return request.kind() == msg::RequestKind::REQUEST_STOP; }));
  }
  const auto after = cell.await("the first supervisor, leading again", [&](const msg::CellStatus& status) {
    return status.mode().term() > before.mode().term() + 1001;
  });
  EXPECT_EQ(arms_on(after.mode(), msg::Mode::MODE_STOP), std::vector<std::string>{"left"});
  EXPECT_EQ(after.mode().ordered(), msg::Mode::MODE_HOLD) << "the orders of the other leader are in force, too";
}

}  // namespace
}  // namespace hecaton::services::testing
