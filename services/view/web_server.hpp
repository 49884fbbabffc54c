#pragma once
/// Serves files over HTTP and streams of states over WebSocket, in a thread of its own. It keeps only the newest state
/// of each channel for a client. A client that reads slowly misses states; neither the caller nor another client waits
/// for it.
///
/// It gives messages of clients to its owner (orders.hpp, services/replay), or discards them. A page of another site
/// can neither read the states nor send messages through the browser of a user. The server refuses a request when its
/// header Host is a name other than localhost or this machine's own. It refuses a WebSocket when its Origin is not that
/// Host. A second thread reads files, one after the other: a slow disk does not delay an order. With `certificate` it
/// speaks TLS only, and with `admits` it shows nothing without a token. A sub-protocol (web_session.hpp) may allow
/// further origins for its own WebSockets, at the path "/".

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "services/view/web_session.hpp"

namespace hecaton::services {

/// Messages in the order in which a client gets them. Each message holds the whole state of its channel.
enum class Channel : std::uint8_t { kCell, kControl, kRecording, kObstacles, kPlayback, kStatus, kMotions, kFrame };
inline constexpr std::size_t kChannels = 8;

/// What the server answers to a GET.
struct WebFile {
  std::string type;  ///< MIME type
  std::shared_ptr<const std::string> content;
  bool compressed = false;  ///< `content` is a gzip stream
  /// Instead of `content`: reads it, which may take long; empty: the file is gone. Called in the thread that reads
  /// files, while the server goes on.
  std::function<std::optional<std::string>()> read = {};
};

/// What a server shows to prove its name.
struct WebCertificate {
  std::string chain;  ///< its certificate and those that lead to the authority's, PEM
  std::string key;    ///< private, PEM
};

struct WebServerOptions {
  std::string address = "127.0.0.1";  ///< IPv4 address to listen on
  std::uint16_t port = 0;             ///< 0: any free one
  int most_connections = 128;         ///< HTTP and WebSockets; further ones are closed at once
  int most_of_address = 64;           ///< of these, of one address
  /// Of these, the connections that have not sent a request that is admitted: in all, and of one address. Such a
  /// connection ends after `admission`, and after its first answer.
  int most_unadmitted = 96;
  int most_unadmitted_of_address = 8;
  std::chrono::milliseconds admission{5000};
  std::chrono::milliseconds wrong_token_pause{1000};  ///< before the answer to a request with a wrong token
  std::optional<WebCertificate> certificate;  ///< connections are encrypted (TLS 1.2 or 1.3); a request that is not is
                                              ///< sent to the address with https
  /// This token, of the address "/?watch=TOKEN" or "/?token=TOKEN", admits to files and WebSockets; empty: none is
  /// needed. Called in the thread of the server.
  std::function<bool(std::string_view token)> admits;
  /// The file at a path without query, "/page.js"; empty: there is none. Called in the thread of the server.
  std::function<std::optional<WebFile>(std::string_view path)> file;
  /// Takes a message of a client, at most 4096 bytes long; empty: messages are discarded. Called in the thread of the
  /// server.
  std::function<void(const WebClient& client, std::string_view message)> received;
  /// The client has gone. Called in the thread of the server.
  std::function<void(const WebClient& client)> left;
  /// WebSockets beside those of the page.
  WebProtocol protocol;
};

/// All public functions are thread-safe.
class WebServer {
 public:
  /// Listens from now on. Throws std::runtime_error with a sentence when the address or the certificate cannot be used.
  explicit WebServer(const WebServerOptions& options);
  /// Closes all connections.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Sends `message` to each client that has received the former message of the channel; for each other client it
  /// replaces that one. Clients that connect later get the newest message of each channel. Never blocks.
  void publish(Channel channel, std::string message);
  /// Sends `message` to one client. A client that leaves 64 of them unread is closed. Never blocks.
  void send(std::uint64_t client, std::string message);
  [[nodiscard]] int clients() const;            ///< WebSockets of the page
  [[nodiscard]] std::uint64_t skipped() const;  ///< messages that were replaced before a client got them
  [[nodiscard]] std::uint16_t port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::services
