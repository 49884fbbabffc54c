#pragma once
/// The page of one cell on the network: its files, its arms, and the states of a feed.

#include <cstdint>
#include <string>

#include "services/config/cell_file.hpp"
#include "services/view/arm_drawing.hpp"
#include "services/view/cell_feed.hpp"
#include "services/view/json.hpp"
#include "services/view/web_server.hpp"

namespace hecaton::services {

/// For one thread.
class PageServer {
 public:
  /// Listens from now on. The references must outlive it. `web.file` is its own. Throws std::runtime_error with a
  /// sentence when the address cannot be used. The times of states are since `began`.
  PageServer(const CellFeed& feed, const config::CellFile& file, const view::Drawings& drawings, WebServerOptions web,
             bus::Clock::time_point began = bus::Clock::now());

  /// Sends what is due, or after a leap of the feed all. `now`: of the steady clock.
  void publish(bus::Clock::time_point now);
  /// A message of another channel than those of publish().
  void publish(Channel channel, const view::Json& message);

  /// A message to one page.
  void send(std::uint64_t client, const view::Json& message);

  [[nodiscard]] std::uint16_t port() const { return server_.port(); }
  [[nodiscard]] std::uint64_t skipped() const { return server_.skipped(); }

 private:
  const CellFeed& feed_;
  const bus::Clock::time_point began_;
  bus::Clock::time_point frame_at_{};
  bus::Clock::time_point status_at_{};
  std::uint64_t obstacle_edition_ = 0;  ///< last published
  std::uint64_t leaps_ = 0;             ///< last published
  WebServer server_;
};

}  // namespace hecaton::services
