#pragma once
/// A browser's part of the protocol, for tests: requests, and a WebSocket that waits for messages.

#include <cstdint>
#include <functional>
#include <string>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
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
