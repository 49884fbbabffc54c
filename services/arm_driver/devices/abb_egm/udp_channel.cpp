#include "services/arm_driver/devices/abb_egm/udp_channel.hpp"

#include <cerrno>
#include <cstring>

#include <arpa/inet.h>
#include <sys/socket.h>

namespace hecaton::device::abb_egm {
namespace {

std::string text_of(const sockaddr_in& address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
  return text.data();
}

bool has_address(const sockaddr_in& sender, const std::string& address) {
  in_addr wanted{};
  return ::inet_pton(AF_INET, address.c_str(), &wanted) == 1 && wanted.s_addr == sender.sin_addr.s_addr;
}

}  // namespace

std::optional<std::string> UdpChannel::open(int port) {
  socket_.close();
  dropped_sender_.clear();
  socket_ = Socket(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_ANY);
  any.sin_port = htons(static_cast<std::uint16_t>(port));
  if (::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0) return std::nullopt;
  std::string why = std::strerror(errno);
  socket_.close();
  return why;
}

std::optional<std::string_view> UdpChannel::receive(const std::optional<std::string>& peer) {
  // A flood of other addresses must not hold up the driver's loop.
  constexpr int kMostDropped = 64;
  for (int dropped = 0; dropped < kMostDropped && socket_.is_open(); ++dropped) {
    socklen_t size = sizeof sender_;
    const ssize_t count =
        ::recvfrom(socket_.get(), buffer_.data(), buffer_.size(), 0, reinterpret_cast<sockaddr*>(&sender_), &size);
    if (count < 0) return std::nullopt;
    if (!peer || has_address(sender_, *peer)) return std::string_view(buffer_.data(), static_cast<std::size_t>(count));
    if (dropped_sender_.empty()) dropped_sender_ = text_of(sender_);
  }
  return std::nullopt;
}

std::string UdpChannel::sender() const {
  return text_of(sender_);
}

void UdpChannel::answer(std::string_view bytes) const {
  (void)::sendto(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&peer_),
                 sizeof peer_);
}

}  // namespace hecaton::device::abb_egm
