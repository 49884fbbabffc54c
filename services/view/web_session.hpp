#pragma once
/// A WebSocket with a sub-protocol of its own, apart from the stream of the page. web_server.hpp opens the sessions.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::services {

/// A WebSocket.
struct WebClient {
  std::uint64_t number = 0;  ///< never used again
  std::string address;       ///< "127.0.0.1:40312"
};

/// A WebSocket message to a client: `head` and then `body`.
struct WebFrame {
  std::string head;
  std::shared_ptr<const std::string> body;  ///< shared with other clients; null: none
  bool text = false;                        ///< UTF-8; otherwise binary
};

/// One client. All functions are called in the thread of the server.
class WebSession {
 public:
  WebSession() = default;
  virtual ~WebSession() = default;
  WebSession(const WebSession&) = delete;
  WebSession& operator=(const WebSession&) = delete;

  virtual void received(std::string_view message, bool text) = 0;
  /// The next message to the client, once it has taken the former one; empty: none for now.
  [[nodiscard]] virtual std::optional<WebFrame> next() = 0;
  /// Why the connection shall be closed when next() is empty; nothing: it shall not.
  [[nodiscard]] virtual std::optional<std::string> end() const = 0;
};

/// How a client has opened its session.
struct WebOpening {
  std::function<void()> wake;  ///< next() has something. It may be called in any thread until the server is destroyed
  WebClient client = {};
  std::string token = {};  ///< of "/?token=…" in its address; empty: none
  /// Calls a job in the thread that reads files, later. False: too many wait. It is called in the thread of the server.
  /// Empty: there is no such thread.
  std::function<bool(std::function<void()> job)> background = {};
};

struct WebProtocol {
  std::vector<std::string> names;   ///< of the sub-protocol, the preferred one first; empty: there is none
  std::size_t longest_message = 0;  ///< from a client [byte]
  /// A page of this Origin may open a session, beside the server's own pages and programs that send no Origin.
  std::function<bool(std::string_view origin)> allows;
  std::function<std::unique_ptr<WebSession>(WebOpening opening)> open;
};

}  // namespace hecaton::services
