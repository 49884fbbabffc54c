#include "services/bus/reader_base.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "services/bus/incompatible.hpp"
#include "services/bus/quality.hpp"

namespace hecaton::bus {

ReaderBase::ReaderBase(std::shared_ptr<Participant::Impl> participant, const TopicInfo& info, Mailbox* mailbox)
    : participant_(std::move(participant)),
      info_(info),
      own_mailbox_(mailbox == nullptr ? std::make_unique<Mailbox>() : nullptr),
      mailbox_(mailbox == nullptr ? own_mailbox_.get() : mailbox) {}

ReaderBase::~ReaderBase() = default;

void ReaderBase::open(const dds::TypeSupport& type, const ReaderOptions& options) {
  type_ = type;
  Qos qos = info_.qos;
  qos.deadline = options.deadline.value_or(qos.deadline);
  deadline_ = qos.deadline;
  const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
  auto* topic = participant_->topic(info_, type_);
  reader_ = participant_->subscriber->create_datareader(topic, reader_qos(qos, has_key(type_)), this);
  if (reader_ == nullptr) throw std::runtime_error("bus: cannot create a reader of " + std::string(info_.name));
  if (deadline_ > Clock::duration::zero()) participant_->watch(*this);
}

void ReaderBase::close() {
  if (reader_ == nullptr) return;
  participant_->unwatch(*this);
  const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
  reader_->set_listener(nullptr, dds::StatusMask::none());
  participant_->remove([from = participant_->subscriber, reader = reader_] { from->delete_datareader(reader); });
  reader_ = nullptr;
}

bool ReaderBase::wait_matched(int writers, Clock::duration timeout) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, timeout, [&] { return matched_ >= writers; });
}

int ReaderBase::alive_writers() const {
  const std::scoped_lock lock(mutex_);
  return matched_ - static_cast<int>(silent_.size());
}

ReaderCounters ReaderBase::counters() const {
  const std::scoped_lock lock(mutex_);
  return counters_;
}

void ReaderBase::note_alive(const dds::SampleInfo& info, const std::string& key) {
  auto& known = keys_[info.instance_handle];
  if (known.text != key) known.text = key;
  known.writer = endpoint_id(info.publication_handle);
  known.heard = Clock::now();
  if (std::exchange(known.missing, false) && deadline_ > Clock::duration::zero()) {
    participant_->look_by(known.heard + deadline_);
  }
  if (silent_.erase(known.writer) > 0) {
    mailbox_->post({EventKind::kLivelinessGained, info_.name, key, known.writer, Clock::now()});
  }
}

std::string ReaderBase::forget(const dds::SampleInfo& info) {
  const auto known = keys_.find(info.instance_handle);
  if (known == keys_.end()) return {};
  std::string key = std::move(known->second.text);
  keys_.erase(known);
  return key;
}

void ReaderBase::on_data_available(dds::DataReader* reader) {
  // Two receiving threads may announce data at one time. One drains for both, so that the order of arrival is kept; a
  // lock would do, too, but Fast DDS holds its own while it calls here.
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
  {
    const std::scoped_lock lock(mutex_);
    matched_ = status.current_count;
    // Who has left is told as lost, and his keys do not miss their deadlines, too.
    if (!found) {
      last_key = last_key_of(peer);
      silent_.erase(peer);
      std::erase_if(keys_, [&](const auto& entry) { return entry.second.writer == peer; });
    }
  }
  changed_.notify_all();
  mailbox_->post({found ? EventKind::kPeerMatched : EventKind::kPeerLost, info_.name, last_key, peer, Clock::now()});
}

Clock::time_point ReaderBase::look(Clock::time_point now, Clock::time_point since) {
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

// The status is not to be trusted further than this: what changes while another callback runs is counted in the totals
// and missing from the changes. That a writer lives again is therefore known from its samples.
void ReaderBase::on_liveliness_changed(dds::DataReader*, const LivelinessChanged& status) {
  Event event{EventKind::kLivelinessLost, info_.name, {}, endpoint_id(status.last_publication_handle), Clock::now()};
  {
    const std::scoped_lock lock(mutex_);
    const int before = std::exchange(not_alive_, status.not_alive_count);
    if (status.not_alive_count_change <= 0 && status.not_alive_count <= before) return;
    if (!silent_.insert(event.peer).second) return;
    ++counters_.liveliness_lost;
    event.key = last_key_of(event.peer);
  }
  mailbox_->post(std::move(event));
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
