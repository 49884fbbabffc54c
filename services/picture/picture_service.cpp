#include "services/picture/picture_service.hpp"

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include <unistd.h>

#include "services/agent/child_process.hpp"
#include "services/picture/standing_cell.hpp"
#include "services/replay/replay_service.hpp"
#include "services/runtime/temporary_folder.hpp"
#include "services/view/page_server.hpp"
#include "services/view/token_file.hpp"

namespace hecaton::services::picture {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using view::Json;

constexpr std::size_t kLongestPiece = 2U << 20U;  // of a file, from the page [byte]
constexpr std::size_t kLongestFile = 1U << 30U;   // [byte]
/// A browser that draws without a graphics card may need this long for its first frame, or between two.
constexpr auto kPatience = 120s;
constexpr auto kPeriod = 5ms;

/// What the page has sent. Thread-safe.
class Inbox {
 public:
  struct News {
    std::size_t frame = 0;  ///< the last one drawn, from 1
    std::size_t frames = 0;
    std::size_t received = 0;              ///< messages
    std::optional<std::string> failure;    ///< a sentence
    std::optional<std::string> file = {};  ///< whole
  };

  void take(std::string_view message, bool text) {
    const std::scoped_lock lock(mutex_);
    ++news_.received;
    if (!text) {
      if (bytes_.size() + message.size() > kLongestFile)
        news_.failure = "the browser sends more than 1 GiB";
      else
        bytes_ += message;
    } else {
      take_note(Json::parse(message, nullptr, false));
    }
    changed_.notify_all();
  }
  [[nodiscard]] News wait(std::chrono::milliseconds limit, std::size_t known) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, limit, [&] { return news_.received != known; });
    return news_;
  }

 private:
  void take_note(const Json& note) {
    if (!note.is_object()) return;
    if (note.contains("failed")) {
      news_.failure = "the browser says: " + note["failed"].dump(-1, ' ', false, Json::error_handler_t::replace);
    } else if (note.contains("done") && note["done"].is_number_unsigned()) {
      if (note["done"].get<std::size_t>() == bytes_.size() && !bytes_.empty())
        news_.file = bytes_;
      else
        news_.failure = "the browser has sent a part of the picture only";
    } else if (note.value("frame", Json()).is_number_unsigned() && note.value("of", Json()).is_number_unsigned()) {
      news_.frame = note["frame"].get<std::size_t>();
      news_.frames = note["of"].get<std::size_t>();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::string bytes_;
  News news_;
};

/// The WebSocket over which the page sends its picture.
class PictureSession : public WebSession {
 public:
  PictureSession(Inbox& inbox, bool accepted) : inbox_(inbox), accepted_(accepted) {}
  void received(std::string_view message, bool text) override {
    if (accepted_) inbox_.take(message, text);
  }
  [[nodiscard]] std::optional<WebFrame> next() override { return std::nullopt; }
  [[nodiscard]] std::optional<std::string> end() const override {
    return accepted_ ? std::nullopt : std::optional<std::string>("another program's page");
  }

 private:
  Inbox& inbox_;
  bool accepted_;
};

WebServerOptions web_options(Inbox& inbox, replay::CommandQueue& commands, const std::string& token) {
  WebServerOptions web;
  web.received = [&commands](const WebClient&, std::string_view message) { commands.push(message); };
  web.protocol.names = {"hecaton.picture"};
  web.protocol.longest_message = kLongestPiece;
  web.protocol.allows = [](std::string_view) { return false; };
  web.protocol.open = [&inbox, token](const WebOpening& opening) {
    return std::make_unique<PictureSession>(inbox, same_token(opening.token, token));
  };
  return web;
}

std::string decimals(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string address_of(std::uint16_t port, const std::string& token, const std::optional<Recorded>& recorded,
                       const PictureOptions& options) {
  std::string layers;
  for (const std::string& layer : options.layers) layers += (layers.empty() ? "" : ",") + layer;
  std::string address = "http://127.0.0.1:" + std::to_string(port) + "/?picture=" + (options.film ? "webm" : "png") +
                        "&token=" + token + "&view=" + options.view + "&theme=" + (options.dark ? "dark" : "light") +
                        "&layers=" + layers + "&width=" + std::to_string(options.width) +
                        "&height=" + std::to_string(options.height);
  if (recorded) address += "&at=" + decimals(recorded->from * 1e3);
  if (recorded && options.film) {
    address += "&until=" + decimals(recorded->until * 1e3) + "&fps=" + decimals(options.frame_rate) +
               "&speed=" + decimals(options.speed);
  }
  return address;
}

ChildCommand browser_command(const std::string& address, const PictureOptions& options,
                             const std::filesystem::path& folder) {
  ChildCommand command;
  command.program = find_browser();
  command.log = folder / "log";
  command.arguments = {"--headless=new",
                       "--user-data-dir=" + (folder / "profile").string(),
                       "--no-first-run",
                       "--no-default-browser-check",
                       "--disable-extensions",
                       "--disable-dev-shm-usage",
                       "--enable-unsafe-swiftshader",
                       "--force-device-scale-factor=1",
                       "--hide-scrollbars",
                       "--window-size=" + std::to_string(options.width) + "," + std::to_string(options.height)};
  // Chromium refuses to run as root with its sandbox. It opens this program's own page only.
  if (geteuid() == 0) command.arguments.emplace_back("--no-sandbox");
  command.arguments.push_back(address);
  return command;
}

/// The last lines that the browser has printed.
std::string last_words(const std::filesystem::path& log) {
  std::ifstream stream(log);
  std::stringstream all;
  all << stream.rdbuf();
  std::string text = all.str();
  constexpr std::size_t kMost = 400;
  if (text.size() > kMost) text = "…" + text.substr(text.size() - kMost);
  return text.empty() ? "" : ": " + text;
}

}  // namespace

std::string find_browser() {
  constexpr std::array kNames{"chromium", "chromium-browser", "google-chrome", "google-chrome-stable"};
  const char* path = std::getenv("PATH");
  for (const char* name : kNames) {
    std::stringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');) {
      const std::string program = folder + "/" + name;
      if (!folder.empty() && access(program.c_str(), X_OK) == 0) return program;
    }
  }
  throw std::runtime_error("no browser was found on the PATH: install chromium (apt install chromium)");
}

std::optional<std::string> take_picture(const config::CellFile& cell, const view::Drawings& drawings,
                                        const std::optional<Recorded>& recorded, const PictureOptions& options,
                                        const std::function<void(std::size_t, std::size_t)>& progress,
                                        const std::function<bool()>& interrupted) {
  Inbox inbox;
  replay::CommandQueue commands;
  const std::string token = random_token();
  const StandingCell standing(cell);
  const CellFeed& feed = recorded ? static_cast<const CellFeed&>(recorded->replay) : standing;
  PageServer page(feed, cell, drawings, web_options(inbox, commands, token));
  if (recorded) page.publish(Channel::kRecording, recorded->replay.recording_json());

  const TemporaryFolder folder;
  ChildProcess browser(browser_command(address_of(page.port(), token, recorded, options), options, folder.path()));
  Inbox::News news;
  for (auto heard = Clock::now(); !interrupted();) {
    for (const std::string& command : commands.take()) {
      if (!recorded) continue;
      recorded->replay.command(command);
      page.publish(Channel::kPlayback, recorded->replay.playback_json());
    }
    page.publish(Clock::now());
    const std::size_t before = news.received;
    news = inbox.wait(kPeriod, before);
    if (news.received != before) heard = Clock::now();
    if (news.frames > 0) progress(news.frame, news.frames);
    if (news.file) return news.file;
    if (news.failure) throw std::runtime_error("no picture was made: " + *news.failure);
    if (const auto error = browser.poll_start(); error && *error != 0) {
      throw std::runtime_error(start_failure(find_browser(), *error));
    }
    if (browser.poll_end()) throw std::runtime_error("the browser has ended" + last_words(folder.path() / "log"));
    if (Clock::now() - heard > kPatience) {
      throw std::runtime_error("the browser draws nothing for " + std::to_string(kPatience.count()) + " s" +
                               last_words(folder.path() / "log"));
    }
  }
  return std::nullopt;
}

}  // namespace hecaton::services::picture
