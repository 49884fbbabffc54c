#pragma once
/// Records what participants of this machine send to each other.

#include <cstdint>
#include <vector>

#include <arpa/inet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <netpacket/packet.h>
#include <sys/socket.h>
#include <unistd.h>

namespace hecaton::test {

/// Datagrams on the loopback interface, which only a privileged user may see.
class Wiretap {
 public:
  Wiretap() : socket_(::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, htons(ETH_P_IP))) {
    sockaddr_ll link{};
    link.sll_family = AF_PACKET;
    link.sll_protocol = htons(ETH_P_IP);
    link.sll_ifindex = static_cast<int>(::if_nametoindex("lo"));
    listens_ = ::bind(socket_, reinterpret_cast<const sockaddr*>(&link), sizeof link) == 0;
  }
  ~Wiretap() { ::close(socket_); }
  Wiretap(const Wiretap&) = delete;
  Wiretap& operator=(const Wiretap&) = delete;

  [[nodiscard]] bool listens() const { return listens_; }
  /// Those that were sent to one of these UDP ports since the last call.
  [[nodiscard]] std::vector<std::vector<std::uint8_t>> take(int first_port, int last_port) const {
    constexpr std::size_t kUdpHeader = 8;
    constexpr std::uint8_t kUdp = 17;
    std::vector<std::vector<std::uint8_t>> datagrams;
    std::vector<std::uint8_t> packet(65536);
    sockaddr_ll from{};
    socklen_t length = sizeof from;
    ssize_t size = 0;
    while ((size = ::recvfrom(socket_, packet.data(), packet.size(), 0, reinterpret_cast<sockaddr*>(&from), &length)) >
           0) {
      const std::size_t header = static_cast<std::size_t>(packet[0] & 0x0FU) * 4;
      if (from.sll_pkttype == PACKET_OUTGOING || packet[9] != kUdp) continue;
      const int port = packet[header + 2] << 8U | packet[header + 3];
      if (port < first_port || port > last_port) continue;
      datagrams.emplace_back(packet.begin() + static_cast<std::ptrdiff_t>(header + kUdpHeader), packet.begin() + size);
    }
    return datagrams;
  }

 private:
  int socket_;
  bool listens_ = false;
};

}  // namespace hecaton::test
