#include "services/bus/endpoint_base.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "services/bus/qos.hpp"
#include "services/bus/source_time.hpp"

namespace hecaton::bus {
namespace {

/// The generated key buffer holds 255 characters of each key string.
constexpr std::size_t kLongestKey = 200;
/// The newest samples of all keys that a reader keeps [byte].
constexpr std::size_t kMostKept = 64U << 20U;

/// Fast DDS reports a full history as a time-out, too. A history of fixed depth can only lack room for another key.
std::string explain(Outcome code, const TopicInfo& info) {
  if (code == Outcome::kOutOfResources || code == Outcome::kTimeout) {
    return "no room within 10 ms: the topic allows " + std::to_string(info.qos.instances) + " keys at a time";
  }
  if (code == Outcome::kPreconditionNotMet) return "the key was never written";
  return "Fast DDS returned code " + std::to_string(static_cast<std::uint32_t>(code));
}

}  // namespace

WriterBase::WriterBase(std::shared_ptr<Participant::Impl> participant, const TopicInfo& info,
                       const dds::TypeSupport& type, const WriterOptions& options)
    : participant_(std::move(participant)), info_(info), type_(type), keyed_(has_key(type)), mailbox_(options.mailbox) {
  const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
  publisher_ = info.qos.partition_per_key ? participant_->publisher_of(options.key) : participant_->publisher;
  auto* topic = participant_->topic(info, type_);
  writer_ = publisher_->create_datawriter(topic, writer_qos(info.qos, keyed_), this);
  if (writer_ == nullptr) throw std::runtime_error("bus: cannot create a writer of " + std::string(info.name));
}

WriterBase::~WriterBase() {
  const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
  writer_->set_listener(nullptr, dds::StatusMask::none());
  participant_->remove_endpoint([from = publisher_, writer = writer_] {
    // Otherwise Fast DDS 2.9.1 removes the samples one by one while its thread of timers announces the rest to readers
    // without acknowledgement. From the number of a removed sample that thread counts on for ever, and holds a lock.
    std::size_t removed = 0;
    writer->clear_history(&removed);
    from->delete_datawriter(writer);
  });
}

WriteResult WriterBase::send(Action action, void* data, const std::string& key) {
  if (keyed_ && key.empty()) return refuse(action, key, "the key is empty");
  if (key.size() > kLongestKey) return refuse(action, key, "the key is longer than 200 characters");
  if (action == Action::kRetire && !keyed_) return refuse(action, key, "the topic has no key");
  const auto code = [&] {
    // The order of numbers and of source times must agree.
    const std::scoped_lock lock(order_);
    const auto now = duration(source_time());
    return outcome(action == Action::kWrite ? writer_->write_w_timestamp(data, dds::HANDLE_NIL, now)
                                            : writer_->unregister_instance_w_timestamp(data, dds::HANDLE_NIL, now));
  }();
  if (code == Outcome::kOk) return {true, {}};
  return refuse(action, key, explain(code, info_));
}

WriteResult WriterBase::refuse(Action action, const std::string& key, const std::string& why) {
  WriteResult result{false, std::string(info_.name) + (key.empty() ? "" : " \"" + key + "\"") +
                                (action == Action::kWrite ? " not written: " : " not retired: ") + why};
  if (!refused_before_.exchange(true)) std::fprintf(stderr, "bus: %s\n", result.reason.c_str());
  return result;
}

void WriterBase::clear_history() {
  std::size_t removed = 0;
  writer_->clear_history(&removed);
}

bool WriterBase::wait_matched(int readers, Clock::duration timeout) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, timeout, [&] { return matched_ >= readers; });
}

bool WriterBase::wait_acknowledged(Clock::duration timeout) const {
  return outcome(writer_->wait_for_acknowledgments(duration(timeout))) == Outcome::kOk;
}

EndpointId WriterBase::id() const {
  return endpoint_id(writer_->guid());
}

void WriterBase::on_publication_matched(dds::DataWriter*, const dds::PublicationMatchedStatus& status) {
  {
    const std::scoped_lock lock(mutex_);
    matched_ = status.current_count;
  }
  changed_.notify_all();
  if (status.current_count_change > 0) participant_->note_match(endpoint_id(status.last_subscription_handle));
  if (mailbox_ == nullptr) return;
  const auto kind = status.current_count_change > 0 ? EventKind::kPeerMatched : EventKind::kPeerLost;
  mailbox_->post({kind, info_.name, {}, endpoint_id(status.last_subscription_handle), Clock::now()});
}

void WriterBase::on_offered_incompatible_qos(dds::DataWriter*, const dds::OfferedIncompatibleQosStatus& status) {
  if (mailbox_ == nullptr) return;
  mailbox_->post({EventKind::kIncompatible, info_.name, policy_name(status.last_policy_id), {}, Clock::now()});
}

ReaderBase::ReaderBase(std::shared_ptr<Participant::Impl> participant, const TopicInfo& info, Mailbox* mailbox)
    : participant_(std::move(participant)),
      info_(info),
      own_mailbox_(mailbox == nullptr ? std::make_unique<Mailbox>() : nullptr),
      mailbox_(mailbox == nullptr ? own_mailbox_.get() : mailbox),
      admission_({static_cast<std::size_t>(info.qos.instances), kMostKept}) {}

ReaderBase::~ReaderBase() = default;

void ReaderBase::open(const dds::TypeSupport& type, const ReaderOptions& options) {
  type_ = type;
  deadline_ = options.deadline.value_or(info_.qos.deadline);
  const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
  auto* topic = participant_->topic(info_, type_);
  subscriber_ = info_.qos.partition_per_key ? participant_->subscriber_of(options.keys) : participant_->subscriber;
  reader_ = subscriber_->create_datareader(topic, reader_qos(info_.qos, has_key(type_)), this);
  if (reader_ == nullptr) throw std::runtime_error("bus: cannot create a reader of " + std::string(info_.name));
  if (deadline_ > Clock::duration::zero()) participant_->monitor(*this);
}

void ReaderBase::close() {
  if (reader_ == nullptr) return;
  participant_->unmonitor(*this);
  const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
  reader_->set_listener(nullptr, dds::StatusMask::none());
  participant_->remove_endpoint([from = subscriber_, reader = reader_] { from->delete_datareader(reader); });
  reader_ = nullptr;
}

bool ReaderBase::wait_matched(int writers, Clock::duration timeout) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, timeout, [&] { return matched_ >= writers; });
}

ReaderCounters ReaderBase::counters() const {
  const std::scoped_lock lock(mutex_);
  return counters_;
}

void ReaderBase::note_alive(const dds::SampleInfo& info, const std::string& key) {
  const auto [handle, is_new] = handles_.try_emplace(key, info.instance_handle);
  if (!is_new && handle->second != info.instance_handle) {
    keys_.erase(handle->second);
    handle->second = info.instance_handle;
  }
  auto& known = keys_[info.instance_handle];
  if (known.text != key) {
    if (!known.text.empty()) handles_.erase(known.text);
    known.text = key;
  }
  known.writer = endpoint_id(info.publication_handle);
  known.heard = Clock::now();
  if (std::exchange(known.missing, false) && deadline_ > Clock::duration::zero()) {
    participant_->check_by(known.heard + deadline_);
  }
}

void ReaderBase::forget_key(const std::string& text) {
  admission_.holders.erase(text);
  admission_.changes.erase(text);
  const auto handle = handles_.find(text);
  if (handle == handles_.end()) return;
  keys_.erase(handle->second);
  handles_.erase(handle);
}

bool ReaderBase::admit(const dds::SampleInfo& info, const std::string& key, const Arrival& arrival,
                       std::uint32_t most_a_second) {
  const auto now = Clock::now();
  const EndpointId writer = endpoint_id(info.publication_handle);
  if (!admission_.rates[writer].admits(now, most_a_second)) {
    refuse(info, RefusalKind::kMalformed, "more than " + std::to_string(most_a_second) + " samples a second");
    return false;
  }
  if (!is_free(info, key, now)) {
    ++counters_.refused;
    return false;
  }
  if (!participant_->terms().admits(arrival.largest_term, now)) {
    refuse(info, RefusalKind::kMalformed,
           "term = " + std::to_string(arrival.largest_term) + " is more than " + std::to_string(kTermLeap) +
               " above every known term");
    return false;
  }
  if (!admission_.table.admit(key, writer, arrival.bytes, displaced_)) {
    refuse(info, RefusalKind::kMalformed,
           "more than " + std::to_string(info_.qos.instances) + " keys, or " + std::to_string(kMostKept >> 20U) +
               " MiB of samples");
    return false;
  }
  for (const KeyTable::Key& lost : displaced_) forget_key(lost.text);
  hold(info, key, now);
  return true;
}

std::optional<EndpointId> ReaderBase::other_owner(const dds::SampleInfo& info, const std::string& node,
                                                  Clock::time_point now) {
  return participant_->owners().owner_beside(endpoint_id(info.publication_handle), node, now);
}

void ReaderBase::note_challenge(const dds::SampleInfo& info, const std::string& key, const EndpointId& owner,
                                Clock::time_point now) {
  ++counters_.refused;
  participant_->owners().note_challenge({endpoint_id(info.publication_handle), std::string(info_.type), key}, owner,
                                        now);
}

bool ReaderBase::is_free(const dds::SampleInfo& info, const std::string& key, Clock::time_point now) {
  const auto holder = admission_.holders.find(key);
  return holder == admission_.holders.end() ||
         holder->second.admits(endpoint_id(info.publication_handle), now, info_.qos.hold);
}

void ReaderBase::hold(const dds::SampleInfo& info, const std::string& key, Clock::time_point now) {
  if (info_.qos.hold.count() == 0) return;
  const auto [holder, is_new] = admission_.holders.try_emplace(key);
  if (is_new) static_cast<void>(holder->second.admits(endpoint_id(info.publication_handle), now, info_.qos.hold));
  if (const auto second = holder->second.take_challenger()) report_second_writer(*second, key, now);
}

void ReaderBase::note_writer(const dds::SampleInfo& info, const std::string& key, std::uint64_t term) {
  if (!info_.qos.reports_writers) return;
  const auto now = Clock::now();
  const EndpointId writer = endpoint_id(info.publication_handle);
  if (admission_.changes[key].note(writer, term, now)) report_second_writer(writer, key, now);
}

void ReaderBase::report_second_writer(const EndpointId& second, const std::string& key, Clock::time_point now) {
  participant_->refusals().note({.kind = RefusalKind::kSecondWriter,
                                 .topic = std::string(info_.type),
                                 .sender = second,
                                 .key = key,
                                 .text = "a second participant writes it",
                                 .last = now});
}

void ReaderBase::refuse(const dds::SampleInfo& info, RefusalKind kind, const std::string& text,
                        const std::string& key) {
  ++counters_.refused;
  participant_->refusals().note({.kind = kind,
                                 .topic = std::string(info_.type),
                                 .sender = endpoint_id(info.publication_handle),
                                 .key = key,
                                 .text = text,
                                 .last = Clock::now()});
}

std::string ReaderBase::forget(const dds::SampleInfo& info) {
  const auto known = keys_.find(info.instance_handle);
  if (known == keys_.end()) return {};
  if (!known->second.writer.same_participant(endpoint_id(info.publication_handle))) return {};
  const std::string key = known->second.text;
  admission_.table.erase(key);
  forget_key(key);
  return key;
}

void ReaderBase::on_data_available(dds::DataReader* reader) {
  // Two receiving threads may announce data at the same time. One drains for both, which keeps the order of arrival. It
  // takes no lock, because Fast DDS holds its own ones during this call.
  if (announcements_.fetch_add(1) > 0) return;
  int served = 0;
  do {
    served = announcements_.load();
    drain(*reader);
  } while (announcements_.fetch_sub(served) != served);
  mailbox_->notify();
}

void ReaderBase::on_subscription_matched(dds::DataReader*, const dds::SubscriptionMatchedStatus& status) {
  const auto peer = endpoint_id(status.last_publication_handle);
  const bool found = status.current_count_change > 0;
  std::string last_key;
  if (found) participant_->note_match(peer);  // before wait_matched() returns
  {
    const std::scoped_lock lock(mutex_);
    matched_ = status.current_count;
    // A writer that has left is reported as lost; its keys then miss no deadlines.
    if (!found) {
      last_key = last_key_of(peer);
      admission_.rates.erase(peer);
      std::erase_if(admission_.holders, [&](const auto& entry) { return entry.second.holder() == peer; });
      std::erase_if(keys_, [&](const auto& entry) { return entry.second.writer == peer; });
      std::erase_if(handles_, [&](const auto& entry) { return !keys_.contains(entry.second); });
      admission_.table.left(peer);
    }
  }
  changed_.notify_all();
  mailbox_->post({found ? EventKind::kPeerMatched : EventKind::kPeerLost, info_.name, last_key, peer, Clock::now()});
}

Clock::time_point ReaderBase::check(Clock::time_point now, Clock::time_point since) {
  const std::scoped_lock lock(mutex_);
  auto next = Clock::time_point::max();
  for (auto& [handle, key] : keys_) {
    if (key.missing) continue;
    const auto due = std::max(key.heard, since) + deadline_;
    if (due > now) {
      next = std::min(next, due);
      continue;
    }
    key.missing = true;
    ++counters_.deadlines_missed;
    mailbox_->post({EventKind::kDeadlineMissed, info_.name, key.text, key.writer, now});
  }
  return next;
}

std::string ReaderBase::last_key_of(const EndpointId& writer) const {
  for (const auto& [handle, key] : keys_) {
    if (key.writer == writer) return key.text;
  }
  return {};
}

void ReaderBase::on_requested_incompatible_qos(dds::DataReader*, const dds::RequestedIncompatibleQosStatus& status) {
  mailbox_->post({EventKind::kIncompatible, info_.name, policy_name(status.last_policy_id), {}, Clock::now()});
}

}  // namespace hecaton::bus
