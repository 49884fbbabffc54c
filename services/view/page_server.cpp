#include "services/view/page_server.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "services/view/cell_json.hpp"
#include "services/view/motion_json.hpp"
#include "services/view/page.hpp"
#include "services/view/state_json.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

constexpr auto kFramePeriod = 33ms;    // the page interpolates between two frames
constexpr auto kStatusPeriod = 200ms;  // for people to read

std::string text_of(const view::Json& message) {
  return message.dump(-1, ' ', false, view::Json::error_handler_t::replace);
}

std::optional<std::string> content_of_mesh(const std::filesystem::path& path) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return std::nullopt;  // a pipe has no end
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
}

std::optional<WebFile> file_at(const view::Drawings& drawings, std::string_view path) {
  for (const view::ArmDrawing& arm : drawings.arms()) {
    if (arm.has_visuals && path == arm.url) return WebFile{"application/xml", std::make_shared<std::string>(arm.urdf)};
  }
  if (const auto mesh = drawings.mesh(path)) {
    return WebFile{"application/octet-stream", nullptr, false, [file = *mesh] { return content_of_mesh(file); }};
  }
  return view::page_file(path);
}

WebServerOptions with_files(WebServerOptions web, const view::Drawings& drawings) {
  web.file = [&drawings](std::string_view path) { return file_at(drawings, path); };
  return web;
}

}  // namespace

PageServer::PageServer(const CellFeed& feed, const config::CellFile& file, const view::Drawings& drawings,
                       WebServerOptions web, bus::Clock::time_point began)
    : feed_(feed), began_(began), server_(with_files(std::move(web), drawings)) {
  publish(Channel::kCell, view::cell_json(file, drawings.arms()));
}

void PageServer::publish(Channel channel, const view::Json& message) {
  server_.publish(channel, text_of(message));
}

void PageServer::send(std::uint64_t client, const view::Json& message) {
  server_.send(client, text_of(message));
}

void PageServer::publish(bus::Clock::time_point now) {
  if (feed_.state().obstacle_edition() != obstacle_edition_) {
    obstacle_edition_ = feed_.state().obstacle_edition();
    publish(Channel::kObstacles, view::obstacles_json(feed_.state()));
  }
  if (server_.clients() == 0) return;  // a page that connects gets the newest within a period
  const bool leapt = feed_.leaps() != leaps_;
  leaps_ = feed_.leaps();
  if (now >= status_at_ || leapt) {
    status_at_ = now + kStatusPeriod;
    publish(Channel::kStatus, view::status_json(feed_, now - began_));
    publish(Channel::kMotions, view::motions_json(feed_));
  }
  if (now >= frame_at_ || leapt) {
    frame_at_ = now + kFramePeriod;
    publish(Channel::kFrame, view::frame_json(feed_, now - began_));
  }
}

}  // namespace hecaton::services
