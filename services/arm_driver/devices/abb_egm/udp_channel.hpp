#pragma once
/// A UDP port for the messages of one robot. No call waits.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <netinet/in.h>

#include "services/arm_driver/devices/socket.hpp"

namespace hecaton::device::abb_egm {

/// Receives the datagrams of one address, and answers to where the last one came from. For one thread.
class UdpChannel {
 public:
  /// Listens on the port, on all addresses of this machine. Returns why it cannot.
  [[nodiscard]] std::optional<std::string> open(int port);

  /// The next datagram that waits; nullopt: none. It is valid until the next call. `peer`: takes those of this IPv4
  /// address alone and drops other ones; empty: takes those of every address.
  [[nodiscard]] std::optional<std::string_view> receive(const std::optional<std::string>& peer);
  /// The address of the datagram that receive() has given last.
  [[nodiscard]] std::string sender() const;
  /// The address of a datagram that receive() has dropped; empty: it has dropped none.
  [[nodiscard]] const std::string& dropped_sender() const { return dropped_sender_; }

  /// Answers are sent to the sender of the last datagram from now on.
  void answer_to_sender() { peer_ = sender_; }
  /// A datagram that cannot be sent at once is lost.
  void answer(std::string_view bytes) const;

 private:
  Socket socket_;
  sockaddr_in sender_{};
  sockaddr_in peer_{};
  std::string dropped_sender_;
  std::array<char, 2048> buffer_{};  ///< a message of a robot has some 400 bytes
};

}  // namespace hecaton::device::abb_egm
