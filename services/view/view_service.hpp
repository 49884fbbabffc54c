#pragma once
/// The service hecaton-view: receives the states of a cell and serves a page that shows them.

#include <filesystem>
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
#include "services/view/foxglove/cell_server.hpp"
#include "services/view/goal_preview.hpp"
#include "services/view/live_feed.hpp"
#include "services/view/orders.hpp"
#include "services/view/page_server.hpp"
#include "services/view/web_protection.hpp"

namespace hecaton::services {

/// What pages may order.
struct ViewOrders {
  bool control = false;  ///< one page at a time, with the token, controls
  bool stop = true;      ///< every page may stop the cell
};

class ViewService {
 public:
  /// Joins the cell and listens. `file` and `shutdown` must outlive it. Throws std::runtime_error with a sentence, also
  /// when the address cannot be used. As a service of an agent it reports that in its heartbeats instead, and run()
  /// tries again each second. With tokens it then writes its address to a file of the run, never to its output or log;
  /// a restarted service keeps its tokens. A page that other machines can reach is encrypted and has a token. In a
  /// secured cell orders need an identity of the role operator. Without it the pages only show the cell; a view that a
  /// person starts with control throws.
  ViewService(const config::CellFile& file, const ServiceOptions& options, const config::View& view,
              const ViewOrders& orders, std::vector<std::string> foxglove_origins, const ShutdownSignal& shutdown);

  /// Returns when `shutdown` was requested.
  void run();

  /// "http://127.0.0.1:8042/"
  [[nodiscard]] std::string url() const;
  /// The address with its tokens. Browsers send none of control in requests. As url() when no token is needed.
  [[nodiscard]] std::string url_with_tokens() const;

 private:
  /// Those of clients that have shown the token go to orders_.
  [[nodiscard]] foxglove::OrderReceiver foxglove_orders();
  void listen(bus::Clock::time_point now);
  void answer_pages();
  void answer_previews();
  void publish_heartbeat();

  const config::CellFile& file_;
  WebServerOptions web_;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  PeriodicLoop loop_;
  std::optional<HeartbeatPublisher> heartbeat_;  // of a service of an agent
  view::Drawings drawings_;
  LiveFeed feed_;
  foxglove::CellServer foxglove_;
  std::filesystem::path token_file_;  // of a service of an agent with tokens; empty: none
  std::string token_;                 // of control; empty: no page may control
  std::optional<WebProtection> protection_;
  std::unique_ptr<Orders> orders_;
  std::optional<GoalPreview> preview_;  // of a view that has control
  std::unique_ptr<PageServer> server_;  // calls orders_. Empty: the address is in use
  std::optional<std::string> refusal_;  // why
  bus::Clock::time_point listen_at_{};
};

}  // namespace hecaton::services
