/// A simulated gripper in a running cell: it takes a crate, carries it, survives its driver, and puts it down.

#include "tests/support/gripper_cell.hpp"

#include <cmath>

#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/signal_process.hpp"

namespace hecaton::test {
namespace {

class GripperCell : public LiveCell {
 protected:
  void SetUp() override {
    (void)write_gripper_cell(folder_);
    LiveCell::SetUp();
  }
  [[nodiscard]] std::string cell_file() const override { return (folder_.path() / "cell.yaml").string(); }
  [[nodiscard]] Ran go(const std::string& arm, const std::string& named) const {
    return run({"goal", arm, "--named", named, "--wait", "--time-limit", "60s"});
  }
  void reach(const std::string& arm, const std::string& named) const {
    const Ran ran = go(arm, named);
    EXPECT_EQ(ran.code, 0) << named << ": " << ran.out << ran.err;
  }
  [[nodiscard]] Json crate() const { return entry(json({"obstacles"}), "name", "crate"); }
  [[nodiscard]] bool until(const std::function<bool()>& event) const {
    for (const auto end = std::chrono::steady_clock::now() + kPatience; std::chrono::steady_clock::now() < end;) {
      if (event()) return true;
    }
    return false;
  }

  TemporaryFolder folder_;
};

TEST_F(GripperCell, TakesACrateCarriesItAndPutsItDown) {
  // With the fingers anywhere in their range the crate would be in their way.
  reach("north", "crate");
  const Json closed = json({"tool", "north", "close"});
  EXPECT_EQ(closed.value("holding", ""), "crate") << closed;
  EXPECT_NEAR(closed["width"].get<double>(), 0.04, 0.002);
  EXPECT_EQ(crate()["attached_to"], "north") << crate();

  reach("north", "away");
  EXPECT_NEAR(crate()["xyz_rpy"][1].get<double>(), 0.3, 0.005) << crate();

  // The driver dies: the gripper keeps what it holds, and nothing is ordered again.
  EXPECT_TRUE(signal_process(processes().at("driver/north"), SIGKILL));
  ASSERT_TRUE(until([&] {
    const Json arm = entry(json({"arms"}), "name", "north");
    return arm["driver_alive"].get<bool>() && arm["state"]["mode"] == "running";
  }));
  const Json kept = json({"tool", "north"});
  EXPECT_EQ(kept.value("holding", ""), "crate") << kept;
  EXPECT_NEAR(kept["width"].get<double>(), 0.04, 0.002);

  reach("north", "lifted");
  const Json opened = json({"tool", "north", "open"});
  EXPECT_TRUE(opened["holding"].is_null()) << opened;
  EXPECT_NEAR(opened["width"].get<double>(), 0.1, 1e-6);
  const Json released = crate();
  EXPECT_TRUE(released["attached_to"] == "") << released;
  EXPECT_NEAR(released["xyz_rpy"][1].get<double>(), 0.0, 0.005) << "it stays where it was released";
  reach("north", "home");
  const Json status = json({"status"});
  EXPECT_EQ(status.at("contact_report").at("contacts"), 0) << status.at("contact_report");
}

TEST_F(GripperCell, RefusesWithAReason) {
  const Ran none = run({"tool", "south", "close"});
  EXPECT_EQ(none.code, 1);
  EXPECT_NE(none.err.find("arm south: it has no gripper"), std::string::npos) << none.err;
  ASSERT_EQ(run({"stop", "north"}).code, 0);
  const Ran stopped = run({"tool", "north", "close"});
  EXPECT_EQ(stopped.code, 1);
  EXPECT_NE(stopped.err.find("arm north: it is stopped: resume it first"), std::string::npos) << stopped.err;
  const Ran wide = run({"tool", "north", "open", "--width", "0.2"});
  EXPECT_NE(wide.code, 0);
  // South has no gripper: a person says where its fingers are.
  EXPECT_EQ(run({"posture", "south", "grip=0.01"}).code, 0);
  const Ran far = run({"posture", "south", "grip=0.2"});
  EXPECT_EQ(far.code, 1);
  EXPECT_NE(far.err.find("joint grip = 0.2 must be within its range, 0 to 0.05"), std::string::npos) << far.err;
}

TEST_F(GripperCell, ListsReadsSetsAndAwaitsSignals) {
  const Json all = json({"io"});
  ASSERT_EQ(all.size(), 3U) << all;
  EXPECT_EQ(all[0]["name"], "lamp");
  EXPECT_EQ(run({"io", "north", "lamp", "1"}).code, 0);
  EXPECT_EQ(json({"io", "north", "lamp"})["value"], 1.0);
  const auto waiting = start({"io", "north", "part", "--until", "1", "--timeout", "60s"});
  EXPECT_EQ(run({"io", "north", "part", "1"}).code, 0);
  EXPECT_EQ(waiting->wait(), 0) << waiting->err();
  const Ran late = run({"io", "north", "pressure", "--above", "2", "--timeout", "200ms"});
  EXPECT_EQ(late.code, 1);
  EXPECT_NE(late.err.find("signal pressure of arm north is 0 after"), std::string::npos) << late.err;
  const Ran unknown = run({"io", "north", "lamb"});
  EXPECT_EQ(unknown.code, 3);
  EXPECT_NE(unknown.err.find("it has lamp, part and pressure"), std::string::npos) << unknown.err;
}

}  // namespace
}  // namespace hecaton::test
