#pragma once
/// Topics and services of ROS 2 as serialised bytes, encapsulation included. Their names and policies are those of the
/// middleware rmw_fastrtps. services/ros2 has the types.
///
/// Two policies are stricter than those of ROS 2 nodes. Reliable writers offer transient-local durability, because of a
/// deadlock in Fast DDS (qos.cpp). Readers drop samples above a size, at most 1 MiB, before memory is allocated for
/// them.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/participant.hpp"

namespace hecaton::bus::ros2 {

using Bytes = std::vector<std::uint8_t>;

/// Options of a participant that ROS 2 nodes accept as one of theirs. Its name must be that of its enclave, without
/// keys "/".
[[nodiscard]] ParticipantOptions participant_options(const std::string& enclave = "/");

struct Topic {
  std::string name;  ///< "/joint_states"
  std::string type;  ///< "sensor_msgs/msg/JointState"
  std::string hash;  ///< of the type, 64 hexadecimal digits; empty: not announced
  bool reliable = true;
  bool transient_local = false;  ///< late joiners get the samples that the writer keeps
  int depth = 10;                ///< number of samples kept
  bool plain = false;            ///< `name` is the DDS topic itself, without the prefix "rt"
};

/// The largest sample that a reader accepts, with its encapsulation [bytes].
inline constexpr std::uint32_t kLargestSample = 1U << 20U;

struct Service {
  std::string name;                                ///< "/hold"
  std::string type;                                ///< "std_srvs/srv/Trigger"
  std::string hash;                                ///< of the service's type; empty: not announced
  std::uint32_t largest_request = kLargestSample;  ///< that a server accepts [bytes]
};

/// Thread-safe. The participant must outlive the constructor only.
class Writer {
 public:
  /// Throws std::runtime_error with a sentence when the endpoint cannot be created.
  Writer(Participant& participant, const Topic& topic);
  ~Writer();
  Writer(Writer&&) noexcept;
  Writer& operator=(Writer&&) noexcept;

  /// False when the middleware refuses the sample.
  bool write(const Bytes& bytes);
  [[nodiscard]] int matched() const;  ///< number of readers
  [[nodiscard]] EndpointId id() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

struct Sample {
  Bytes bytes;
  EndpointId writer;
  Clock::time_point received;
};

/// take() is for one thread; the rest is thread-safe.
class Reader {
 public:
  /// At most this many samples, with this many bytes in all, wait for take(); the oldest in excess are dropped.
  static constexpr std::size_t kQueue = 64;
  static constexpr std::size_t kQueueBytes = 8U << 20U;

  /// `mailbox` is notified of samples and must outlive the reader. Throws std::runtime_error as Writer.
  Reader(Participant& participant, const Topic& topic, Mailbox& mailbox);
  ~Reader();
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;

  /// The samples since the last call, oldest first. Never blocks.
  [[nodiscard]] std::vector<Sample> take();
  [[nodiscard]] int matched() const;  ///< number of writers
  [[nodiscard]] EndpointId id() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Names a request: its client, and the client's number for it.
struct RequestId {
  EndpointId client;
  std::int64_t number = 0;
  bool operator==(const RequestId&) const = default;
};

struct Request {
  RequestId id;
  Bytes bytes;
};

/// The server of a service. For one thread.
class Server {
 public:
  /// A client whose reader of replies is not discovered within this time gets no reply.
  static constexpr std::chrono::seconds kPatience{2};

  /// `mailbox`: as of Reader.
  Server(Participant& participant, const Service& service, Mailbox& mailbox);
  ~Server();
  Server(Server&&) noexcept;
  Server& operator=(Server&&) noexcept;

  /// The requests since the last call, oldest first. Also sends replies whose client has been discovered meanwhile:
  /// call it whenever the mailbox wakes.
  [[nodiscard]] std::vector<Request> take();
  /// Sends the reply, or keeps it until the client is discovered.
  void reply(const RequestId& request, const Bytes& bytes);
  [[nodiscard]] EndpointId writer_id() const;  ///< of replies
  [[nodiscard]] EndpointId reader_id() const;  ///< of requests

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The answer to the request of that number.
struct Reply {
  std::int64_t number = 0;
  Bytes bytes;
};

/// A client of a service. For one thread.
class Client {
 public:
  /// `mailbox`: as of Reader. Throws std::runtime_error as Writer.
  Client(Participant& participant, const Service& service, Mailbox& mailbox);
  ~Client();
  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;

  /// Both topics of a server are known: it gets requests and can answer them.
  [[nodiscard]] bool available() const;
  /// The number of the request; empty when the middleware refuses it. Never blocks for an answer.
  std::optional<std::int64_t> send(const Bytes& bytes);
  /// The replies to this client since the last call, oldest first.
  [[nodiscard]] std::vector<Reply> take();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hecaton::bus::ros2
