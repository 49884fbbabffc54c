#pragma once
/// A TCP server on a loopback address of this process alone, as a robot controller for one connection at a time.

#include <string>
#include <string_view>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/fuzz/fuzz.hpp"

namespace hecaton::fuzz {

class LoopbackServer {
 public:
  explicit LoopbackServer(int port) {
    const auto process = static_cast<unsigned>(::getpid());
    address_ = "127.241." + std::to_string(process >> 8U & 0xFFU) + "." + std::to_string(1 + process % 254);
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, address_.c_str(), &own.sin_addr);
    const int yes = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    require(::bind(listener_, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0 && ::listen(listener_, 4) == 0,
            "the address of the test is free");
  }

  void accept() {
    connection_ = ::accept(listener_, nullptr, nullptr);
    const linger at_once{1, 0};  // no closed connection waits for late bytes: there are thousands a second
    ::setsockopt(connection_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  }
  void send(std::string_view bytes) const { (void)!::send(connection_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  void close() const { ::close(connection_); }
  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  std::string address_;
  int listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  int connection_ = -1;
};

}  // namespace hecaton::fuzz
