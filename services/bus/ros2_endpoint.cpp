#include "services/bus/ros2_endpoint.hpp"

#include <algorithm>
#include <atomic>
#include <deque>
#include <mutex>
#include <set>
#include <stdexcept>
#include <utility>

#include "services/bus/participant_impl.hpp"
#include "services/bus/qos.hpp"
#include "services/bus/ros2_names.hpp"
#include "services/bus/source_time.hpp"

namespace hecaton::bus::ros2 {
namespace {

/// Nodes of ROS 2 announce themselves every 3 s and count as lost after this time.
constexpr std::chrono::seconds kLease{20};

/// An endpoint as Fast DDS sees it.
struct Wire {
  std::string name;
  std::string type;
  std::string hash;
  bus::Qos qos;
  std::uint32_t largest = kLargestSample;
};

Wire wire_of(const Topic& topic) {
  bus::Qos qos;
  qos.reliable = topic.reliable;
  qos.transient_local = topic.transient_local;
  qos.depth = topic.depth;
  return {topic.plain ? topic.name : topic_name(topic.name), type_name(topic.type), topic.hash, qos};
}

bus::Qos service_qos() {
  bus::Qos qos;
  qos.reliable = true;
  qos.depth = 10;
  return qos;
}

Wire request_of(const Service& service) {
  return {request_name(service.name), type_name(service.type + "_Request"), service.hash, service_qos(),
          service.largest_request};
}

Wire reply_of(const Service& service) {
  return {reply_name(service.name), type_name(service.type + "_Response"), service.hash, service_qos()};
}

dds::Topic* dds_topic(Participant::Impl& participant, const Wire& wire) {
  const TopicInfo info{wire.type, wire.name, {}, {}, wire.qos};
  return participant.topic(info, participant.raw_type(wire.type, wire.largest));
}

template <class EntityQos>
void announce_hash(EntityQos& qos, const std::string& hash) {
  if (hash.empty()) return;
  const std::string text = "typehash=RIHS01_" + hash + ";";
  qos.user_data().assign(text.begin(), text.end());
}

rtps::GUID_t guid_of(const EndpointId& id) {
  rtps::GUID_t guid;
  std::copy_n(id.bytes.begin(), 12, guid.guidPrefix.value);
  std::copy_n(id.bytes.begin() + 12, 4, guid.entityId.value);
  return guid;
}

std::int64_t number_of(const rtps::SampleIdentity& identity) {
  return static_cast<std::int64_t>(identity.sequence_number().to64long());
}

/// RTPS 2.2, section 9.3.1.2: readers have this bit in the last byte of their entity's number.
bool is_reader(const EndpointId& id) {
  return (id.bytes[15] & 0x04U) != 0;
}

[[noreturn]] void fail(const Participant::Impl& participant, const std::string& endpoint, const Wire& wire) {
  throw std::runtime_error("bus: cannot create a " + endpoint + " of " + wire.name +
                           (participant.secured() ? "; the participant's permissions.p7s must allow this topic" : ""));
}

/// A writer, and the readers that it has matched.
class RawWriter : public dds::DataWriterListener {
 public:
  RawWriter(std::shared_ptr<Participant::Impl> participant, const Wire& wire, Mailbox* mailbox)
      : participant_(std::move(participant)), mailbox_(mailbox) {
    const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
    auto* topic = dds_topic(*participant_, wire);
    auto qos = writer_qos(wire.qos, false);
    // The type's size is that of the largest sample.
    qos.endpoint().history_memory_policy = rtps::DYNAMIC_RESERVE_MEMORY_MODE;
    announce_hash(qos, wire.hash);
    writer_ = participant_->publisher->create_datawriter(topic, qos, this);
    if (writer_ == nullptr) fail(*participant_, "writer", wire);
  }
  ~RawWriter() override {
    const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
    writer_->set_listener(nullptr, dds::StatusMask::none());
    participant_->remove_endpoint([from = participant_->publisher, writer = writer_] {
      std::size_t removed = 0;
      writer->clear_history(&removed);  // as in ~WriterBase()
      from->delete_datawriter(writer);
    });
  }
  RawWriter(const RawWriter&) = delete;
  RawWriter& operator=(const RawWriter&) = delete;

  bool write(const Bytes& bytes) {
    const std::scoped_lock lock(order_);
    // Fast DDS takes void*, but serialisation only reads.
    return outcome(writer_->write_w_timestamp(const_cast<Bytes*>(&bytes), dds::HANDLE_NIL, duration(source_time()))) ==
           Outcome::kOk;
  }
  /// The sample answers `request`.
  bool write(const Bytes& bytes, const RequestId& request) {
    rtps::SampleIdentity identity;
    identity.writer_guid(guid_of(request.client));
    identity.sequence_number(rtps::SequenceNumber_t(static_cast<std::int32_t>(request.number >> 32U),
                                                    static_cast<std::uint32_t>(request.number)));
    rtps::WriteParams parameters;
    parameters.related_sample_identity(identity);
    const std::scoped_lock lock(order_);
    return write_with(const_cast<Bytes*>(&bytes), parameters);
  }
  /// The sample is a request whose reply goes to that reader. Returns its number.
  std::optional<std::int64_t> write_request(const Bytes& bytes, const EndpointId& replies) {
    rtps::SampleIdentity identity;
    identity.writer_guid(guid_of(replies));
    rtps::WriteParams parameters;
    parameters.related_sample_identity(identity);
    const std::scoped_lock lock(order_);
    if (!write_with(const_cast<Bytes*>(&bytes), parameters)) return std::nullopt;
    return number_of(parameters.sample_identity());
  }

  [[nodiscard]] int matched() const {
    const std::scoped_lock lock(mutex_);
    return static_cast<int>(readers_.size());
  }
  [[nodiscard]] bool has_matched(const EndpointId& reader) const {
    const std::scoped_lock lock(mutex_);
    return readers_.contains(reader);
  }
  [[nodiscard]] EndpointId id() const { return endpoint_id(writer_->guid()); }

 private:
  bool write_with(Bytes* bytes, rtps::WriteParams& parameters) {
#if HECATON_FAST_DDS == 3
    return outcome(writer_->write(bytes, parameters)) == Outcome::kOk;
#else
    return writer_->write(bytes, parameters);
#endif
  }
  void on_publication_matched(dds::DataWriter*, const dds::PublicationMatchedStatus& status) override {
    const EndpointId reader = endpoint_id(status.last_subscription_handle);
    {
      const std::scoped_lock lock(mutex_);
      if (status.current_count_change > 0) readers_.insert(reader);
      if (status.current_count_change < 0) readers_.erase(reader);
    }
    if (mailbox_ != nullptr) mailbox_->notify();
  }

  std::shared_ptr<Participant::Impl> participant_;
  Mailbox* mailbox_;
  std::mutex order_;  ///< held while a sample gets its number
  mutable std::mutex mutex_;
  std::set<EndpointId> readers_;
  dds::DataWriter* writer_ = nullptr;
};

struct RawSample {
  Sample sample;
  RequestId request;  ///< as a server reads it
  RequestId related;  ///< the request that the sample answers, as a client reads it
};

/// A reader, and the samples that wait for the service's loop.
class RawReader : public dds::DataReaderListener {
 public:
  RawReader(std::shared_ptr<Participant::Impl> participant, const Wire& wire, Mailbox& mailbox)
      : participant_(std::move(participant)), mailbox_(mailbox) {
    const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
    auto* topic = dds_topic(*participant_, wire);
    auto qos = reader_qos(wire.qos, false);
    announce_hash(qos, wire.hash);
    // Each sample gets a buffer of the largest size, and a larger sample none. With reallocation, a single fragment
    // could announce a sample of 4 GiB, for which Fast DDS would allocate memory.
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
    qos.resource_limits().allocated_samples = 1;
    reader_ = participant_->subscriber->create_datareader(topic, qos, this);
    if (reader_ == nullptr) fail(*participant_, "reader", wire);
  }
  ~RawReader() override {
    const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
    reader_->set_listener(nullptr, dds::StatusMask::none());
    participant_->remove_endpoint(
        [from = participant_->subscriber, reader = reader_] { from->delete_datareader(reader); });
  }
  RawReader(const RawReader&) = delete;
  RawReader& operator=(const RawReader&) = delete;

  std::vector<RawSample> take() {
    const std::scoped_lock lock(mutex_);
    std::vector<RawSample> samples(std::make_move_iterator(queue_.begin()), std::make_move_iterator(queue_.end()));
    queue_.clear();
    queued_bytes_ = 0;
    return samples;
  }
  [[nodiscard]] int matched() const { return matched_; }
  [[nodiscard]] EndpointId id() const { return endpoint_id(reader_->guid()); }

 private:
  void on_data_available(dds::DataReader* reader) override {
    Bytes bytes;
    dds::SampleInfo info;
    while (outcome(reader->take_next_sample(&bytes, &info)) == Outcome::kOk) {
      if (!info.valid_data) continue;
      const auto& related = info.related_sample_identity.writer_guid();
      RawSample sample{{bytes, endpoint_id(info.publication_handle), participant_->arrival()}, {}, {}};
      sample.request.client =
          related == rtps::GUID_t::unknown() ? endpoint_id(info.sample_identity.writer_guid()) : endpoint_id(related);
      sample.request.number = number_of(info.sample_identity);
      sample.related = {endpoint_id(related), number_of(info.related_sample_identity)};
      const std::scoped_lock lock(mutex_);
      queued_bytes_ += bytes.size();
      queue_.push_back(std::move(sample));
      while (queue_.size() > Reader::kQueue || queued_bytes_ > Reader::kQueueBytes) {
        queued_bytes_ -= queue_.front().sample.bytes.size();
        queue_.pop_front();
      }
    }
    mailbox_.notify();
  }
  void on_subscription_matched(dds::DataReader*, const dds::SubscriptionMatchedStatus& status) override {
    matched_ = status.current_count;
    mailbox_.notify();
  }

  std::shared_ptr<Participant::Impl> participant_;
  Mailbox& mailbox_;
  std::atomic<int> matched_ = 0;
  std::mutex mutex_;
  std::deque<RawSample> queue_;
  std::size_t queued_bytes_ = 0;  ///< in queue_
  dds::DataReader* reader_ = nullptr;
};

}  // namespace

ParticipantOptions participant_options(const std::string& enclave) {
  ParticipantOptions options;
  options.lease = kLease;
  options.user_data = "enclave=" + enclave + ";" + '\0';
  return options;
}

class Writer::Impl : public RawWriter {
 public:
  using RawWriter::RawWriter;
};

Writer::Writer(Participant& participant, const Topic& topic)
    : impl_(std::make_unique<Impl>(participant.impl(), wire_of(topic), nullptr)) {}
Writer::~Writer() = default;
Writer::Writer(Writer&&) noexcept = default;
Writer& Writer::operator=(Writer&&) noexcept = default;

bool Writer::write(const Bytes& bytes) {
  return impl_->write(bytes);
}
int Writer::matched() const {
  return impl_->matched();
}
EndpointId Writer::id() const {
  return impl_->id();
}

class Reader::Impl : public RawReader {
 public:
  using RawReader::RawReader;
};

Reader::Reader(Participant& participant, const Topic& topic, Mailbox& mailbox)
    : impl_(std::make_unique<Impl>(participant.impl(), wire_of(topic), mailbox)) {}
Reader::~Reader() = default;
Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;

std::vector<Sample> Reader::take() {
  std::vector<Sample> samples;
  for (RawSample& raw : impl_->take()) samples.push_back(std::move(raw.sample));
  return samples;
}
int Reader::matched() const {
  return impl_->matched();
}
EndpointId Reader::id() const {
  return impl_->id();
}

class Server::Impl {
 public:
  Impl(Participant& participant, const Service& service, Mailbox& mailbox)
      : replies_(participant.impl(), reply_of(service), &mailbox),
        requests_(participant.impl(), request_of(service), mailbox) {}

  std::vector<Request> take() {
    send_waiting();
    std::vector<Request> requests;
    for (RawSample& raw : requests_.take()) requests.push_back({raw.request, std::move(raw.sample.bytes)});
    return requests;
  }

  void reply(const RequestId& request, const Bytes& bytes) {
    if (waiting_.size() >= Reader::kQueue) waiting_.pop_front();
    waiting_.push_back({request, bytes, Clock::now() + kPatience});
    send_waiting();
  }

  [[nodiscard]] EndpointId writer() const { return replies_.id(); }
  [[nodiscard]] EndpointId reader() const { return requests_.id(); }

 private:
  struct Waiting {
    RequestId request;
    Bytes bytes;
    Clock::time_point until;
  };

  /// A client drops replies to requests that it has given up: no order is kept between clients.
  void send_waiting() {
    const auto now = Clock::now();
    std::erase_if(waiting_, [&](const Waiting& waiting) {
      if (is_reader(waiting.request.client) && !replies_.has_matched(waiting.request.client)) {
        return now > waiting.until;
      }
      replies_.write(waiting.bytes, waiting.request);
      return true;
    });
  }

  RawWriter replies_;  // a client looks for equal numbers of both: one of each
  RawReader requests_;
  std::deque<Waiting> waiting_;
};

Server::Server(Participant& participant, const Service& service, Mailbox& mailbox)
    : impl_(std::make_unique<Impl>(participant, service, mailbox)) {}
Server::~Server() = default;
Server::Server(Server&&) noexcept = default;
Server& Server::operator=(Server&&) noexcept = default;

std::vector<Request> Server::take() {
  return impl_->take();
}
void Server::reply(const RequestId& request, const Bytes& bytes) {
  impl_->reply(request, bytes);
}
EndpointId Server::writer_id() const {
  return impl_->writer();
}
EndpointId Server::reader_id() const {
  return impl_->reader();
}

class Client::Impl {
 public:
  Impl(Participant& participant, const Service& service, Mailbox& mailbox)
      : replies_(participant.impl(), reply_of(service), mailbox),
        requests_(participant.impl(), request_of(service), &mailbox) {}

  [[nodiscard]] bool available() const { return requests_.matched() > 0 && replies_.matched() > 0; }
  std::optional<std::int64_t> send(const Bytes& bytes) { return requests_.write_request(bytes, replies_.id()); }
  std::vector<Reply> take() {
    std::vector<Reply> replies;
    for (RawSample& raw : replies_.take()) {
      // A server that does not know the reader of replies names the writer of the request.
      if (raw.related.client != replies_.id() && raw.related.client != requests_.id()) continue;
      replies.push_back({raw.related.number, std::move(raw.sample.bytes)});
    }
    return replies;
  }

 private:
  RawReader replies_;
  RawWriter requests_;
};

Client::Client(Participant& participant, const Service& service, Mailbox& mailbox)
    : impl_(std::make_unique<Impl>(participant, service, mailbox)) {}
Client::~Client() = default;
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;

bool Client::available() const {
  return impl_->available();
}
std::optional<std::int64_t> Client::send(const Bytes& bytes) {
  return impl_->send(bytes);
}
std::vector<Reply> Client::take() {
  return impl_->take();
}

}  // namespace hecaton::bus::ros2
