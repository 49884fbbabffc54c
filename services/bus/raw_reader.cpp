#include "services/bus/raw_reader.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <iterator>
#include <mutex>
#include <utility>

#include "services/bus/type_support.hpp"

namespace hecaton::bus {
namespace {

/// A message and the bytes that it was decoded from.
template <class T>
struct Decoded {
  T value;
  RawBytes bytes;
};

/// The type support of T for samples of type Decoded<T>.
template <class T>
class DecodedType : public GuardedType<T> {
 public:
  using GuardedType<T>::GuardedType;

#if HECATON_FAST_DDS == 3
  using GuardedType<T>::compute_key;
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) override {
    keep(payload, data);
    return GuardedType<T>::deserialize(payload, &sample(data)->value);
  }
  bool compute_key(const void* const data, rtps::InstanceHandle_t& handle, bool force_md5) override {
    return GuardedType<T>::compute_key(&static_cast<const Decoded<T>*>(data)->value, handle, force_md5);
  }
  void* create_data() override {
    return new Decoded<T>();
  }
  void delete_data(void* data) override {
    delete sample(data);
  }
#else
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    keep(*payload, data);
    return GuardedType<T>::deserialize(payload, &sample(data)->value);
  }
  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool force_md5) override {
    return GuardedType<T>::getKey(&sample(data)->value, handle, force_md5);
  }
  void* createData() override {
    return new Decoded<T>();
  }
  void deleteData(void* data) override {
    delete sample(data);
  }
#endif

 private:
  static Decoded<T>* sample(void* data) {
    return static_cast<Decoded<T>*>(data);
  }
  static void keep(const rtps::SerializedPayload_t& payload, void* data) {
    sample(data)->bytes.assign(payload.data, payload.data + payload.length);
  }
};

std::int64_t nanoseconds_of(const rtps::Time_t& time) {
  return time.seconds() <= 0 ? 0 : time.to_ns();
}

/// Samples of all topics, in order of arrival. Thread-safe.
class RawQueue {
 public:
  explicit RawQueue(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// False: there is no room.
  bool push(RawSample sample) {
    const std::scoped_lock lock(mutex_);
    const std::size_t size = sizeof(RawSample) + sample.bytes.size() + sample.key.size();
    if (bytes_ + size > most_bytes_) return false;
    bytes_ += size;
    queue_.push_back(std::move(sample));
    return true;
  }
  std::vector<RawSample> take() {
    std::vector<RawSample> samples;
    const std::scoped_lock lock(mutex_);
    samples.swap(queue_);
    bytes_ = 0;
    return samples;
  }

 private:
  std::size_t most_bytes_;
  std::mutex mutex_;
  std::vector<RawSample> queue_;
  std::size_t bytes_ = 0;
};

/// The reader of one topic.
class AnyRawReader {
 public:
  virtual ~AnyRawReader() = default;
  [[nodiscard]] virtual RawCounters raw_counters() const = 0;
  [[nodiscard]] virtual int writers() const = 0;
};

template <class T>
class TypedRawReader : public AnyRawReader, private ReaderBase {
 public:
  TypedRawReader(Participant& participant, const TopicInfo& info, std::size_t index, Mailbox& mailbox, RawQueue& queue)
      : ReaderBase(participant.impl(), info, &mailbox), index_(index), queue_(queue) {
    ReaderOptions options;
    options.deadline = std::chrono::milliseconds(0);  // silence is no loss for a recorder
    open(type_support(), options);
  }
  ~TypedRawReader() override { close(); }
  TypedRawReader(const TypedRawReader&) = delete;
  TypedRawReader& operator=(const TypedRawReader&) = delete;

  [[nodiscard]] RawCounters raw_counters() const override {
    const ReaderCounters all = counters();
    return {all.received, all.refused, all.unreadable, all.overflowed, lost_};
  }
  [[nodiscard]] int writers() const override { return matched(); }

 private:
  static dds::TypeSupport type_support() {
    const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
    return dds::TypeSupport(new DecodedType<T>(rule_of<T>(), kMostBytes));
  }

  void drain(dds::DataReader& reader) override {
    dds::SampleInfo info;
    while (outcome(reader.take_next_sample(&scratch_, &info)) == Outcome::kOk) {
      RawSample sample;
      sample.topic = index_;
      sample.writer = endpoint_id(info.publication_handle);
      sample.number = info.sample_identity.sequence_number().to64long();
      sample.written_ns = nanoseconds_of(info.source_timestamp);
      sample.received = arrival();
      const std::scoped_lock lock(mutex_);
      if (info.valid_data ? fill(info, sample) : fill_withdrawn(info, sample)) {
        if (!queue_.push(std::move(sample))) ++counters_.overflowed;
      }
    }
  }

  /// As Reader<T>::Impl::drain(). False: the sample is refused.
  bool fill(const dds::SampleInfo& info, RawSample& sample) {
    const T& value = scratch_.value;
    if (value.schema() != schema_) {
      ++counters_.unreadable;
      if (last_check.refusal) refuse(info, RefusalKind::kMalformed, *last_check.refusal);
      return false;
    }
    sample.key = key_of(value);
    const bool admitted = admit(info, sample.key, {last_check.largest_term, last_size}, rule_of<T>()->most_a_second);
    static_cast<void>(take_displaced());  // they are kept nowhere
    if (!admitted) return false;
    ++counters_.received;
    note_alive(info, sample.key);
    if constexpr (requires { value.sequence_number(); }) sample.sequence_number = value.sequence_number();
    sample.bytes = scratch_.bytes;
    return true;
  }

  bool fill_withdrawn(const dds::SampleInfo& info, RawSample& sample) {
    if (info.instance_state != dds::NOT_ALIVE_DISPOSED_INSTANCE_STATE) return false;
    sample.key = forget(info);
    sample.withdrawn = true;
    return !sample.key.empty();
  }

  void on_sample_lost(dds::DataReader*, const dds::SampleLostStatus& status) override {
    lost_ = static_cast<std::uint64_t>(std::max(status.total_count, 0));
  }

  std::size_t index_;
  RawQueue& queue_;
  const std::uint32_t schema_ = T().schema();
  Decoded<T> scratch_;  ///< of drain()
  std::atomic<std::uint64_t> lost_ = 0;
};

}  // namespace

class RawReaders::Impl {
 public:
  Impl(Participant& participant, Mailbox& mailbox, std::size_t most_bytes) : queue_(most_bytes) {
    for (std::size_t i = 0; i < kTopics.size(); ++i) {
      infos_[i] = kTopics[i];
      infos_[i].qos.depth = std::max(infos_[i].qos.depth, kDepth);
    }
    std::size_t index = 0;
#define HECATON_RAW_READER(Type, ...)                                                                                  \
  readers_.push_back(std::make_unique<TypedRawReader<msg::Type>>(participant, infos_[index], index, mailbox, queue_)); \
  ++index;
    HECATON_TOPICS(HECATON_RAW_READER)
#undef HECATON_RAW_READER
  }

  std::vector<RawSample> take() {
    return queue_.take();
  }
  [[nodiscard]] std::vector<RawCounters> counters() const {
    std::vector<RawCounters> all;
    for (const auto& reader : readers_) all.push_back(reader->raw_counters());
    return all;
  }
  [[nodiscard]] int matched() const {
    int all = 0;
    for (const auto& reader : readers_) all += reader->writers();
    return all;
  }

 private:
  RawQueue queue_;
  std::array<TopicInfo, kTopics.size()> infos_{};
  std::vector<std::unique_ptr<AnyRawReader>> readers_;
};

RawReaders::RawReaders(Participant& participant, Mailbox& mailbox, std::size_t most_bytes)
    : impl_(std::make_unique<Impl>(participant, mailbox, most_bytes)) {}
RawReaders::~RawReaders() = default;

std::vector<RawSample> RawReaders::take() {
  return impl_->take();
}
std::vector<RawCounters> RawReaders::counters() const {
  return impl_->counters();
}
int RawReaders::matched() const {
  return impl_->matched();
}

}  // namespace hecaton::bus
