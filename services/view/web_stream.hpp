#pragma once
/// A connection of web_server.cpp, encrypted or not: an asynchronous stream of Boost.Beast.

#include <cstddef>
#include <utility>
#include <variant>

#include <boost/asio/async_result.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/teardown.hpp>

#include "services/view/web_server.hpp"

namespace hecaton::services {

namespace asio = boost::asio;
namespace beast = boost::beast;
using tcp = asio::ip::tcp;

/// Throws std::runtime_error with a sentence when OpenSSL takes the certificate or the key not.
[[nodiscard]] asio::ssl::context tls_context(const WebCertificate& certificate);

class WebStream {
 public:
  using executor_type = beast::tcp_stream::executor_type;

  explicit WebStream(tcp::socket socket) : stream_(std::in_place_type<Plain>, std::move(socket)) {}

  executor_type get_executor() { return next_layer().get_executor(); }
  /// The connection below, with its time limits.
  beast::tcp_stream& next_layer() {
    if (auto* encrypted = std::get_if<Encrypted>(&stream_)) return encrypted->next_layer();
    return std::get<Plain>(stream_);
  }

  /// Encrypts from now on, as a server. `received` is what the client has sent already; `handler` gets how many of its
  /// bytes belong to the handshake. `context` must outlive the stream.
  template <class Buffer, class Handler>
  void begin_tls(asio::ssl::context& context, const Buffer& received, Handler&& handler) {
    Plain plain = std::move(std::get<Plain>(stream_));
    stream_.emplace<Encrypted>(std::move(plain), context)
        .async_handshake(asio::ssl::stream_base::server, received, std::forward<Handler>(handler));
  }

  template <class Buffers, class Handler>
  auto async_read_some(const Buffers& buffers, Handler&& handler) {
    return asio::async_initiate<Handler, void(beast::error_code, std::size_t)>(
        [this](auto&& completed, const Buffers& into) {
          std::visit([&](auto& stream) { stream.async_read_some(into, std::forward<decltype(completed)>(completed)); },
                     stream_);
        },
        handler, buffers);
  }
  template <class Buffers, class Handler>
  auto async_write_some(const Buffers& buffers, Handler&& handler) {
    return asio::async_initiate<Handler, void(beast::error_code, std::size_t)>(
        [this](auto&& completed, const Buffers& from) {
          std::visit([&](auto& stream) { stream.async_write_some(from, std::forward<decltype(completed)>(completed)); },
                     stream_);
        },
        handler, buffers);
  }

  /// How Boost.Beast ends a WebSocket over this stream.
  template <class Handler>
  friend void async_teardown(beast::role_type role, WebStream& stream, Handler&& handler) {
    using beast::websocket::async_teardown;
    std::visit([&](auto& below) { async_teardown(role, below, std::forward<Handler>(handler)); }, stream.stream_);
  }

 private:
  using Plain = beast::tcp_stream;
  using Encrypted = beast::ssl_stream<beast::tcp_stream>;
  std::variant<Plain, Encrypted> stream_;
};

}  // namespace hecaton::services
