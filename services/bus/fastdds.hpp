#pragma once
/// Common names for Fast DDS 2 (Debian 12) and Fast DDS 3 (Debian 13), which renamed headers, namespaces, signatures
/// and settings. Private to services/bus; no other file depends on the release.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/common/LocatorList.hpp>

#if __has_include(<fastdds/LibrarySettings.hpp>)
#define HECATON_FAST_DDS 3
#include <fastdds/LibrarySettings.hpp>
#include <fastdds/rtps/builtin/data/ParticipantBuiltinTopicData.hpp>
#include <fastdds/rtps/common/WriteParams.hpp>
#include <fastdds/rtps/transport/ChainingTransport.hpp>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.hpp>
#include <fastdds/rtps/transport/NetworkBuffer.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.hpp>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.hpp>
#include <fastdds/utils/IPLocator.hpp>
#else
#define HECATON_FAST_DDS 2
#include <fastdds/rtps/common/WriteParams.h>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#endif

#include "services/bus/wire_rules.hpp"

namespace hecaton::bus {

namespace dds = eprosima::fastdds::dds;

#if HECATON_FAST_DDS == 3
namespace rtps = eprosima::fastdds::rtps;
using Duration = dds::Duration_t;
inline const Duration kInfinite = dds::c_TimeInfinite;
#else
namespace rtps {
using namespace eprosima::fastrtps::rtps;
using namespace eprosima::fastdds::rtps;
// fastrtps has aliases of these, which clang takes for other types.
using eprosima::fastdds::rtps::Locators;
using eprosima::fastdds::rtps::LocatorsIterator;
using eprosima::fastdds::rtps::TransportDescriptorInterface;
using eprosima::fastdds::rtps::TransportInterface;
}  // namespace rtps
using Duration = eprosima::fastrtps::Duration_t;
inline const Duration kInfinite = eprosima::fastrtps::c_TimeInfinite;
#endif

/// Return codes, as the DDS specification numbers them.
enum class Outcome : std::uint32_t { kOk = 0, kPreconditionNotMet = 4, kOutOfResources = 5, kTimeout = 10 };

template <class ReturnCode>
[[nodiscard]] Outcome outcome(const ReturnCode& code) {
#if HECATON_FAST_DDS == 3
  return static_cast<Outcome>(code);
#else
  return static_cast<Outcome>(code());
#endif
}

[[nodiscard]] inline bool has_key(const dds::TypeSupport& type) {
#if HECATON_FAST_DDS == 3
  return type->is_compute_key_provided;
#else
  return type->m_isGetKeyDefined;
#endif
}

/// Makes participants of one process exchange data over the network. Delivery inside the process would run a reader's
/// callbacks in the writer's control loop.
inline void use_network_inside_process() {
#if HECATON_FAST_DDS == 3
  eprosima::fastdds::LibrarySettings settings;
  settings.intraprocess_delivery = eprosima::fastdds::INTRAPROCESS_OFF;
  static_cast<void>(dds::DomainParticipantFactory::get_instance()->set_library_settings(settings));
#else
  eprosima::fastrtps::LibrarySettingsAttributes settings;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
#endif
}

/// A reliable writer sends a heartbeat after `first` and then every `period`, and repeats missing samples at once.
inline void set_heartbeats(dds::DataWriterQos& qos, const Duration& first, const Duration& period) {
  auto& times = qos.reliable_writer_qos().times;
#if HECATON_FAST_DDS == 3
  times.initial_heartbeat_delay = first;
  times.heartbeat_period = period;
  times.nack_response_delay = times.nack_supression_duration = Duration(0, 0);
#else
  times.initialHeartbeatDelay = first;
  times.heartbeatPeriod = period;
  times.nackResponseDelay = times.nackSupressionDuration = Duration(0, 0);
#endif
}

/// A reliable reader sends its first acknowledgement after `first` and answers heartbeats at once.
inline void set_acknowledgements(dds::DataReaderQos& qos, const Duration& first) {
  auto& times = qos.reliable_reader_qos().times;
#if HECATON_FAST_DDS == 3
  times.initial_acknack_delay = first;
  times.heartbeat_response_delay = Duration(0, 0);
#else
  times.initialAcknackDelay = first;
  times.heartbeatResponseDelay = Duration(0, 0);
#endif
}

/// A change of another participant, from discovery.
struct PeerEvent {
  enum class Kind : std::uint8_t { kFound, kChanged, kLeft, kDropped } kind{};
  rtps::GUID_t guid;
  std::string name;
  std::vector<rtps::Locator_t> unicast;  ///< where it receives
  std::chrono::nanoseconds lease{0};     ///< that it announces
};

/// A participant's listener for changes of other participants.
class PeerListener : public dds::DomainParticipantListener {
 protected:
  virtual void on_peer(const PeerEvent& event) = 0;
  /// Discovery has found an endpoint of another participant, or a change of it.
  virtual void on_endpoint(const rtps::GUID_t& endpoint) = 0;
  /// The handshake with a peer has ended; of secured participants only.
  virtual void on_authentication(const rtps::GUID_t& peer, bool authorized) = 0;

 private:
  void onParticipantAuthentication(dds::DomainParticipant*, rtps::ParticipantAuthenticationInfo&& info) override {
    on_authentication(info.guid, info.status == rtps::ParticipantAuthenticationInfo::AUTHORIZED_PARTICIPANT);
  }

  template <class Status, class Data>
  static PeerEvent event_of(Status status, const rtps::GUID_t& guid, std::string name, const Data& data,
                            const Duration& lease) {
    PeerEvent event{PeerEvent::Kind::kFound, guid, std::move(name), {}};
    event.lease = std::chrono::seconds(lease.seconds) + std::chrono::nanoseconds(lease.nanosec);
    if (status == Status::CHANGED_QOS_PARTICIPANT) event.kind = PeerEvent::Kind::kChanged;
    if (status == Status::REMOVED_PARTICIPANT) event.kind = PeerEvent::Kind::kLeft;
    if (status == Status::DROPPED_PARTICIPANT) event.kind = PeerEvent::Kind::kDropped;
    for (const auto* locators : {&data.metatraffic_locators, &data.default_locators}) {
      event.unicast.insert(event.unicast.end(), locators->unicast.begin(), locators->unicast.end());
    }
    return event;
  }

#if HECATON_FAST_DDS == 3
  void on_participant_discovery(dds::DomainParticipant*, rtps::ParticipantDiscoveryStatus status,
                                const rtps::ParticipantBuiltinTopicData& data, bool& ignored) override {
    ignored = false;
    if (status == rtps::ParticipantDiscoveryStatus::IGNORED_PARTICIPANT) return;
    on_peer(event_of(status, data.guid, data.participant_name.to_string(), data, data.lease_duration));
  }
  void on_data_writer_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryStatus,
                                const dds::PublicationBuiltinTopicData& data, bool& ignored) override {
    ignored = false;
    on_endpoint(data.guid);
  }
  void on_data_reader_discovery(dds::DomainParticipant*, rtps::ReaderDiscoveryStatus,
                                const dds::SubscriptionBuiltinTopicData& data, bool& ignored) override {
    ignored = false;
    on_endpoint(data.guid);
  }
#else
  void on_participant_discovery(dds::DomainParticipant*, rtps::ParticipantDiscoveryInfo&& info) override {
    on_peer(event_of(info.status, info.info.m_guid, info.info.m_participantName.to_string(), info.info,
                     info.info.m_leaseDuration));
  }
  void on_publisher_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override {
    on_endpoint(info.info.guid());
  }
  void on_subscriber_discovery(dds::DomainParticipant*, rtps::ReaderDiscoveryInfo&& info) override {
    on_endpoint(info.info.guid());
  }
#endif
};

/// A datagram to be sent.
class Datagram {
 public:
#if HECATON_FAST_DDS == 3
  Datagram(const std::vector<rtps::NetworkBuffer>& parts, std::uint32_t size) : parts_(parts), size_(size) {}
#else
  Datagram(const rtps::octet* bytes, std::uint32_t size) : parts_(bytes), size_(size) {}
#endif
  bool send(rtps::SenderResource& behind, rtps::LocatorsIterator& begin, rtps::LocatorsIterator& end,
            const std::chrono::steady_clock::time_point& until) const {
    return behind.send(parts_, size_, &begin, &end, until);
  }
  /// Copies its first bytes; returns how many there are.
  std::size_t copy_head(std::span<std::uint8_t> to) const {
    std::size_t copied = 0;
#if HECATON_FAST_DDS == 3
    for (const rtps::NetworkBuffer& part : parts_) {
      const std::size_t size = std::min<std::size_t>(part.size, to.size() - copied);
      std::copy_n(static_cast<const std::uint8_t*>(part.buffer), size, to.data() + copied);
      copied += size;
    }
#else
    copied = std::min<std::size_t>(size_, to.size());
    std::copy_n(parts_, copied, to.data());
#endif
    return copied;
  }

 private:
#if HECATON_FAST_DDS == 3
  const std::vector<rtps::NetworkBuffer>& parts_;
#else
  const rtps::octet* parts_;
#endif
  std::uint32_t size_;
};

/// A transport in front of another one.
class FrontTransport : public rtps::ChainingTransport {
 public:
  using ChainingTransport::ChainingTransport;

 protected:
  /// Sends to the locators in [begin, end) through `behind`, or not. Returns false on failure.
  virtual bool pass_on(const Datagram& datagram, rtps::SenderResource& behind, rtps::LocatorsIterator& begin,
                       rtps::LocatorsIterator& end, const std::chrono::steady_clock::time_point& until) = 0;

 private:
#if HECATON_FAST_DDS == 3
  bool send(rtps::SenderResource* behind, const std::vector<rtps::NetworkBuffer>& parts, std::uint32_t size,
#else
  bool send(rtps::SenderResource* behind, const rtps::octet* parts, std::uint32_t size,
#endif
            rtps::LocatorsIterator* begin, rtps::LocatorsIterator* end,
            const std::chrono::steady_clock::time_point& until) override {
    return pass_on({parts, size}, *behind, *begin, *end, until);
  }
};

/// The result of the last check of a received sample on this thread, for the reader that takes the sample.
inline thread_local CheckedSample last_check;
/// Its size as it was received [byte].
inline thread_local std::size_t last_size = 0;
/// The serialised form of a sample whose type this process does not know: its CDR bytes, encapsulation included.
using RawBytes = std::vector<std::uint8_t>;

/// Type support of samples that are exchanged as RawBytes. `largest`: of a sample with its encapsulation [bytes].
class RawSupport : public dds::TopicDataType {
 public:
  RawSupport(const std::string& type, std::uint32_t largest) {
#if HECATON_FAST_DDS == 3
    set_name(type);
    max_serialized_type_size = largest;
    is_compute_key_provided = false;
#else
    setName(type.c_str());
    m_typeSize = largest;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
#endif
  }

#if HECATON_FAST_DDS == 3
  bool serialize(const void* const data, rtps::SerializedPayload_t& payload, dds::DataRepresentationId_t) override {
    return write(*static_cast<const RawBytes*>(data), payload);
  }
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) override {
    return read(payload, *static_cast<RawBytes*>(data));
  }
  std::uint32_t calculate_serialized_size(const void* const data, dds::DataRepresentationId_t) override {
    return static_cast<std::uint32_t>(static_cast<const RawBytes*>(data)->size());
  }
  void* create_data() override {
    return new RawBytes();
  }
  void delete_data(void* data) override {
    delete static_cast<RawBytes*>(data);
  }
  bool compute_key(rtps::SerializedPayload_t&, rtps::InstanceHandle_t&, bool) override {
    return false;
  }
  bool compute_key(const void* const, rtps::InstanceHandle_t&, bool) override {
    return false;
  }
#else
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    return write(*static_cast<const RawBytes*>(data), *payload);
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    return read(*payload, *static_cast<RawBytes*>(data));
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [size = static_cast<const RawBytes*>(data)->size()] { return static_cast<std::uint32_t>(size); };
  }
  void* createData() override {
    return new RawBytes();
  }
  void deleteData(void* data) override {
    delete static_cast<RawBytes*>(data);
  }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override {
    return false;
  }
#endif

 private:
  static bool write(const RawBytes& bytes, rtps::SerializedPayload_t& payload) {
    if (bytes.size() > payload.max_size) return false;
    std::copy(bytes.begin(), bytes.end(), payload.data);
    payload.length = static_cast<std::uint32_t>(bytes.size());
    payload.encapsulation = CDR_LE;
    return true;
  }
  static bool read(const rtps::SerializedPayload_t& payload, RawBytes& bytes) {
    bytes.assign(payload.data, payload.data + payload.length);
    return true;
  }
};

/// A generated type support `Base` for messages T, made thread-safe and safe against malformed payloads.
template <class Base, class T>
class GuardedSupport : public Base {
 public:
  /// `rule`: of received samples; null: only their size is checked, against `most_bytes`.
  explicit GuardedSupport(const TopicRule* rule = nullptr,
                          std::uint32_t most_bytes = std::numeric_limits<std::uint32_t>::max())
      : rule_(rule), most_bytes_(most_bytes) {
    // Histories preallocate buffers of the type's size and enlarge them where a sample needs it. The largest
    // PlannerTick has 43 MB, but nearly all have some kilobytes.
    constexpr std::uint32_t kMostPreallocated = 64U << 10U;
#if HECATON_FAST_DDS == 3
    this->max_serialized_type_size = std::min(this->max_serialized_type_size, kMostPreallocated);
#else
    this->m_typeSize = std::min(this->m_typeSize, kMostPreallocated);
#endif
  }

  /// The handle of the sample's key. Thread-safe, unlike the generated code, which serialises all keys into one buffer.
  bool key_handle(const T& sample, rtps::InstanceHandle_t& handle) {
    return guarded_key(&sample, handle, false);
  }

  /// The serialised sample, encapsulation included; empty when it cannot be serialised.
  [[nodiscard]] std::string bytes_of(const T& sample) {
    rtps::SerializedPayload_t payload(size_of(sample));
#if HECATON_FAST_DDS == 3
    const bool done = Base::serialize(&sample, payload, dds::XCDR_DATA_REPRESENTATION);
#else
    const bool done = Base::serialize(const_cast<T*>(&sample), &payload);
#endif
    return done ? std::string(reinterpret_cast<const char*>(payload.data), payload.length) : std::string();
  }

  /// The inverse of bytes_of(). Malformed bytes give a sample of schema 0.
  void read(const std::string& bytes, T& sample) {
    rtps::SerializedPayload_t payload(static_cast<std::uint32_t>(bytes.size()));
    payload.length = static_cast<std::uint32_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), payload.data);
    guarded_read(payload, sample);
  }

#if HECATON_FAST_DDS == 3
  using Base::compute_key;
  bool compute_key(const void* const data, rtps::InstanceHandle_t& handle, bool force_md5) override {
    return guarded_key(data, handle, force_md5);
  }
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) override {
    return guarded_read(payload, *static_cast<T*>(data));
  }
#else
  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool force_md5) override {
    return guarded_key(data, *handle, force_md5);
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    return guarded_read(*payload, *static_cast<T*>(data));
  }
#endif

 private:
  std::uint32_t size_of(const T& sample) {
#if HECATON_FAST_DDS == 3
    return Base::calculate_serialized_size(&sample, dds::XCDR_DATA_REPRESENTATION);
#else
    return Base::getSerializedSizeProvider(const_cast<T*>(&sample))();
#endif
  }

  bool guarded_key(const void* data, rtps::InstanceHandle_t& handle, bool force_md5) {
    const std::scoped_lock lock(key_mutex_);
#if HECATON_FAST_DDS == 3
    return Base::compute_key(data, handle, force_md5);
#else
    return Base::getKey(const_cast<void*>(data), &handle, force_md5);
#endif
  }

  /// Returns true always, because a refused payload would stay in the history. The reader drops samples of schema 0.
  bool guarded_read(rtps::SerializedPayload_t& payload, T& sample) {
    last_check = check(payload);
    last_size = payload.length;
    if (!last_check.refusal && !last_check.other_schema) {
      if (decode(payload, sample)) return true;
      last_check.refusal = "it cannot be decoded";
    }
    sample = T();
    sample.schema(0);
    return true;
  }

  bool decode(rtps::SerializedPayload_t& payload, T& sample) {
    try {
#if HECATON_FAST_DDS == 3
      return Base::deserialize(payload, &sample) && (rule_ != nullptr || is_whole(payload, sample));
#else
      return Base::deserialize(&payload, &sample);
#endif
    } catch (const std::exception&) {
      return false;
    }
  }

#if HECATON_FAST_DDS == 3
  /// False for a payload that was cut between two members: Fast CDR 2 leaves the missing ones as they are by default.
  /// The rules of a topic refuse such a payload themselves.
  bool is_whole(const rtps::SerializedPayload_t& payload, const T& sample) {
    constexpr unsigned char kPlainCdr = 1;  // or 0, the big-endian one; XCDR2 has other sizes
    return payload.data[1] > kPlainCdr || bytes_of(sample).size() <= payload.length;
  }
#endif

  [[nodiscard]] CheckedSample check(const rtps::SerializedPayload_t& payload) const {
    if (rule_ != nullptr) return check_sample(*rule_, {payload.data, payload.length});
    if (payload.length <= most_bytes_) return {};
    return {std::to_string(payload.length) + " bytes, at most " + std::to_string(most_bytes_) + " are allowed"};
  }

  const TopicRule* rule_;
  std::uint32_t most_bytes_;
  std::mutex key_mutex_;
};

}  // namespace hecaton::bus
