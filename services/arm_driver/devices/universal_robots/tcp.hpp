#pragma once
/// TCP connections that never wait, for the thread of a driver's loop.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "services/arm_driver/devices/arm_device.hpp"
#include "services/arm_driver/devices/socket.hpp"

namespace hecaton::device::universal_robots {

/// A connection to or from a controller. No call waits. For one thread.
class TcpConnection {
 public:
  enum class State {
    kClosed,      ///< never opened, closed by either side, or failed: see error()
    kConnecting,  ///< begun
    kOpen,
  };

  /// Begins to connect. `address`: IPv4.
  void connect(const std::string& address, int port);
  /// Takes over a connection that a listener has accepted.
  void adopt(Socket socket);
  void close();

  /// Sends waiting bytes and takes those that have arrived. Call it once a period.
  void update();

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] bool is_open() const { return state_ == State::kOpen; }
  /// Why the connection is closed: "Connection refused". Empty after close().
  [[nodiscard]] const std::string& error() const { return error_; }
  /// The address of this machine as the other side sees it; empty when it is not open.
  [[nodiscard]] std::string own_address() const;

  /// Bytes that have arrived and were not consumed.
  [[nodiscard]] std::string& received() { return received_; }
  /// Queues bytes and sends what the socket takes at once. Closes the connection when more than 1 MB waits.
  void send(std::string_view bytes);
  [[nodiscard]] bool has_sent_all() const { return waiting_.empty(); }

 private:
  void fail(int code);
  void finish_connecting();
  void flush();

  Socket socket_;
  State state_ = State::kClosed;
  std::string error_;
  std::string received_;
  std::string waiting_;  ///< bytes to send
};

/// Listens on a port of this machine, for one peer.
class TcpListener {
 public:
  /// Returns a sentence when the port cannot be used.
  [[nodiscard]] DeviceResult listen(int port);
  void close() { socket_.close(); }
  /// The next connection from `peer`; connections of other machines are closed. Nullopt: none.
  [[nodiscard]] std::optional<Socket> accept(const std::string& peer);

 private:
  Socket socket_;
};

}  // namespace hecaton::device::universal_robots
