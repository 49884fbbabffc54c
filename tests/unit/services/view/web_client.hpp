#pragma once
/// A browser's part of the protocol, for tests: requests, and a WebSocket that waits for messages.

#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <nlohmann/json.hpp>

namespace hecaton::test {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;

inline tcp::endpoint local(std::uint16_t port) {
  return {asio::ip::make_address_v4("127.0.0.1"), port};
}

/// A GET (or another method) with this Host header.
inline http::response<http::string_body> request(std::uint16_t port, const std::string& target,
                                                 http::verb verb = http::verb::get,
                                                 const std::string& host = "localhost") {
  asio::io_context context;
  tcp::socket socket(context);
  socket.connect(local(port));
  http::request<http::empty_body> request(verb, target, 11);
  request.set(http::field::host, host);
  http::write(socket, request);
  http::response_parser<http::string_body> parser;
  if (verb == http::verb::head) parser.skip(true);
  beast::flat_buffer buffer;
  http::read(socket, buffer, parser);
  return parser.release();
}

/// As a browser that takes any certificate, over TLS: the response to a GET with these header fields.
inline http::response<http::string_body> encrypted_request(std::uint16_t port, const std::string& target,
                                                           const std::map<http::field, std::string>& fields = {}) {
  asio::io_context context;
  asio::ssl::context tls(asio::ssl::context::tls_client);
  asio::ssl::stream<tcp::socket> stream(context, tls);
  stream.next_layer().connect(local(port));
  stream.handshake(asio::ssl::stream_base::client);
  http::request<http::empty_body> request(http::verb::get, target, 11);
  request.set(http::field::host, "localhost:" + std::to_string(port));
  for (const auto& [name, value] : fields) request.set(name, value);
  http::write(stream, request);
  http::response_parser<http::string_body> parser;
  beast::flat_buffer buffer;
  http::read(stream, buffer, parser);
  return parser.release();
}

/// A WebSocket over TLS. The constructor throws boost::system::system_error when the server refuses it.
class EncryptedWebSocketClient {
 public:
  EncryptedWebSocketClient(std::uint16_t port, const std::string& target, const std::string& cookie,
                           const std::string& origin = "") {
    stream_.next_layer().next_layer().connect(local(port));
    stream_.next_layer().handshake(asio::ssl::stream_base::client);
    stream_.read_message_max(64 << 20);
    stream_.set_option(beast::websocket::stream_base::decorator([&](beast::websocket::request_type& request) {
      if (!cookie.empty()) request.set(http::field::cookie, cookie);
      if (!origin.empty()) request.set(http::field::origin, origin);
    }));
    stream_.handshake("localhost:" + std::to_string(port), target);
  }

  std::string read() {
    beast::flat_buffer buffer;
    stream_.read(buffer);
    return beast::buffers_to_string(buffer.data());
  }
  void write(const std::string& text) { stream_.write(asio::buffer(text)); }

 private:
  asio::io_context context_;
  asio::ssl::context tls_{asio::ssl::context::tls_client};
  beast::websocket::stream<asio::ssl::stream<tcp::socket>> stream_{context_, tls_};
};

class WebSocketClient {
 public:
  /// Throws boost::system::system_error when the server refuses it. `origin`: of a page; empty: no page.
  explicit WebSocketClient(std::uint16_t port, const std::string& origin = "", const std::string& host = "localhost") {
    stream_.next_layer().connect(local(port));
    stream_.read_message_max(64 << 20);
    stream_.set_option(beast::websocket::stream_base::decorator([&](beast::websocket::request_type& request) {
      if (!origin.empty()) request.set(http::field::origin, origin);
    }));
    stream_.handshake(host, "/live");
  }

  std::string read() {
    beast::flat_buffer buffer;
    stream_.read(buffer);
    return beast::buffers_to_string(buffer.data());
  }
  void write(const std::string& text) { stream_.write(asio::buffer(text)); }

  /// The first message of this type that `is_right` accepts.
  nlohmann::json wait_for(const std::string& type, const std::function<bool(const nlohmann::json&)>& is_right) {
    while (true) {
      nlohmann::json message = nlohmann::json::parse(read());
      if (message.at("type") == type && is_right(message)) return message;
    }
  }

 private:
  asio::io_context context_;
  beast::websocket::stream<tcp::socket> stream_{context_};
};

}  // namespace hecaton::test
