#pragma once
/// The definitions of Writer and Reader. services/bus instantiates them for the topics of topics.hpp. A source that
/// CMake writes (hecaton_topics in cmake/HecatonIdl.cmake) does so for the topics of other folders; no other source
/// includes this header.

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "services/bus/endpoint.hpp"
#include "services/bus/endpoint_base.hpp"

namespace hecaton::bus {

/// The generated serialisation of a message type.
template <class T>
struct PubSubOf;

/// The type support of a message, see GuardedSupport.
template <class T>
using GuardedType = GuardedSupport<typename PubSubOf<T>::type, T>;

/// Null for topics of other folders.
template <class T>
[[nodiscard]] const TopicRule* rule_of() {
  constexpr std::string_view kOwn = "hecaton/";
  const TopicInfo& info = Topic<T>::kInfo;
  return info.name.starts_with(kOwn) && info.name.substr(kOwn.size()) == info.type ? topic_rule(info.type) : nullptr;
}

template <class T>
[[nodiscard]] dds::TypeSupport make_type_support() {
  const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
  return dds::TypeSupport(new GuardedType<T>(rule_of<T>(), kMostBytes));
}

/// The term by which readers choose between two writers of a key; 0: they choose otherwise.
template <class T>
[[nodiscard]] std::uint64_t deciding_term([[maybe_unused]] const T& sample) {
  if constexpr (std::is_same_v<T, msg::CellMode>) {
    return sample.term();
  } else {
    return 0;
  }
}

/// The node whose participants alone write the sample, see NodeOwners; empty: those of other nodes may write it, too.
template <class T>
[[nodiscard]] std::string owning_node([[maybe_unused]] const T& sample) {
  if constexpr (std::is_same_v<T, msg::GoalStatus> || std::is_same_v<T, msg::CoupledPlan> ||
                std::is_same_v<T, msg::CoupledPlanProgress> || std::is_same_v<T, msg::PlannerTick> ||
                std::is_same_v<T, msg::PlannedMotion>) {
    return "planner/" + sample.arm();
  } else if constexpr (std::is_same_v<T, msg::Fault> || std::is_same_v<T, msg::SupervisorReply>) {
    return "supervisor";
  } else {
    return {};
  }
}

/// Samples between the middleware's thread and the service's loop. The owner locks it.
template <class T>
class SampleQueue {
 public:
  /// Of samples that wait, as they were received [byte].
  static constexpr std::size_t kMostBytes = 64U << 20U;

  /// `conflate`: keep only the newest sample of each key. Its reader bounds the number of keys.
  SampleQueue(bool conflate, std::size_t capacity)
      : conflate_(conflate), capacity_(std::max<std::size_t>(capacity, 1)) {}

  /// Returns the number of samples dropped to make room. `bytes`: the sample as it was received.
  std::size_t push(Sample<T> sample, std::size_t bytes) {
    if (conflate_) {
      newest_.insert_or_assign(sample.key, std::move(sample));
      return 0;
    }
    std::size_t dropped = 0;
    for (; !queue_.empty() && (queue_.size() >= capacity_ || bytes_ + bytes > kMostBytes); ++dropped) {
      bytes_ -= queue_.front().bytes;
      queue_.pop_front();
    }
    queue_.push_back({std::move(sample), bytes});
    bytes_ += bytes;
    return dropped;
  }

  /// Returns and removes all samples, in order of arrival.
  std::vector<Sample<T>> take() {
    std::vector<Sample<T>> samples;
    samples.reserve(queue_.size() + newest_.size());
    for (auto& waiting : queue_) samples.push_back(std::move(waiting.sample));
    for (auto& [key, sample] : newest_) samples.push_back(std::move(sample));
    queue_.clear();
    bytes_ = 0;
    newest_.clear();
    if (conflate_) {
      std::sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) { return a.received < b.received; });
    }
    return samples;
  }

 private:
  struct Waiting {
    Sample<T> sample;
    std::size_t bytes;
  };
  bool conflate_;
  std::size_t capacity_;
  std::size_t bytes_ = 0;  ///< of queue_
  std::deque<Waiting> queue_;
  std::map<std::string, Sample<T>> newest_;
};

template <class T>
struct Writer<T>::Impl : WriterBase {
  Impl(const Participant& participant, const WriterOptions& options)
      : WriterBase(participant.impl(), Topic<T>::kInfo, make_type_support<T>(), options) {}

  std::mutex retained_mutex;
  std::deque<std::pair<std::string, T>> retained;  ///< living keys, the oldest first
};

template <class T>
Writer<T>::Writer(Participant& participant, const WriterOptions& options)
    : impl_(std::make_unique<Impl>(participant, options)) {}
template <class T>
Writer<T>::~Writer() = default;
template <class T>
Writer<T>::Writer(Writer&&) noexcept = default;
template <class T>
Writer<T>& Writer<T>::operator=(Writer&&) noexcept = default;

template <class T>
WriteResult Writer<T>::write(const T& sample) {
  auto& impl = *impl_;
  const std::string key = key_of(sample);
  // Fast DDS takes void*, but serialisation only reads.
  auto result = impl.send(WriterBase::Action::kWrite, const_cast<T*>(&sample), key);
  constexpr auto kRetained = static_cast<std::size_t>(Topic<T>::kInfo.qos.retained);
  if constexpr (kRetained > 0) {
    if (!result) return result;
    const std::scoped_lock lock(impl.retained_mutex);
    std::erase_if(impl.retained, [&](const auto& entry) { return entry.first == key; });
    impl.retained.emplace_back(key, sample);
    if (impl.retained.size() > kRetained) {
      auto& [oldest_key, oldest] = impl.retained.front();
      if (auto retired = impl.send(WriterBase::Action::kRetire, &oldest, oldest_key); !retired) result = retired;
      impl.retained.pop_front();
    }
  }
  return result;
}

template <class T>
WriteResult Writer<T>::retire(const T& sample) {
  const std::string key = key_of(sample);
  {
    const std::scoped_lock lock(impl_->retained_mutex);
    std::erase_if(impl_->retained, [&](const auto& entry) { return entry.first == key; });
  }
  return impl_->send(WriterBase::Action::kRetire, const_cast<T*>(&sample), key);
}

template <class T>
int Writer<T>::matched() const {
  return impl_->matched();
}
template <class T>
bool Writer<T>::wait_matched(int readers, Clock::duration timeout) const {
  return impl_->wait_matched(readers, timeout);
}
template <class T>
void Writer<T>::clear_history() {
  impl_->clear_history();
}
template <class T>
bool Writer<T>::wait_acknowledged(Clock::duration timeout) const {
  return impl_->wait_acknowledged(timeout);
}
template <class T>
EndpointId Writer<T>::id() const {
  return impl_->id();
}
template <class T>
std::optional<std::string> Writer<T>::refusal_of(const T& sample) {
  const TopicRule* rule = rule_of<T>();
  if (!rule) return {};
  static GuardedType<T> support;  // kept: the generated constructor is slow for nested types
  const std::string bytes = support.bytes_of(sample);
  return check_sample(*rule, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}).refusal;
}

template <class T>
struct Reader<T>::Impl : ReaderBase {
  Impl(const Participant& participant, Mailbox* mailbox, const ReaderOptions& options)
      : ReaderBase(participant.impl(), Topic<T>::kInfo, mailbox),
        queue(options.conflate.value_or(!Topic<T>::kInfo.qos.reliable && Topic<T>::kInfo.qos.reader_depth == 0),
              options.queue) {
    if (schema == 0)
      throw std::runtime_error(std::string(Topic<T>::kInfo.name) + ": schema must have a default above 0");
    open(make_type_support<T>(), options);
  }
  ~Impl() override { close(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void drain(dds::DataReader& reader) override {
    dds::SampleInfo info;
    while (outcome(reader.take_next_sample(&scratch, &info)) == Outcome::kOk) {
      const auto received = arrival();
      const std::scoped_lock lock(mutex_);
      if (!info.valid_data) {
        if (info.instance_state != dds::NOT_ALIVE_DISPOSED_INSTANCE_STATE) continue;
        const std::string key = forget(info);
        if (key.empty()) continue;
        counters_.overflowed += queue.push({T(), key, received, endpoint_id(info.publication_handle), true}, 0);
      } else if (scratch.schema() != schema) {
        ++counters_.unreadable;
        if (last_check.refusal) refuse(info, RefusalKind::kMalformed, *last_check.refusal);
      } else {
        const Arrival arrived{last_check.largest_term, last_size};
        Sample<T> sample{scratch, key_of(scratch), received, endpoint_id(info.publication_handle), false};
        if (defers(info, sample, arrived)) continue;
        accept(info, std::move(sample), arrived);
      }
    }
  }

  /// True when another participant owns the sample, which is then kept for a while.
  [[nodiscard]] bool defers(const dds::SampleInfo& info, Sample<T>& sample, const Arrival& arrived) {
    const std::string node = owning_node(sample.value);
    if (node.empty()) return false;
    const auto now = Clock::now();
    const auto owner = other_owner(info, node, now);
    if (!owner) {
      admit_deferred(now);
      return false;
    }
    note_challenge(info, sample.key, *owner, now);
    defer({std::move(sample), info, arrived, node, now});
    return true;
  }

  /// A sample for the service, unless it is refused.
  void accept(const dds::SampleInfo& info, Sample<T> sample, const Arrival& arrived) {
    const bool admitted = admit(info, sample.key, arrived, most_a_second);
    for (auto& lost : take_displaced()) {
      counters_.overflowed += queue.push({T(), std::move(lost.text), sample.received, lost.writer, true}, 0);
    }
    if (!admitted) return;
    note_writer(info, sample.key, deciding_term(sample.value));
    ++counters_.received;
    note_alive(info, sample.key);
    counters_.overflowed += queue.push(std::move(sample), arrived.bytes);
  }

  /// A sample of a participant that may be the successor of its owner: silence shows soon which one it is.
  struct Deferred {
    Sample<T> sample;
    dds::SampleInfo info;
    Arrival arrived;
    std::string node;
    Clock::time_point since;
  };
  void defer(Deferred one) {
    constexpr std::size_t kMostDeferred = 64;
    constexpr std::size_t kMostDeferredBytes = 4U << 20U;
    deferred_bytes += one.arrived.bytes;
    deferred.push_back(std::move(one));
    while (deferred.size() > kMostDeferred || (deferred.size() > 1 && deferred_bytes > kMostDeferredBytes)) {
      deferred_bytes -= deferred.front().arrived.bytes;
      deferred.pop_front();
    }
  }
  /// Accepts what has no other owner any more, in the order of its arrival.
  void admit_deferred(Clock::time_point now) {
    constexpr Clock::duration kLongest = 2 * NodeOwners::kSilence;
    deferred_bytes = 0;
    for (Deferred& one : std::exchange(deferred, {})) {
      if (now - one.since > kLongest) continue;
      if (other_owner(one.info, one.node, now)) {
        defer(std::move(one));
      } else {
        accept(one.info, std::move(one.sample), one.arrived);
      }
    }
  }

  std::vector<Sample<T>> take() {
    const std::scoped_lock lock(mutex_);
    if (!deferred.empty()) admit_deferred(Clock::now());
    return queue.take();
  }

  void note(const Sample<T>& sample) {
    if (sample.disposed) {
      newest.erase(sample.key);
    } else {
      newest.insert_or_assign(sample.key, sample);
      if (newest.size() > kMostNewest) drop_oldest();
    }
  }
  /// The reader has displaced keys, but their notices were dropped from a full queue.
  void drop_oldest() {
    newest.erase(std::min_element(newest.begin(), newest.end(),
                                  [](const auto& a, const auto& b) { return a.second.received < b.second.received; }));
  }

  static constexpr auto kMostNewest = static_cast<std::size_t>(Topic<T>::kInfo.qos.instances);
  SampleQueue<T> queue;
  const std::uint32_t schema = T().schema();  ///< of samples that drain() keeps
  const std::uint32_t most_a_second = rule_of<T>() == nullptr ? 0 : rule_of<T>()->most_a_second;
  std::deque<Deferred> deferred;   ///< the oldest first
  std::size_t deferred_bytes = 0;  ///< as received
  T scratch;                       ///< of drain()
  Latest newest;                   ///< of the loop's thread alone
};

template <class T>
Reader<T>::Reader(Participant& participant, Mailbox* mailbox, const ReaderOptions& options)
    : impl_(std::make_unique<Impl>(participant, mailbox, options)) {}
template <class T>
Reader<T>::~Reader() = default;
template <class T>
Reader<T>::Reader(Reader&&) noexcept = default;
template <class T>
Reader<T>& Reader<T>::operator=(Reader&&) noexcept = default;

template <class T>
std::vector<Sample<T>> Reader<T>::take() {
  auto samples = impl_->take();
  for (const auto& sample : samples) impl_->note(sample);
  return samples;
}

template <class T>
const typename Reader<T>::Latest& Reader<T>::latest() {
  for (const auto& sample : impl_->take()) impl_->note(sample);
  return impl_->newest;
}

template <class T>
const Sample<T>* Reader<T>::latest(std::string_view key) {
  const auto& all = latest();
  const auto found = all.find(key);
  return found == all.end() ? nullptr : &found->second;
}

template <class T>
bool Reader<T>::wait_for_data(Clock::duration timeout) {
  return impl_->mailbox().wait(timeout);
}
template <class T>
Mailbox& Reader<T>::mailbox() {
  return impl_->mailbox();
}
template <class T>
int Reader<T>::matched() const {
  return impl_->matched();
}
template <class T>
bool Reader<T>::wait_matched(int writers, Clock::duration timeout) const {
  return impl_->wait_matched(writers, timeout);
}
template <class T>
ReaderCounters Reader<T>::counters() const {
  return impl_->counters();
}

}  // namespace hecaton::bus

/// Makes Writer<Type> and Reader<Type> usable in other sources. `Type` is a qualified name. Its Topic and its generated
/// PubSubTypes header come first. In the global namespace.
#define HECATON_DEFINE_TOPIC(Type)           \
  template <>                                \
  struct hecaton::bus::PubSubOf<Type> {      \
    using type = Type##PubSubType;           \
  };                                         \
  template class hecaton::bus::Writer<Type>; \
  template class hecaton::bus::Reader<Type>;
