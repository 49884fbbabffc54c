#pragma once
/// A program that may not be here: a participant of its own in the domain of a cell, and raw datagrams. It knows what
/// discovery tells each participant.

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/bus/endpoint.hpp"
#include "services/bus/fastdds.hpp"
#include "services/bus/topics.hpp"

namespace hecaton::test {

/// A participant of the middleware itself, for RawWriter. Fast DDS 2.
class RawParticipant {
 public:
  /// `interface`: an address of this machine; empty: all.
  explicit RawParticipant(int domain, const std::string& interface = "127.0.0.1") {
    bus::dds::DomainParticipantQos qos;
    qos.name("intruder");
    qos.wire_protocol().participant_id = 100;  // unique in this process: those of the bus are lower
    auto transport = std::make_shared<bus::rtps::UDPv4TransportDescriptor>();
    if (!interface.empty()) transport->interfaceWhiteList.push_back(interface);
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(transport);
    participant_ = bus::dds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<bus::dds::DomainId_t>(domain), qos, nullptr, bus::dds::StatusMask::none());
  }
  ~RawParticipant() {
    participant_->delete_contained_entities();
    bus::dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  RawParticipant(const RawParticipant&) = delete;
  RawParticipant& operator=(const RawParticipant&) = delete;

  [[nodiscard]] bus::dds::DomainParticipant* get() const { return participant_; }

 private:
  bus::dds::DomainParticipant* participant_ = nullptr;
};

/// Publishes any bytes as samples of a topic, past every check of the bus's own writers. `participant` must outlive it.
class RawWriter {
 public:
  /// `waits`: write() returns when the sample has been sent; otherwise a newer one may replace it before.
  RawWriter(RawParticipant& participant, const std::string& partition, const std::string& type,
            const bus::Qos& qos = {.reliable = true}, bool keyed = true, bool waits = false) {
    namespace dds = bus::dds;
    type_ = new Type("hecaton::msg::" + type, keyed);
    dds::TypeSupport support(type_);
    support.register_type(participant.get());
    dds::PublisherQos publisher_qos;
    publisher_qos.partition().push_back(partition.c_str());
    auto* publisher = participant.get()->create_publisher(publisher_qos);
    auto* topic = participant.get()->create_topic("hecaton/" + type, support.get_type_name(), dds::TopicQos());
    dds::DataWriterQos writer_qos;
    writer_qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    writer_qos.history().depth = 1;
    writer_qos.resource_limits().max_instances = 1 << 20;
    writer_qos.resource_limits().max_samples_per_instance = 1;
    writer_qos.resource_limits().max_samples = 1 << 20;
    writer_qos.resource_limits().allocated_samples = 8;
    writer_qos.endpoint().history_memory_policy = bus::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    if (!qos.reliable) writer_qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
    if (qos.transient_local) writer_qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
    if (qos.deadline.count() > 0) {
      writer_qos.deadline().period = bus::Duration(std::chrono::duration<double>(qos.deadline).count());
    }
    writer_qos.publish_mode().kind = waits ? dds::SYNCHRONOUS_PUBLISH_MODE : dds::ASYNCHRONOUS_PUBLISH_MODE;
    writer_ = publisher->create_datawriter(topic, writer_qos);
  }

  /// The bytes of its GUID.
  [[nodiscard]] std::array<std::uint8_t, 16> guid() const {
    const bus::rtps::GUID_t& guid = writer_->guid();
    std::array<std::uint8_t, 16> bytes{};
    std::copy_n(guid.guidPrefix.value, 12, bytes.begin());
    std::copy_n(guid.entityId.value, 4, bytes.begin() + 12);
    return bytes;
  }
  /// With the encapsulation, or whatever the receiver shall take for it.
  void write(std::string bytes) { writer_->write(&bytes); }
  /// Under an instance handle of the sender's choice.
  void write(std::string bytes, std::uint64_t handle) {
    type_->handle = handle;
    write(std::move(bytes));
  }
  [[nodiscard]] bool matched() const {
    bus::dds::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count > 0;
  }

 private:
  class Type : public bus::dds::TopicDataType {
   public:
    Type(const std::string& name, bool keyed) {
      setName(name.c_str());
      m_typeSize = 1U << 16U;
      m_isGetKeyDefined = keyed;
    }
    bool serialize(void* data, bus::rtps::SerializedPayload_t* payload) override {
      const auto& bytes = *static_cast<std::string*>(data);
      payload->reserve(static_cast<std::uint32_t>(bytes.size()));
      std::copy(bytes.begin(), bytes.end(), payload->data);
      payload->length = static_cast<std::uint32_t>(bytes.size());
      return true;
    }
    bool deserialize(bus::rtps::SerializedPayload_t*, void*) override { return false; }
    std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
      return [data] { return static_cast<std::uint32_t>(static_cast<std::string*>(data)->size()); };
    }
    void* createData() override { return new std::string; }
    void deleteData(void* data) override { delete static_cast<std::string*>(data); }
    bool getKey(void*, bus::rtps::InstanceHandle_t* key, bool) override {
      for (unsigned i = 0; i < 16; ++i) key->value[i] = static_cast<std::uint8_t>(handle >> 8U * (i % 8));
      return true;
    }
    std::uint64_t handle = 0x0707'0707'0707'0707;
  };

  Type* type_;  ///< owned by the participant

  bus::dds::DataWriter* writer_ = nullptr;
};

/// Sends datagrams to the ports of all participants of a domain on this machine.
class DatagramSender {
 public:
  explicit DatagramSender(int domain) : base_(7400 + 250 * domain), socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {}
  ~DatagramSender() { ::close(socket_); }
  DatagramSender(const DatagramSender&) = delete;
  DatagramSender& operator=(const DatagramSender&) = delete;

  void send(const std::vector<std::uint8_t>& bytes) const {
    constexpr int kParticipants = 8;
    for (int port = base_ + 10; port < base_ + 10 + 2 * kParticipants; ++port) {
      sockaddr_in to{};
      to.sin_family = AF_INET;
      to.sin_port = htons(static_cast<std::uint16_t>(port));
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      (void)::sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }
  }

 private:
  int base_;
  int socket_;
};

}  // namespace hecaton::test
