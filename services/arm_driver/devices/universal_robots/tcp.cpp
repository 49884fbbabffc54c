#include "services/arm_driver/devices/universal_robots/tcp.hpp"

#include <array>
#include <cerrno>
#include <cstring>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

namespace hecaton::device::universal_robots {
namespace {

constexpr std::size_t kMostWaiting = 1 << 20;
constexpr std::size_t kMostReceived = 1 << 20;

sockaddr_in address_of(const std::string& address, int port) {
  sockaddr_in result{};
  result.sin_family = AF_INET;
  result.sin_port = htons(static_cast<std::uint16_t>(port));
  ::inet_pton(AF_INET, address.c_str(), &result.sin_addr);
  return result;
}

std::string text_of(const sockaddr_in& address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
  return text.data();
}

void without_delay(int socket) {
  const int yes = 1;
  (void)::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

}  // namespace

void TcpConnection::connect(const std::string& address, int port) {
  close();
  socket_ = Socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket_.is_open()) return fail(errno);
  without_delay(socket_.get());
  const sockaddr_in to = address_of(address, port);
  state_ = State::kConnecting;
  if (::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) {
    state_ = State::kOpen;
  } else if (errno != EINPROGRESS) {
    fail(errno);
  }
}

void TcpConnection::adopt(Socket socket) {
  close();
  socket_ = std::move(socket);
  without_delay(socket_.get());
  state_ = State::kOpen;
}

void TcpConnection::close() {
  socket_.close();
  state_ = State::kClosed;
  error_.clear();
  received_.clear();
  waiting_.clear();
}

void TcpConnection::fail(int code) {
  close();
  error_ = code == 0 ? "closed by the robot" : std::strerror(code);
}

void TcpConnection::finish_connecting() {
  pollfd socket{socket_.get(), POLLOUT, 0};
  if (::poll(&socket, 1, 0) <= 0) return;
  int code = 0;
  socklen_t size = sizeof code;
  if (::getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &code, &size) != 0) code = errno;
  if (code != 0) return fail(code);
  state_ = State::kOpen;
}

void TcpConnection::update() {
  if (state_ == State::kConnecting) finish_connecting();
  if (state_ != State::kOpen) return;
  flush();
  std::array<char, 16384> bytes;
  while (state_ == State::kOpen && received_.size() < kMostReceived) {
    const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
    if (count > 0) {
      received_.append(bytes.data(), static_cast<std::size_t>(count));
    } else if (count == 0) {
      fail(0);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      return;
    } else if (errno != EINTR) {
      fail(errno);
    }
  }
}

std::string TcpConnection::own_address() const {
  sockaddr_in own{};
  socklen_t size = sizeof own;
  if (!is_open() || ::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&own), &size) != 0) return {};
  return text_of(own);
}

void TcpConnection::send(std::string_view bytes) {
  if (!is_open()) return;
  waiting_.append(bytes);
  flush();
  if (waiting_.size() > kMostWaiting) fail(ENOBUFS);
}

void TcpConnection::flush() {
  while (!waiting_.empty()) {
    const ssize_t count = ::send(socket_.get(), waiting_.data(), waiting_.size(), MSG_NOSIGNAL);
    if (count >= 0) {
      waiting_.erase(0, static_cast<std::size_t>(count));
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      return;
    } else if (errno != EINTR) {
      return fail(errno);
    }
  }
}

DeviceResult TcpListener::listen(int port) {
  close();
  socket_ = Socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int yes = 1;
  (void)::setsockopt(socket_.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_ANY);
  any.sin_port = htons(static_cast<std::uint16_t>(port));
  const bool listens = ::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0 &&
                       ::listen(socket_.get(), 4) == 0;
  if (listens) return {};
  const std::string why = std::strerror(errno);
  close();
  return DeviceFailure{"cannot listen on port " + std::to_string(port) + " of this machine: " + why +
                       "; does another program use it? Set reverse_port in the cell file"};
}

std::optional<Socket> TcpListener::accept(const std::string& peer) {
  sockaddr_in from{};
  socklen_t size = sizeof from;
  while (socket_.is_open()) {
    Socket next(::accept4(socket_.get(), reinterpret_cast<sockaddr*>(&from), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!next.is_open()) return std::nullopt;
    if (text_of(from) == peer) return next;
  }
  return std::nullopt;
}

}  // namespace hecaton::device::universal_robots
