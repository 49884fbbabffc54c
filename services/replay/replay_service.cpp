#include "services/replay/replay_service.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace hecaton::services::replay {
namespace {

using namespace std::chrono_literals;

constexpr auto kLoopPeriod = 10ms;
constexpr auto kPlaybackPeriod = 33ms;
/// A machine that was suspended, or a slow seek, does not make the replay leap.
constexpr bus::Clock::duration kLongestStep = 100ms;

WebServerOptions web_options(const config::View& address, const std::optional<WebProtection>& protection,
                             CommandQueue& commands) {
  WebServerOptions web;
  web.address = address.listen;
  web.port = static_cast<std::uint16_t>(address.port.value_or(0));
  protect(web, protection);
  web.received = [&commands](const WebClient&, std::string_view message) { commands.push(message); };
  return web;
}

bool is_seek(std::string_view command) {
  return command.find("\"seek\"") != std::string_view::npos;
}

}  // namespace

void CommandQueue::push(std::string_view command) {
  const std::scoped_lock lock(mutex_);
  if (!commands_.empty() && is_seek(commands_.back()) && is_seek(command)) commands_.pop_back();
  if (commands_.size() < kMost) commands_.emplace_back(command);
}

std::vector<std::string> CommandQueue::take() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(commands_, {});
}

ReplayService::ReplayService(const RecordedFiles& files, Replay& replay, const config::View& address,
                             const ShutdownSignal& shutdown)
    : replay_(replay),
      address_(address),
      protection_(protection_of(address)),
      loop_(kLoopPeriod, shutdown),
      page_(replay, files.cell, files.drawings, web_options(address, protection_, commands_)) {
  address_.port = page_.port();
  page_.publish(Channel::kRecording, replay_.recording_json());
}

std::string ReplayService::url() const {
  return admitting_url(config::view_url(address_, 0), protection_);
}

void ReplayService::run() {
  auto before = bus::Clock::now();
  auto playback_at = before;
  view::Json published;
  while (loop_.next()) {
    const auto now = loop_.now();
    const std::vector<std::string> commands = commands_.take();
    for (const std::string& command : commands) replay_.command(command);
    replay_.advance(std::min<bus::Clock::duration>(now - before, kLongestStep));
    before = now;
    if (now >= playback_at || !commands.empty()) {
      playback_at = now + kPlaybackPeriod;
      view::Json playback = replay_.playback_json();
      if (playback != published || !commands.empty()) page_.publish(Channel::kPlayback, playback);
      published = std::move(playback);
    }
    page_.publish(now);
  }
}

}  // namespace hecaton::services::replay
