/// hecaton view and up --view: the page of a live cell, and in a browser where there is one.

#include <atomic>
#include <filesystem>
#include <thread>

#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/needed_files.hpp"
#include "tests/unit/services/view/web_client.hpp"

namespace hecaton::test {
namespace {

class LivePage : public LiveCell {
 protected:
  [[nodiscard]] std::vector<std::string> up_options() const override { return {"--view"}; }
  [[nodiscard]] std::uint16_t port() const { return static_cast<std::uint16_t>(8000 + domain_.number()); }
};

TEST_F(LivePage, ShowsAllArmsOfTheCell) {
  ASSERT_TRUE(up_->wait_for_message("its page: http://127.0.0.1:" + std::to_string(port()) + "/")) << up_->err();
  EXPECT_EQ(request(port(), "/").result(), http::status::ok);
  WebSocketClient page(port());
  EXPECT_EQ(page.wait_for("cell", [](const Json&) { return true; }).at("arms").size(), 3U);
  const Json frame = page.wait_for("frame", [](const Json& message) {
    for (const Json& arm : message.at("arms")) {
      if (arm[0].is_null()) return false;
    }
    return true;
  });
  // What the page shows is what the supervisor has received.
  const Json status = json({"status"});
  for (std::size_t i = 0; i < 3; ++i) {
    const Json& q = status.at("arms")[i].at("state").at("q");
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(frame.at("arms")[i][1][k].get<double>(), q[k].get<double>(), 1e-4);
  }
  const Json live = page.wait_for("status", [](const Json& message) { return message.at("mode") == "run"; });
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(live.at("arms")[i].at("waiting").at("text"), status.at("arms")[i].at("waiting_for").at("text"));
  }
  EXPECT_EQ(entry(status.at("nodes"), "node", "view").at("state"), "running");
}

TEST_F(LivePage, DrawsMovingArmsInABrowser) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  const std::string browser = "/usr/bin/chromium";
  if (const std::string file = first_missing({page + "/node_modules/playwright-core", node, browser}); !file.empty()) {
    ASSERT_TRUE(may_skip()) << file << " is missing";
    GTEST_SKIP() << file << " is missing";
  }
  ASSERT_TRUE(up_->wait_for_message("its page: ")) << up_->err();
  Process test({node, page + "/test/browser.mjs", "http://127.0.0.1:" + std::to_string(port()) + "/", browser,
                std::string(HECATON_SOURCE_DIR) + "/deploy/cells/urdf/puma560.urdf"});
  // The arm moves as long as the browser looks.
  std::atomic<bool> done = false;
  std::thread mover([&] {
    for (int i = 0; !done; ++i) {
      EXPECT_EQ(run({"goal", "north", "--named", i % 2 == 0 ? "ready" : "home", "--wait"}).code, 0);
    }
  });
  const int code = test.wait();
  done = true;
  mover.join();
  EXPECT_EQ(code, 0) << test.out() << test.err();
}

TEST(View, SaysWhatItNeeds) {
  EXPECT_EQ(run_hecaton({"view"}).code, 2);
  const Ran port = run_hecaton({"view", kThreePuma, "--port", "70000"});
  EXPECT_EQ(port.code, 3) << port.err;
  const Ran address = run_hecaton({"view", kThreePuma, "--listen", "everywhere"});
  EXPECT_EQ(address.code, 3) << address.err;
  EXPECT_NE(address.err.find("--listen"), std::string::npos) << address.err;
  const Ran cell = run_hecaton({"view", "missing.yaml"});
  EXPECT_EQ(cell.code, 3);
  EXPECT_NE(cell.err.find("missing.yaml"), std::string::npos) << cell.err;
}

}  // namespace
}  // namespace hecaton::test
