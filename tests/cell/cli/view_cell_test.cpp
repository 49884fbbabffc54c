/// hecaton view and up --view: the page of a live cell, and in a browser where there is one.

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>

#include <sys/stat.h>

#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/needed_files.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/view/web_client.hpp"

namespace hecaton::test {
namespace {

class LivePage : public LiveCell {
 protected:
  [[nodiscard]] std::vector<std::string> up_options() const override { return {"--view"}; }
  [[nodiscard]] std::uint16_t port() const { return static_cast<std::uint16_t>(8000 + domain_.number()); }
  /// Where a person wants to see what the browser shows; empty: nowhere.
  [[nodiscard]] static std::string picture() {
    const char* folder = std::getenv("HECATON_PICTURES");
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = test->name();
    std::replace(name.begin(), name.end(), '/', '_');
    return folder == nullptr ? "" : std::string(folder) + "/" + name + ".png";
  }
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

/// A cell without a page, and a view with options of the test.
class LiveOrders : public LiveCell {
 protected:
  /// Starts `hecaton view`; the address that it prints.
  std::string start_view(const std::vector<std::string>& options) {
    std::vector<std::string> words{
        std::string(HECATON_BIN_DIR) + "/hecaton", "view", kThreePuma, "--domain", domain(), "--port", "0"};
    words.insert(words.end(), options.begin(), options.end());
    view_ = std::make_unique<Process>(words);
    EXPECT_TRUE(view_->wait_for_output("\n")) << view_->err();
    return view_->out().substr(0, view_->out().find('\n'));
  }
  static std::uint16_t port_of(const std::string& url) {
    return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  }
  /// The answer to an order of a page.
  static Json order(WebSocketClient& page, Json message) {
    message["id"] = 17;
    page.write(message.dump());
    return page.wait_for("reply", [](const Json& reply) { return reply.at("id") == 17; });
  }
  std::unique_ptr<Process> view_;
};

TEST_F(LiveOrders, StopTheCellFromAPageWithoutAToken) {
  const std::string url = start_view({});
  EXPECT_EQ(url.find('#'), std::string::npos) << url;
  WebSocketClient page(port_of(url), "http://localhost");
  EXPECT_TRUE(page.wait_for("control", [](const Json&) { return true; }).at("stop"));
  const Json stopped = order(page, {{"op", "stop"}});
  EXPECT_TRUE(stopped.at("done")) << stopped;
  EXPECT_EQ(json({"status"}).at("mode"), "stop");
  EXPECT_FALSE(order(page, {{"op", "resume"}}).at("done"));
  EXPECT_EQ(json({"status"}).at("mode"), "stop");
  view_->signal(SIGINT);
  EXPECT_EQ(view_->wait(), 0);
  EXPECT_NE(view_->err().find("event=\"order of a page\" order=stop"), std::string::npos) << view_->err();
  EXPECT_NE(view_->err().find("page=127.0.0.1:"), std::string::npos) << view_->err();
}

TEST_F(LiveOrders, LeaveTheCellAloneWithNoStop) {
  WebSocketClient page(port_of(start_view({"--no-stop"})), "http://localhost");
  EXPECT_FALSE(page.wait_for("control", [](const Json&) { return true; }).at("stop"));
  EXPECT_FALSE(order(page, {{"op", "stop"}}).at("done"));
  EXPECT_EQ(json({"status"}).at("mode"), "run");
}

TEST_F(LiveOrders, ControlTheCellInABrowser) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  const std::string browser = "/usr/bin/chromium";
  HECATON_NEED_FILES({page + "/node_modules/playwright-core", node, browser});
  const std::string url = start_view({"--control"});
  ASSERT_NE(url.find("/#token="), std::string::npos) << url;
  Process test({node, page + "/test/orders.mjs", url, browser});
  EXPECT_EQ(test.wait(), 0) << test.out() << test.err();
  view_->signal(SIGINT);
  EXPECT_EQ(view_->wait(), 0);
  EXPECT_EQ(view_->err().find(url.substr(url.find('=') + 1)), std::string::npos) << "the token is in the log";
  EXPECT_NE(view_->err().find("subject=\"north to ready\""), std::string::npos) << view_->err();
}

TEST_F(LiveOrders, DragAGoalInABrowser) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  const std::string browser = "/usr/bin/chromium";
  HECATON_NEED_FILES({page + "/node_modules/playwright-core", node, browser});
  const std::string url = start_view({"--control"});
  Process test({node, page + "/test/goal_drag.mjs", url, browser});
  EXPECT_EQ(test.wait(), 0) << test.out() << test.err();
  view_->signal(SIGINT);
  EXPECT_EQ(view_->wait(), 0);
  EXPECT_NE(view_->err().find("subject=\"north to joint positions\""), std::string::npos) << view_->err();
}

TEST_F(LiveOrders, AnswerAPreviewAndMoveNothing) {
  const std::string url = start_view({"--control"});
  WebSocketClient page(port_of(url.substr(0, url.find("/#"))), "http://localhost");
  page.wait_for("frame", [](const Json& frame) { return !frame.at("arms")[0][0].is_null(); });
  const Json question{{"op", "preview"}, {"id", -5}, {"arm", "north"}, {"pose", {0.3, 0.3, 50.0, 0, 0, 0, 1}}};
  page.write(question.dump());
  EXPECT_EQ(page.wait_for("reply", [](const Json&) { return true; }).at("text"), "this page does not control the cell");
  EXPECT_TRUE(order(page, {{"op", "take"}, {"token", url.substr(url.find('=') + 1)}}).at("done"));
  // Of many at once only a few have answers, the newest among them.
  for (int i = 1; i <= 200; ++i) {
    Json newer = question;
    newer["id"] = -100 - i;
    page.write(newer.dump());
  }
  int answers = 0;
  const Json last = page.wait_for("preview", [&](const Json& preview) { return ++answers, preview.at("id") == -300; });
  EXPECT_LT(answers, 100);
  EXPECT_EQ(last.at("verdict"), "unreachable");
  EXPECT_EQ(last.at("q").size(), 6U);
  EXPECT_TRUE(entry(json({"status"}).at("arms"), "name", "north").at("goal").is_null()) << "a preview is no goal";
}

TEST_F(LiveOrders, SaveWhatRecordersOfTheCellKeep) {
  const std::string url = start_view({"--control"});
  WebSocketClient page(port_of(url.substr(0, url.find("/#"))), "http://localhost");
  EXPECT_TRUE(order(page, {{"op", "take"}, {"token", url.substr(url.find('=') + 1)}}).at("done"));
  const TemporaryFolder folder;
  const auto recorder = start({"record", kThreePuma, "--keep", "10s", "-o", folder.path("run.mcap")});
  ASSERT_TRUE(recorder->wait_for_message("recording cell")) << recorder->err();
  const Json saved = order(page, {{"op", "save"}});
  EXPECT_TRUE(saved.at("done")) << saved;
  EXPECT_NE(saved.at("text").get<std::string>().find(folder.path("run-0")), std::string::npos) << saved;
  EXPECT_TRUE(recorder->wait_for_message("saved what is kept: a person ordered it")) << recorder->err();
  recorder->signal(SIGINT);
  EXPECT_EQ(recorder->wait(), 0) << recorder->err();
}

TEST_F(LiveOrders, OfFoxgloveNeedTheToken) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  HECATON_NEED_FILES({page + "/node_modules/@foxglove/ws-protocol", node});
  const std::string url = start_view({"--control"});
  const std::string token = url.substr(url.find('=') + 1);
  const std::string socket = "ws://127.0.0.1:" + std::to_string(port_of(url.substr(0, url.find("/#")))) + "/";
  const auto call = [&](const std::string& address, const std::vector<std::string>& services) {
    std::vector<std::string> words{node, page + "/test/foxglove_orders.mjs", address, "foxglove.sdk.v1"};
    words.insert(words.end(), services.begin(), services.end());
    Process test(words);
    EXPECT_EQ(test.wait(), 0) << test.out() << test.err();
    return Json::parse(test.out(), nullptr, false);
  };
  for (const std::string& address : {socket, socket + "?token=" + std::string(token.size(), '0')}) {
    const Json refused = call(address, {"/hecaton/stop"});
    EXPECT_EQ(refused.at("services"), Json::array()) << address;
    EXPECT_EQ(refused.at("warnings").size(), address == socket ? 0U : 1U) << refused;
  }
  EXPECT_EQ(json({"status"}).at("mode"), "run");

  const Json stopped = call(socket + "?token=" + token, {"/north/stop", "/hecaton/stop"});
  EXPECT_EQ(stopped.at("services").size(), 12U);
  EXPECT_EQ(stopped.at("answers")[0].at("message"), "north is stopped");
  EXPECT_TRUE(stopped.at("answers")[1].at("success")) << stopped;
  EXPECT_EQ(json({"status"}).at("mode"), "stop");
  EXPECT_TRUE(call(socket + "?token=" + token, {"/hecaton/resume"}).at("answers")[0].at("success"));
  EXPECT_EQ(json({"status"}).at("mode"), "run");
  EXPECT_EQ(json({"status"}).at("stopped_arms"), Json{"north"}) << "it was stopped by name";

  view_->signal(SIGINT);
  EXPECT_EQ(view_->wait(), 0);
  EXPECT_NE(view_->err().find("event=\"order of a page\" order=stop"), std::string::npos) << view_->err();
  EXPECT_EQ(view_->err().find(token), std::string::npos) << "the token is in the log";
}

/// A cell whose file lets its page control it.
class LiveControl : public LiveCell {
 protected:
  void SetUp() override {
    std::ofstream(cell_file()) << "name: controlled\n"
                                  "view: {control: true, no_stop: true}\n"
                                  "defaults: {robot: ur5e}\n"
                                  "arms:\n"
                                  "  - {name: north, base: {xyz: [0, 0.8, 0]}}\n"
                                  "  - {name: south, base: {xyz: [0, -0.8, 0]}}\n";
    LiveCell::SetUp();
  }
  [[nodiscard]] std::string cell_file() const override { return folder_.path() / "cell.yaml"; }
  [[nodiscard]] std::vector<std::string> up_options() const override { return {"--log-dir", folder_.path() / "logs"}; }
  [[nodiscard]] static std::string content(const std::filesystem::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  TemporaryFolder folder_;
};

TEST_F(LiveControl, HasItsTokenInAFileOfItsUser) {
  const std::string before = "to control the cell, open the address in ";
  ASSERT_TRUE(up_->wait_for_message(before)) << up_->err();
  std::string path = up_->err().substr(up_->err().find(before) + before.size());
  path.resize(path.find('\n'));
  struct stat about {};
  ASSERT_EQ(::stat(path.c_str(), &about), 0) << path;
  EXPECT_EQ(about.st_mode & 07777U, 0600U);

  const std::string address = content(path);
  const std::string start = "http://127.0.0.1:" + std::to_string(8000 + domain_.number()) + "/#token=";
  ASSERT_EQ(address.substr(0, start.size()), start);
  const std::string token = address.substr(start.size(), 64);
  EXPECT_EQ(address, start + token + "\n");
  {
    WebSocketClient page(static_cast<std::uint16_t>(8000 + domain_.number()), "http://localhost");
    const Json control = page.wait_for("control", [](const Json&) { return true; });
    EXPECT_TRUE(control.at("control"));
    EXPECT_FALSE(control.at("stop")) << "no_stop";
    page.write(Json{{"op", "take"}, {"id", 1}, {"token", token}}.dump());
    EXPECT_TRUE(page.wait_for("reply", [](const Json& reply) { return reply.at("id") == 1; }).at("done"));
    page.write(Json{{"op", "hold"}, {"id", 2}}.dump());
    EXPECT_TRUE(page.wait_for("reply", [](const Json& reply) { return reply.at("id") == 2; }).at("done"));
  }
  EXPECT_EQ(json({"status"}).at("mode"), "hold");

  // A view that was restarted has the same token.
  const pid_t first = processes().at("view");
  ASSERT_EQ(::kill(first, SIGKILL), 0);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (processes()["view"] == first) ASSERT_LT(std::chrono::steady_clock::now(), until);
  EXPECT_EQ(content(path), address);

  up_->signal(SIGINT);
  EXPECT_EQ(up_->wait(), 0) << up_->err();
  EXPECT_FALSE(std::filesystem::exists(path)) << "it ends with the run";
  EXPECT_EQ(up_->err().find(token), std::string::npos);
  int logs = 0;
  for (const auto& log : std::filesystem::directory_iterator(folder_.path() / "logs")) {
    ++logs;
    EXPECT_EQ(content(log.path()).find(token), std::string::npos) << log.path();
  }
  EXPECT_GE(logs, 5);
  up_.reset();
}

/// Moves arms of a cell between their postures home and ready, until it is destroyed.
class Mover {
 public:
  Mover(std::function<int(const std::vector<std::string>&)> run, const std::vector<std::string>& arms)
      : run_(std::move(run)) {
    for (const std::string& arm : arms) {
      threads_.emplace_back([this, arm] {
        for (int i = 0; !done_; ++i) {
          EXPECT_EQ(run_({"goal", arm, "--named", i % 2 == 0 ? "ready" : "home", "--wait"}), 0) << arm;
        }
      });
    }
  }
  ~Mover() {
    done_ = true;
    for (std::thread& thread : threads_) thread.join();
  }
  Mover(const Mover&) = delete;
  Mover& operator=(const Mover&) = delete;

 private:
  std::function<int(const std::vector<std::string>&)> run_;
  std::atomic<bool> done_ = false;
  std::vector<std::thread> threads_;
};

TEST_F(LivePage, ShowsStatesWaysSectionsAndAStaleArmInABrowser) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  const std::string browser = "/usr/bin/chromium";
  HECATON_NEED_FILES({page + "/node_modules/playwright-core", node, browser});
  ASSERT_TRUE(up_->wait_for_message("its page: ")) << up_->err();
  const pid_t driver = processes().at("driver/north");
  Process test(
      {node, page + "/test/browser.mjs", "http://127.0.0.1:" + std::to_string(port()) + "/", browser, picture()});
  {
    const Mover mover([this](const auto& words) { return run(words).code; }, {"north"});
    ASSERT_TRUE(test.wait_for_output("let the arms rest")) << test.out() << test.err();
  }
  ASSERT_TRUE(test.wait_for_output("stop the driver")) << test.out() << test.err();
  ASSERT_EQ(kill(driver, SIGSTOP), 0);
  const bool faded = test.wait_for_output("continue");
  ASSERT_EQ(kill(driver, SIGCONT), 0);
  EXPECT_TRUE(faded) << test.out() << test.err();
  EXPECT_EQ(test.wait(), 0) << test.out() << test.err();
  std::printf("%s", test.out().c_str());
}

/// A cell, and the URDF of each of its arms.
struct DrawnCell {
  const char* file;  ///< in deploy/cells
  std::vector<std::pair<std::string, std::string>> arms;
};

class LiveArms : public LivePage, public testing::WithParamInterface<DrawnCell> {
 protected:
  [[nodiscard]] std::string cell_file() const override {
    return std::string(HECATON_SOURCE_DIR) + "/deploy/cells/" + GetParam().file;
  }
};

TEST_P(LiveArms, AreDrawnWhereTheyAreWhileTheyMove) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  const std::string browser = "/usr/bin/chromium";
  HECATON_NEED_FILES({page + "/node_modules/playwright-core", node, browser});
  ASSERT_TRUE(up_->wait_for_message("its page: ")) << up_->err();
  std::vector<std::string> words{node, page + "/test/arms.mjs", "http://127.0.0.1:" + std::to_string(port()) + "/",
                                 browser, picture()};
  std::vector<std::string> names;
  for (const auto& [arm, urdf] : GetParam().arms) {
    words.push_back(arm + "=" + std::string(HECATON_SOURCE_DIR) + "/deploy/" + urdf);
    names.push_back(arm);
  }
  Process test(words);
  int code = -1;
  {
    const Mover mover([this](const auto& given) { return run(given).code; }, names);
    code = test.wait();
  }
  EXPECT_EQ(code, 0) << test.out() << test.err();
  std::printf("%s", test.out().c_str());
}

INSTANTIATE_TEST_SUITE_P(Cells, LiveArms,
                         testing::Values(DrawnCell{"three_puma.yaml",
                                                   {{"north", "cells/urdf/puma560.urdf"},
                                                    {"west", "cells/urdf/puma560.urdf"},
                                                    {"east", "cells/urdf/puma560.urdf"}}},
                                         DrawnCell{"named/two_scara.yaml",
                                                   {{"left", "robots/irb910sc_055.urdf"},
                                                    {"right", "robots/irb910sc_055.urdf"}}},
                                         DrawnCell{"named/kr6_irb120.yaml",
                                                   {{"kuka", "robots/kr6_r900.urdf"}, {"abb", "robots/irb120.urdf"}}}),
                         [](const auto& one) { return std::filesystem::path(one.param.file).stem().string(); });

/// What the client of npm reads, with one of the sub-protocols.
class LiveFoxglove : public LivePage, public testing::WithParamInterface<const char*> {
 protected:
  [[nodiscard]] Json read_cell() {
    const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
    Process test({HECATON_NODE, page + "/test/foxglove.mjs", "ws://127.0.0.1:" + std::to_string(port()), GetParam()});
    EXPECT_EQ(test.wait(), 0) << test.out() << test.err();
    return Json::parse(test.out(), nullptr, false);
  }
};

TEST_P(LiveFoxglove, ReadsTheStatesThatTheSupervisorHas) {
  const std::string package =
      std::string(HECATON_BIN_DIR) + "/../services/view/page/node_modules/@foxglove/ws-protocol";
  const std::string node = HECATON_NODE;
  HECATON_NEED_FILES({package, node});
  ASSERT_TRUE(up_->wait_for_message("its page: ")) << up_->err();
  ASSERT_EQ(run({"goal", "north", "--named", "ready", "--wait"}).code, 0);
  const Json cell = read_cell();
  ASSERT_TRUE(cell.is_object());
  const Json status = json({"status"});
  for (const Json& arm : status.at("arms")) {
    const std::string name = arm.at("name").get<std::string>();
    const Json& q = arm.at("state").at("q");
    const Json& joints = cell.at("parameters").at(name + ".joints");
    ASSERT_EQ(joints.size(), q.size());
    for (std::size_t i = 0; i < q.size(); ++i) {
      const std::string joint = name + "_" + joints[i].get<std::string>();
      EXPECT_NEAR(cell.at("joints").at(joint).get<double>(), q[i].get<double>(), 1e-4) << joint;
    }
  }
  EXPECT_EQ(cell.at("joints").size(), 18U);
  EXPECT_EQ(cell.at("protocol"), GetParam());
  EXPECT_EQ(cell.at("moving").size(), 18U);
  EXPECT_GE(cell.at("fixed").size(), 6U) << "bases and tools";
  EXPECT_NE(cell.at("robot").get<std::string>().find("<link name=\"north_"), std::string::npos);
  const Json running = entry(cell.at("diagnostics"), "name", "hecaton: cell");
  ASSERT_FALSE(running.is_null());
  EXPECT_EQ(running.at("message"), "running");
  EXPECT_FALSE(entry(cell.at("diagnostics"), "name", "hecaton: planner/north").is_null()) << cell.at("diagnostics");
}

INSTANTIATE_TEST_SUITE_P(Subprotocols, LiveFoxglove, testing::Values("foxglove.sdk.v1", "foxglove.websocket.v1"),
                         [](const auto& one) { return one.index == 0 ? "sdk" : "websocket"; });

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
