#pragma once
/// The service hecaton-view: receives the states of a cell and serves a page that shows them.

#include <memory>
#include <optional>
#include <string>

#include "services/bus/participant.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/heartbeat_publisher.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/shutdown.hpp"
#include "services/view/arm_drawing.hpp"
#include "services/view/live_feed.hpp"
#include "services/view/page_server.hpp"

namespace hecaton::services {

class ViewService {
 public:
  /// Joins the cell and listens. `file` and `shutdown` must outlive it. Throws std::runtime_error with a sentence, also
  /// when the address cannot be used. As a service of an agent it reports that in its heartbeats instead, and run()
  /// tries again each second.
  ViewService(const config::CellFile& file, const ServiceOptions& options, const config::View& view,
              const ShutdownSignal& shutdown);

  /// Returns when `shutdown` was requested.
  void run();

  /// "http://127.0.0.1:8042/"
  [[nodiscard]] std::string url() const;

 private:
  void listen(bus::Clock::time_point now);
  void publish_heartbeat();

  const config::CellFile& file_;
  WebServerOptions web_;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  PeriodicLoop loop_;
  std::optional<HeartbeatPublisher> heartbeat_;  // of a service of an agent
  view::Drawings drawings_;
  LiveFeed feed_;
  std::unique_ptr<PageServer> server_;  // empty: the address is in use
  std::string refusal_;                 // why
  bus::Clock::time_point listen_at_{};
};

}  // namespace hecaton::services
