#pragma once
/// A ROS 2 program on the wire: a participant of Fast DDS with the names, policies and types of ROS 2. It shares no
/// code with services/ros2: fastddsgen makes its types from idl/ros2, and their serialisation is that of Fast CDR.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/fastdds.hpp"

namespace hecaton::test {

namespace dds = bus::dds;
namespace rtps = bus::rtps;
using namespace std::chrono_literals;

/// Longest wait for anything; a busy machine may need it.
constexpr std::chrono::seconds kLong{60};

class RosPeer {
 public:
  /// `identifier`: unique in this process; those of the bus, such as the client of the cell, are lower. `enclave`:
  /// folder of its keys, as rmw_fastrtps takes them; empty: none.
  explicit RosPeer(int domain, int identifier = 100, const std::string& enclave = "") {
    dds::DomainParticipantQos qos;
    qos.name("/");
    const auto set = [&](const std::string& key, const std::string& value) {
      qos.properties().properties().emplace_back("dds.sec." + key, value);
    };
    if (!enclave.empty()) {
      const std::string folder = "file://" + enclave + "/";
      set("auth.plugin", "builtin.PKI-DH");
      set("auth.builtin.PKI-DH.identity_ca", folder + "identity_ca.cert.pem");
      set("auth.builtin.PKI-DH.identity_certificate", folder + "cert.pem");
      set("auth.builtin.PKI-DH.private_key", folder + "key.pem");
      set("access.plugin", "builtin.Access-Permissions");
      set("access.builtin.Access-Permissions.permissions_ca", folder + "permissions_ca.cert.pem");
      set("access.builtin.Access-Permissions.governance", folder + "governance.p7s");
      set("access.builtin.Access-Permissions.permissions", folder + "permissions.p7s");
      set("crypto.plugin", "builtin.AES-GCM-GMAC");
    }
    qos.wire_protocol().participant_id = identifier;
    participant = dds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<dds::DomainId_t>(domain), qos, nullptr, dds::StatusMask::none());
    if (participant == nullptr) throw std::runtime_error("the peer cannot join the domain");
    publisher = participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT, nullptr, dds::StatusMask::none());
    subscriber = participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT, nullptr, dds::StatusMask::none());
  }
  ~RosPeer() {
    participant->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
  }
  RosPeer(const RosPeer&) = delete;
  RosPeer& operator=(const RosPeer&) = delete;

  dds::Topic* topic(const std::string& name, const dds::TypeSupport& type) const {
    type.register_type(participant);
    if (auto* known = dynamic_cast<dds::Topic*>(participant->lookup_topicdescription(name))) return known;
    return participant->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  }

  dds::DomainParticipant* participant = nullptr;
  dds::Publisher* publisher = nullptr;
  dds::Subscriber* subscriber = nullptr;
};

struct PeerPolicies {
  bool reliable = true;
  bool transient_local = false;
  int depth = 10;
};

template <class Qos>
void set_policies(Qos& qos, const PeerPolicies& policies) {
  qos.reliability().kind = policies.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = policies.transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = policies.depth;
  qos.resource_limits().allocated_samples = 1;
  qos.data_sharing().off();
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
}

/// The type of endpoints that exchange bytes as they are. `name`: of the type on the wire, for endpoints made later.
struct RawPeerType : bus::RawSupport {
  using type = bus::RawBytes;
  RawPeerType() : RawSupport(name, 1 << 22) {}
  inline static thread_local std::string name;
};

/// Keeps the samples of a topic. `PubSub`: generated serialisation of the type, or RawPeerType.
template <class PubSub>
class PeerReader : public dds::DataReaderListener {
 public:
  using T = typename PubSub::type;

  struct Sample {
    T value;
    rtps::SampleIdentity related;
    rtps::SampleIdentity identity;
  };

  PeerReader(RosPeer& peer, const std::string& topic, const PeerPolicies& policies = {}) : type_(new PubSub()) {
    dds::DataReaderQos qos;
    set_policies(qos, policies);
    reader_ = peer.subscriber->create_datareader(peer.topic(topic, type_), qos, this);
    if (reader_ == nullptr) throw std::runtime_error("no reader of " + topic);
  }
  ~PeerReader() override { reader_->set_listener(nullptr, dds::StatusMask::none()); }
  PeerReader(const PeerReader&) = delete;
  PeerReader& operator=(const PeerReader&) = delete;

  /// Waits for a sample that fits, also among those that have arrived before, and removes those up to it.
  std::optional<Sample> await(const std::function<bool(const Sample&)>& fits, std::chrono::seconds limit = kLong) {
    std::unique_lock lock(mutex_);
    std::optional<Sample> found;
    arrived_.wait_for(lock, limit, [&] {
      while (!samples_.empty() && !found) {
        if (fits(samples_.front())) found = std::move(samples_.front());
        samples_.erase(samples_.begin());
      }
      return found.has_value();
    });
    return found;
  }
  std::optional<T> next(
      const std::function<bool(const T&)>& fits = [](const T&) { return true; }, std::chrono::seconds limit = kLong) {
    auto sample = await([&](const Sample& candidate) { return fits(candidate.value); }, limit);
    return sample ? std::optional<T>(std::move(sample->value)) : std::nullopt;
  }
  void clear() {
    const std::scoped_lock lock(mutex_);
    samples_.clear();
  }
  /// The samples that have arrived, without waiting.
  std::vector<Sample> take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(samples_, {});
  }
  bool wait_matched(std::chrono::seconds limit = kLong) {
    std::unique_lock lock(mutex_);
    return arrived_.wait_for(lock, limit, [&] { return matched_ > 0; });
  }
  [[nodiscard]] rtps::GUID_t guid() const { return reader_->guid(); }

 private:
  void on_data_available(dds::DataReader* reader) override {
    T value;
    dds::SampleInfo info;
    while (bus::outcome(reader->take_next_sample(&value, &info)) == bus::Outcome::kOk) {
      if (!info.valid_data) continue;
      const std::scoped_lock lock(mutex_);
      samples_.push_back({value, info.related_sample_identity, info.sample_identity});
      arrived_.notify_all();
    }
  }
  void on_subscription_matched(dds::DataReader*, const dds::SubscriptionMatchedStatus& status) override {
    const std::scoped_lock lock(mutex_);
    matched_ = status.current_count;
    arrived_.notify_all();
  }

  dds::TypeSupport type_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Sample> samples_;
  int matched_ = 0;
  dds::DataReader* reader_ = nullptr;
};

template <class PubSub>
class PeerWriter : public dds::DataWriterListener {
 public:
  using T = typename PubSub::type;

  PeerWriter(RosPeer& peer, const std::string& topic, const PeerPolicies& policies = {}) : type_(new PubSub()) {
    dds::DataWriterQos qos;
    set_policies(qos, policies);
    qos.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
    writer_ = peer.publisher->create_datawriter(peer.topic(topic, type_), qos, this);
    if (writer_ == nullptr) throw std::runtime_error("no writer of " + topic);
  }
  ~PeerWriter() override { writer_->set_listener(nullptr, dds::StatusMask::none()); }
  PeerWriter(const PeerWriter&) = delete;
  PeerWriter& operator=(const PeerWriter&) = delete;

  bool wait_matched(std::chrono::seconds limit = kLong) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, limit, [&] { return matched_ > 0; });
  }
  void write(T value) { writer_->write(&value); }
  /// All readers have received what was written.
  bool wait_acknowledged(std::chrono::seconds limit = kLong) {
    return bus::outcome(writer_->wait_for_acknowledgments({static_cast<std::int32_t>(limit.count()), 0})) ==
           bus::Outcome::kOk;
  }
  [[nodiscard]] bool matched() {
    const std::scoped_lock lock(mutex_);
    return matched_ > 0;
  }
  /// Writes the reply to the request of that identity.
  void reply(T value, const rtps::SampleIdentity& request) {
    rtps::WriteParams parameters;
    parameters.related_sample_identity(request);
    writer_->write(&value, parameters);
  }
  /// Writes a request whose replies go to the reader `replies`; returns the identity that the reply names.
  rtps::SampleIdentity request(T value, const rtps::GUID_t& replies) {
    rtps::WriteParams parameters;
    parameters.related_sample_identity().writer_guid(replies);
    writer_->write(&value, parameters);
    rtps::SampleIdentity expected = parameters.sample_identity();
    expected.writer_guid(replies);
    return expected;
  }

 private:
  void on_publication_matched(dds::DataWriter*, const dds::PublicationMatchedStatus& status) override {
    const std::scoped_lock lock(mutex_);
    matched_ = status.current_count;
    changed_.notify_all();
  }

  dds::TypeSupport type_;
  std::mutex mutex_;
  std::condition_variable changed_;
  int matched_ = 0;
  dds::DataWriter* writer_ = nullptr;
};

/// A client of a service as rmw_fastrtps makes it.
template <class RequestPubSub, class ReplyPubSub>
class PeerClient {
 public:
  using Request = typename RequestPubSub::type;
  using Reply = typename ReplyPubSub::type;

  PeerClient(RosPeer& peer, const std::string& service)
      : replies_(peer, "rr" + service + "Reply"), requests_(peer, "rq" + service + "Request") {}

  /// The server is there when both topics have matched.
  bool wait_available() { return requests_.wait_matched() && replies_.wait_matched(); }
  rtps::SampleIdentity send(const Request& request) { return requests_.request(request, replies_.guid()); }
  /// The server has the requests that were sent.
  bool wait_received() { return requests_.wait_acknowledged(); }
  std::optional<Reply> receive(const rtps::SampleIdentity& of, std::chrono::seconds limit = kLong) {
    auto sample = replies_.await([&](const auto& candidate) { return candidate.related == of; }, limit);
    return sample ? std::optional<Reply>(std::move(sample->value)) : std::nullopt;
  }
  std::optional<Reply> call(const Request& request, std::chrono::seconds limit = kLong) {
    return receive(send(request), limit);
  }

 private:
  PeerReader<ReplyPubSub> replies_;
  PeerWriter<RequestPubSub> requests_;
};

/// A server of a service as rmw_fastrtps makes it. The client's reader of replies identifies it, if the request has it.
template <class RequestPubSub, class ReplyPubSub>
class PeerServer {
 public:
  using Request = typename RequestPubSub::type;
  using Reply = typename ReplyPubSub::type;

  struct Call {
    Request request;
    rtps::SampleIdentity identity;
  };

  PeerServer(RosPeer& peer, const std::string& service)
      : replies_(peer, "rr" + service + "Reply"), requests_(peer, "rq" + service + "Request") {}

  /// The requests since the last call. Also sends the replies that waited for a reader.
  std::vector<Call> take() {
    send_waiting();
    std::vector<Call> calls;
    for (auto& sample : requests_.take()) {
      rtps::SampleIdentity identity = sample.identity;
      const rtps::GUID_t& replies = sample.related.writer_guid();
      if (!(replies == rtps::GUID_t::unknown())) identity.writer_guid(replies);
      calls.push_back({std::move(sample.value), identity});
    }
    return calls;
  }
  void reply(const Reply& reply, const rtps::SampleIdentity& to) {
    waiting_.push_back({reply, to});
    send_waiting();
  }

 private:
  void send_waiting() {
    if (!replies_.matched()) return;
    for (const auto& [reply, to] : waiting_) replies_.reply(reply, to);
    waiting_.clear();
  }

  PeerWriter<ReplyPubSub> replies_;
  PeerReader<RequestPubSub> requests_;
  std::vector<std::pair<Reply, rtps::SampleIdentity>> waiting_;
};

}  // namespace hecaton::test
