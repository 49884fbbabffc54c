/// hecaton replay and hecaton explain on the recording of a live cell.
///
/// The page shows what the messages say, and what a live page has shown.

#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <thread>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>

#include "services/bus/recorded_sample.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "tests/cell/cli/live_cell.hpp"
#include "tests/support/needed_files.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/view/web_client.hpp"

namespace hecaton::test {
namespace {

using namespace services::recorder;

/// A decoded message with the time when it was received [ns].
template <class T>
struct Received {
  std::uint64_t at = 0;
  T value;
};
template <class T>
using Messages = std::vector<Received<T>>;

/// The messages of a recording, by an own way through the file.
struct Recorded {
  explicit Recorded(const std::string& path) {
    McapVisitor visitor;
    visitor.message = [this](const McapMessage& message) {
      if (!message.channel->schema) return;
      begin = begin == 0 ? message.log_time : begin;
      end = std::max(end, message.log_time);
      take(message, states);
      take(message, modes);
      take(message, goals);
    };
    EXPECT_TRUE(read_mcap(path, visitor).whole());
  }
  template <class T>
  static void take(const McapMessage& message, Messages<T>& to) {
    if (message.channel->topic != bus::Topic<T>::kInfo.name) return;
    const auto decoded = bus::decode_recorded<T>(message.data);
    ASSERT_TRUE(decoded.value);
    to.push_back({message.log_time, *decoded.value});
  }
  /// The newest message until a time for which `is_right`; null: none.
  template <class T, class Is>
  static const Received<T>* newest(const Messages<T>& messages, std::uint64_t time, const Is& is_right) {
    const Received<T>* found = nullptr;
    for (const Received<T>& message : messages) {
      if (message.at <= time && is_right(message.value)) found = &message;
    }
    return found;
  }

  [[nodiscard]] double length() const { return static_cast<double>(end - begin) * 1e-9; }  ///< [s]

  std::uint64_t begin = 0;
  std::uint64_t end = 0;
  Messages<msg::ArmState> states;
  Messages<msg::CellMode> modes;
  Messages<msg::GoalStatus> goals;
};

/// A page of a replay.
class ReplayPage {
 public:
  explicit ReplayPage(std::uint16_t port) : client_(port) {
    recording_ = client_.wait_for("recording", [](const Json&) { return true; });
  }
  [[nodiscard]] const Json& recording() const { return recording_; }

  struct Shown {
    Json frame;
    Json status;
  };
  /// The state at a time since the begin [ms].
  Shown seek(double at) {
    client_.write(Json{{"op", "seek"}, {"at", at}}.dump());
    client_.wait_for("playback",
                     [&](const Json& playback) { return std::abs(playback.at("at").get<double>() - at) < 1e-3; });
    const double wall = std::floor(recording_.at("begin").get<double>() + at);
    Shown shown;
    shown.status = client_.wait_for(
        "status", [&](const Json& status) { return std::abs(status.at("wall").get<double>() - wall) <= 1.0; });
    // Each leap has a number, so that this frame belongs to this seek.
    ++leaps_;
    shown.frame = client_.wait_for("frame", [&](const Json& frame) { return frame.at("leaps") == leaps_; });
    return shown;
  }

 private:
  WebSocketClient client_;
  Json recording_;
  std::uint64_t leaps_ = 1;  // `hecaton replay` seeks to --at
};

std::uint16_t port_in(const std::string& url) {
  return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
}

/// Why each arm stands and its goal, as a page shows them.
Json reasons_in(const Json& status) {
  Json reasons{{"mode", status.at("mode")}};
  for (const Json& arm : status.at("arms")) {
    const Json& goal = arm.at("goal");
    reasons[arm.at("name").get<std::string>()] = {arm.at("mode"), arm.at("drive"), arm.at("waiting"),
                                                  goal.is_null() ? goal : Json{goal.at("id"), goal.at("state")}};
  }
  return reasons;
}

class ReplayedCell : public LiveCell {
 protected:
  [[nodiscard]] std::vector<std::string> up_options() const override { return {"--view"}; }

  /// Records goals, a hold and a resume. Returns what the live page has shown meanwhile.
  std::vector<Json> record() {
    EXPECT_TRUE(up_->wait_for_message("its page: ")) << up_->err();
    const auto recorder = start({"record", kThreePuma, "-o", path_});
    EXPECT_TRUE(recorder->wait_for_message("recording cell")) << recorder->err();
    std::atomic<bool> done = false;
    std::vector<Json> statuses;
    std::thread page([&] {
      WebSocketClient client(static_cast<std::uint16_t>(8000 + domain_.number()));
      while (!done) statuses.push_back(client.wait_for("status", [](const Json&) { return true; }));
    });
    EXPECT_EQ(run({"goal", "north", "--named", "ready", "--wait"}).code, 0);
    EXPECT_EQ(run({"goal", "west", "--named", "ready"}).code, 0);
    EXPECT_EQ(run({"hold"}).code, 0);
    EXPECT_EQ(run({"resume"}).code, 0);
    EXPECT_EQ(run({"goal", "north", "--named", "home", "--wait"}).code, 0);
    EXPECT_EQ(run({"goal", "east", "--named", "ready", "--wait"}).code, 0);
    EXPECT_EQ(run({"goal", "west", "--named", "home", "--wait"}).code, 0);
    done = true;
    page.join();
    recorder->signal(SIGINT);
    EXPECT_EQ(recorder->wait(), 0) << recorder->err();
    return statuses;
  }
  std::unique_ptr<Process> replay() {
    auto process =
        std::make_unique<Process>(std::vector<std::string>{std::string(HECATON_BIN_DIR) + "/hecaton", "replay", path_});
    EXPECT_TRUE(process->wait_for_output("\n")) << process->err();
    return process;
  }

  TemporaryFolder folder_;
  std::string path_ = folder_.path("run.mcap");
};

TEST_F(ReplayedCell, ShowsWhatTheMessagesSayAndALivePageHasShown) {
  const std::vector<Json> live = record();
  const Recorded recorded(path_);
  ASSERT_GT(recorded.states.size(), 500U);
  const auto server = replay();
  ReplayPage page(port_in(server->out()));
  const double length = page.recording().at("length").get<double>();
  EXPECT_NEAR(length, static_cast<double>(recorded.end - recorded.begin) * 1e-6, 1e-3);
  EXPECT_EQ(page.recording().at("notes"), Json::array());

  // What the messages say, at times in no order.
  const char* arms[] = {"north", "west", "east"};
  for (const double share : {0.9, 0.2, 0.5, 0.21, 1.0, 0.35, 0.7, 0.05, 0.6, 0.8}) {
    const double at = std::round(share * length * 1e3) * 1e-3;
    SCOPED_TRACE(at);
    const ReplayPage::Shown shown = page.seek(at);
    const auto time = recorded.begin + static_cast<std::uint64_t>(std::llround(at * 1e6));
    for (std::size_t i = 0; i < 3; ++i) {
      const auto* state =
          Recorded::newest(recorded.states, time, [&](const msg::ArmState& value) { return value.arm() == arms[i]; });
      const Json& drawn = shown.frame.at("arms")[i];
      ASSERT_EQ(drawn[0].is_null(), state == nullptr);
      if (state == nullptr) continue;
      EXPECT_NEAR(drawn[0].get<double>(), static_cast<double>(time - state->at) * 1e-6, 0.051) << "the age [ms]";
      for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(drawn[1][k].get<double>(), state->value.q()[k], 6e-6);
      const auto* goal = Recorded::newest(recorded.goals, time, [&](const msg::GoalStatus& value) {
        return value.arm() == arms[i] && value.state() != msg::GoalState::GOAL_REPLACED;
      });
      const Json& shown_goal = shown.status.at("arms")[i].at("goal");
      ASSERT_EQ(shown_goal.is_null(), goal == nullptr);
      if (goal != nullptr) {
        EXPECT_EQ(shown_goal.at("id"), goal->value.goal());
        EXPECT_NEAR(shown_goal.at("elapsed").get<double>(), goal->value.elapsed(), 0.051);
      }
    }
    const auto* mode = Recorded::newest(recorded.modes, time, [](const msg::CellMode&) { return true; });
    ASSERT_NE(mode, nullptr);
    EXPECT_EQ(shown.status.at("mode"), mode->value.mode() == msg::Mode::MODE_RUN ? "run" : "hold");
  }

  // What the live page has shown. Page and recorder receive a message at different times, on a busy machine by much.
  // So one of the compared instants may belong to a short state that only one of them has seen.
  const double begin = page.recording().at("begin").get<double>();
  std::vector<std::pair<double, const Json*>> shown_live;  // [ms]
  for (const Json& status : live) {
    const double at = status.at("wall").get<double>() - begin;
    // The live page was there before the recorder.
    if (at >= 3500.0 && at <= length - 200.0) shown_live.emplace_back(at, &status);
  }
  ASSERT_GE(shown_live.size(), 5U);
  std::string differences;
  std::size_t differing = 0;
  for (std::size_t i = 0; i < shown_live.size(); i += std::max<std::size_t>(1, shown_live.size() / 20)) {
    const auto& [at, status] = shown_live[i];
    bool same = false;
    for (double by = 0.0; by <= 400.0 && !same; by += 20.0) {
      same = reasons_in(page.seek(at + by).status) == reasons_in(*status) ||
             reasons_in(page.seek(at - by).status) == reasons_in(*status);
    }
    differing += same ? 0 : 1;
    if (same) continue;
    std::ostringstream difference;
    difference << at << " ms\nlive   " << reasons_in(*status) << "\nreplay " << reasons_in(page.seek(at).status)
               << "\n";
    differences += difference.str();
  }
  EXPECT_LE(differing, 1U) << differences;

  // The marks: goals, the hold and the resume.
  std::multimap<std::string, std::string> marks;
  for (const Json& mark : page.recording().at("marks")) marks.emplace(mark.at("kind"), mark.at("text"));
  EXPECT_GE(marks.count("goal"), 4U);
  EXPECT_GE(marks.count("mode"), 3U);
  server->signal(SIGTERM);
  EXPECT_EQ(server->wait(), 0) << server->err();

  const Ran explained = run_hecaton({"explain", path_, "--arm", "north", "--at", "2"});
  EXPECT_EQ(explained.code, 0) << explained.err;
  EXPECT_NE(explained.out.find("The order for north is"), std::string::npos) << explained.out;
}

TEST_F(ReplayedCell, IsPlayedInABrowser) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  const std::string browser = "/usr/bin/chromium";
  HECATON_NEED_FILES({page + "/node_modules/playwright-core", node, browser});
  record();
  const auto server = replay();
  const std::string url = "http://127.0.0.1:" + std::to_string(port_in(server->out())) + "/";
  Process test({node, page + "/test/replay.mjs", url, browser});
  EXPECT_EQ(test.wait(), 0) << test.out() << test.err();
}

/// A recording of a simulation of many ready robots on a grid.
class ManyArms : public testing::TestWithParam<int> {};

TEST_P(ManyArms, AreDrawnByShortScripts) {
  const std::string page = std::string(HECATON_BIN_DIR) + "/../services/view/page";
  const std::string node = HECATON_NODE;
  const std::string browser = "/usr/bin/chromium";
  HECATON_NEED_FILES({page + "/node_modules/playwright-core", node, browser});
  constexpr std::array kRobots{"ur5e", "panda", "irb120", "iiwa7", "gp7"};
  constexpr int kColumns = 6;
  std::string cell = "name: many\ntasks: {pose_sequence: [ready, home]}\narms:\n";
  for (int i = 0; i < GetParam(); ++i) {
    cell += "  - {name: arm" + std::to_string(i) + ", robot: " + kRobots[static_cast<std::size_t>(i) % kRobots.size()] +
            ", base: {xyz: [" + std::to_string(1.4 * (i % kColumns)) + ", " + std::to_string(1.4 * (i / kColumns)) +
            ", 0]}}\n";
  }
  const TemporaryFolder folder;
  const std::string recording = folder.path("many.mcap");
  const Ran simulated =
      run_hecaton({"simulate", folder.write("many.yaml", cell), "--tasks", "1", "--seed", "3", "--record", recording});
  ASSERT_LE(simulated.code, 1) << simulated.err;  // whether all goals are reached matters not
  Process server({std::string(HECATON_BIN_DIR) + "/hecaton", "replay", recording, "--port", "0"});
  ASSERT_TRUE(server.wait_for_output("\n")) << server.err();
  const std::string url = "http://127.0.0.1:" + std::to_string(port_in(server.out())) + "/";
  std::vector<std::string> words{node, page + "/test/frames.mjs", url, browser, std::to_string(GetParam())};
  if (const char* pictures = std::getenv("HECATON_PICTURES")) {
    words.push_back(std::string(pictures) + "/many-" + std::to_string(GetParam()) + ".png");
  }
  Process test(words);
  EXPECT_EQ(test.wait(), 0) << test.out() << test.err();
  std::printf("%s", test.out().c_str());
}

INSTANTIATE_TEST_SUITE_P(Cells, ManyArms, testing::Values(3, 10, 30), testing::PrintToStringParamName());

std::string content_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST_F(ReplayedCell, IsDrawnAsPicturesAndAsAFilm) {
  HECATON_NEED_FILES({"/usr/bin/chromium"});
  record();
  const double length = Recorded(path_).length();
  const auto render = [&](const std::string& file, std::vector<std::string> more) {
    std::vector<std::string> words{"render", path_, "-o", folder_.path(file), "--width", "320", "--height", "200"};
    words.insert(words.end(), more.begin(), more.end());
    const Ran ran = run_hecaton(words);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return content_of(folder_.path(file));
  };
  const std::string early = render("early.png", {"--at", std::to_string(0.3 * length)});
  const std::string late = render("late.png", {"--at", std::to_string(0.9 * length), "--layers", "trails,goals"});
  const std::string size("\x00\x00\x01\x40\x00\x00\x00\xc8", 8);  // 320 × 200, big-endian
  for (const std::string& picture : {early, late}) {
    EXPECT_EQ(picture.substr(0, 4), "\x89PNG");
    EXPECT_EQ(picture.substr(16, 8), size);
  }
  EXPECT_NE(early, late) << "the arms have moved";
  EXPECT_EQ(render("again.png", {"--at", std::to_string(0.3 * length)}), early)
      << "the same time gives the same picture";
  // Of some times, time + (length - time) is rounded up to more than the length.
  double rounded = 0.0;
  for (double at = 0.001; at < length && rounded == 0.0; at += 0.001) {
    const double parsed = std::stod(std::to_string(at));
    if (parsed + (length - parsed) > length) rounded = parsed;
  }
  render("rounded.png", {"--at", std::to_string(rounded)});
  const std::string film = render("film.webm", {"--at", "1", "--duration", "1", "--fps", "5"});
  EXPECT_EQ(film.substr(0, 4), "\x1a\x45\xdf\xa3") << "the begin of a Matroska file";
  EXPECT_NE(film.find("webm"), std::string::npos);
  EXPECT_NE(film.find("V_VP9"), std::string::npos);
}

TEST(Render, DrawsACellAsItStarts) {
  HECATON_NEED_FILES({"/usr/bin/chromium"});
  const TemporaryFolder folder;
  const std::string cell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";
  const std::string file = folder.write("cell.png", "the former picture");
  const Ran ran = run_hecaton({"render", cell, "-o", file, "--width", "320", "--height", "200", "--view", "top"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(content_of(file).substr(0, 4), "\x89PNG");
}

TEST(Render, SaysWhatItNeeds) {
  const TemporaryFolder folder;
  const std::string cell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";
  const std::string recording = folder.write("text.mcap", "no recording");
  const auto refused = [&](std::vector<std::string> words, int code, const std::string& part) {
    words.insert(words.begin(), "render");
    const Ran ran = run_hecaton(std::move(words));
    EXPECT_EQ(ran.code, code) << ran.err;
    EXPECT_NE(ran.err.find(part), std::string::npos) << ran.err;
  };
  refused({cell}, 2, "--file");
  refused({cell, "-o", "cell.gif"}, 3, "must end in .png for a picture or in .webm for a film");
  refused({cell, "-o", "cell.webm"}, 3, "record the cell, and render the recording");
  refused({cell, "-o", folder.path("none/cell.png")}, 3, "none/cell.png' cannot be written: No such file or directory");
  refused({cell, "-o", "cell.png", "--at", "1"}, 3, "record the cell");
  refused({cell, cell, "-o", "cell.png"}, 3, "one cell file");
  refused({cell, "-o", "cell.png", "--layers", "ghosts"}, 2, "ghosts");
  refused({recording, "-o", "x.png", "--duration", "1"}, 3, "--duration is for films");
  refused({recording, "-o", "x.webm", "--fps", "0"}, 3, "--fps");
  const char* path = std::getenv("PATH");
  const std::string former = path == nullptr ? "" : path;
  setenv("PATH", folder.path("").c_str(), 1);
  refused({cell, "-o", folder.path("x.png")}, 3, "install chromium");
  setenv("PATH", former.c_str(), 1);
}

TEST(Replay, SaysWhatItNeeds) {
  const TemporaryFolder folder;
  const auto refused = [&](std::vector<std::string> words, int code, const std::string& part) {
    const Ran ran = run_hecaton(std::move(words));
    EXPECT_EQ(ran.code, code) << ran.err;
    EXPECT_NE(ran.err.find(part), std::string::npos) << ran.err;
  };
  const std::string text = folder.write("text.mcap", "no recording");
  refused({"replay"}, 2, "FILE");
  refused({"replay", folder.path("missing.mcap")}, 3, "missing.mcap");
  refused({"replay", text}, 3, "is no MCAP file");
  refused({"replay", text, "--listen", "everywhere"}, 3, "--listen");
  refused({"replay", text, "--port", "70000"}, 3, "--port");
  refused({"replay", text, "--at", "-1"}, 3, "--at");
  refused({"explain", text}, 2, "--arm");
  refused({"explain", text, "--arm", "north"}, 3, "is no MCAP file");
}

}  // namespace
}  // namespace hecaton::test
