#pragma once
/// The clients of the Foxglove protocol, what they subscribe to, and what each of them still has to receive.
///
/// A client has at most one waiting message on each channel. A newer one replaces it and is counted: a client that
/// reads slowly misses states, and neither the publisher nor another client waits for it. Answers to a client wait in
/// order, 256 of them and 1 MiB at most; a client that leaves more unread is closed.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/view/foxglove/orders.hpp"
#include "services/view/foxglove/protocol.hpp"
#include "services/view/web_session.hpp"

namespace hecaton::services::foxglove {

struct Client;

struct HubChannel {
  std::string topic;
  std::string type;
  std::string schema;
  bool latched = false;  ///< a late subscriber gets the last message
};

struct HubOptions {
  ServerInfo info;  ///< without capabilities and session
  std::vector<HubChannel> channels;
  Json parameters = Json::array();  ///< {name, value, type?}; they never change
  /// The content of an asset; empty: there is none. Called in WebOpening::background.
  std::function<std::shared_ptr<const std::string>(std::string_view uri)> asset;
  /// Clients that it accepts have services for hold, resume and stop, of the cell and of each of these arms.
  OrderReceiver orders;
  std::string ns;  ///< namespace of the services, "/cell1"
  std::vector<std::string> arms;
};

/// All public functions are thread-safe.
class Hub : public std::enable_shared_from_this<Hub> {
 public:
  explicit Hub(HubOptions options);
  ~Hub();
  Hub(const Hub&) = delete;
  Hub& operator=(const Hub&) = delete;

  /// A client subscribes to the channel, by its index in HubOptions.
  [[nodiscard]] bool wanted(std::size_t channel) const;
  [[nodiscard]] int clients() const;
  /// Messages that were replaced before a client got them.
  [[nodiscard]] std::uint64_t skipped() const;

  /// Offers an encoded message to the subscribers of a channel.
  void publish(std::size_t channel, std::uint64_t unix_ns, std::string message);
  /// Offers the time of the server to all clients.
  void publish_time(std::uint64_t unix_ns);
  /// Passes the answers to orders on to the clients that gave them.
  void deliver_answers();

  [[nodiscard]] std::unique_ptr<WebSession> open(WebOpening opening);

 private:
  class Session;
  struct State;
  /// The first messages to each client.
  struct Greeting {
    std::string info;
    std::string info_with_services;
    std::string channels;
    std::string services;
  };
  // Both with the mutex of the state locked.
  static void send(Client& client, std::string answer, bool text);
  static void finish(Client& client, const std::string& reason);

  const HubOptions options_;
  Greeting greeting_;
  std::shared_ptr<State> state_;  // answers to orders may come after the end of the hub
};

}  // namespace hecaton::services::foxglove
