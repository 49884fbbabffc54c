#pragma once
/// A running cell for clients of the Foxglove WebSocket protocol: Foxglove and Lichtblick. The channels are the topics
/// of hecaton-ros2 with the same messages (docs/reference/ros2.md), so that layouts for these work.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "services/view/arm_drawing.hpp"
#include "services/view/cell_feed.hpp"
#include "services/view/foxglove/hub.hpp"
#include "services/view/foxglove/orders.hpp"
#include "services/view/ros2_scene.hpp"

namespace hecaton::services::foxglove {

/// Pages of this Origin may connect: those that this machine serves or has as a file, desktop programs, and the site of
/// Foxglove. `further`: as a browser sends them, "http://vis.example:8080".
[[nodiscard]] bool is_allowed_origin(std::string_view origin, const std::vector<std::string>& further);

struct CellServerOptions {
  std::vector<std::string> origins;  ///< of further pages that may connect
  OrderReceiver orders = {};         ///< empty: clients only watch
};

/// For one thread.
class CellServer {
 public:
  /// The references must outlive it, and the web server to which protocol() was given.
  CellServer(const CellFeed& feed, const config::CellFile& file, const view::Drawings& drawings,
             CellServerOptions options = {});

  /// For the options of a web server.
  [[nodiscard]] WebProtocol protocol() const;
  /// Sends what is due. `now`: of the steady clock.
  void publish(bus::Clock::time_point now);
  [[nodiscard]] std::uint64_t skipped() const { return hub_->skipped(); }

 private:
  [[nodiscard]] static HubOptions hub_options(const config::CellFile& file, const view::Drawings& drawings,
                                              OrderReceiver orders);

  template <class Message>
  void send(std::size_t channel, const Message& message);
  void send_fixed();
  void send_states(bus::Clock::time_point now);
  void send_markers();
  void send_diagnostics();
  [[nodiscard]] bool due(std::size_t timer, bus::Clock::time_point now, bus::Clock::duration period);

  const CellFeed& feed_;
  const config::CellFile& file_;
  const view::Drawings& drawings_;
  std::vector<std::string> origins_;
  std::shared_ptr<Hub> hub_;
  Ros2Scene scene_;  ///< its topics are the channels
  std::array<bus::Clock::time_point, 5> due_{};
  ros2::Bytes bytes_;
};

}  // namespace hecaton::services::foxglove
