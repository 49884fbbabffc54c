#include "services/bus/writer_base.hpp"

#include <cstdio>
#include <stdexcept>
#include <utility>

#include "services/bus/incompatible.hpp"
#include "services/bus/quality.hpp"
#include "services/bus/source_time.hpp"

namespace hecaton::bus {
namespace {

/// The generated key buffer holds 255 characters of each key string.
constexpr std::size_t kLongestKey = 200;

/// A full history is reported as a time-out, too, and one whose depth is kept can only lack room for another key.
std::string explain(Outcome code, const TopicInfo& info) {
  if (code == Outcome::kOutOfResources || code == Outcome::kTimeout) {
    return "no room within 10 ms: the topic allows " + std::to_string(info.qos.instances) + " keys at one time";
  }
  if (code == Outcome::kPreconditionNotMet) return "the key was never written";
  return "Fast DDS returned code " + std::to_string(static_cast<std::uint32_t>(code));
}

}  // namespace

WriterBase::WriterBase(std::shared_ptr<Participant::Impl> participant, const TopicInfo& info,
                       const dds::TypeSupport& type, const WriterOptions& options)
    : participant_(std::move(participant)), info_(info), type_(type), keyed_(has_key(type)), mailbox_(options.mailbox) {
  Qos qos = info.qos;
  qos.deadline = options.deadline.value_or(qos.deadline);
  qos.lease = options.lease.value_or(qos.lease);
  const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
  auto* topic = participant_->topic(info, type_);
  writer_ = participant_->publisher->create_datawriter(topic, writer_qos(qos, keyed_, options.strength), this);
  if (writer_ == nullptr) throw std::runtime_error("bus: cannot create a writer of " + std::string(info.name));
}

WriterBase::~WriterBase() {
  const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
  writer_->set_listener(nullptr, dds::StatusMask::none());
  participant_->remove([from = participant_->publisher, writer = writer_] {
    // Fast DDS 2.9.1 takes the samples back one by one while its thread of timers still tells what there is of them, to
    // readers who have not acknowledged it; from a sample that was taken back that one counts for good.
    std::size_t taken_back = 0;
    writer->clear_history(&taken_back);
    from->delete_datawriter(writer);
  });
}

WriteResult WriterBase::send(Action action, void* data, const std::string& key) {
  if (keyed_ && key.empty()) return refuse(action, key, "the key is empty");
  if (key.size() > kLongestKey) return refuse(action, key, "the key is longer than 200 characters");
  if (action == Action::kRetire && !keyed_) return refuse(action, key, "the topic has no key");
  const auto code = [&] {
    // Of two threads' samples the one with the lower number must also be the older.
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

void WriterBase::forget() {
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

void WriterBase::set_strength(int strength) {
  auto qos = writer_->get_qos();
  qos.ownership_strength().value = static_cast<std::uint32_t>(strength);
  writer_->set_qos(qos);
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
  if (mailbox_ == nullptr) return;
  const auto kind = status.current_count_change > 0 ? EventKind::kPeerMatched : EventKind::kPeerLost;
  mailbox_->post({kind, info_.name, {}, endpoint_id(status.last_subscription_handle), Clock::now()});
}

void WriterBase::on_offered_incompatible_qos(dds::DataWriter*, const dds::OfferedIncompatibleQosStatus& status) {
  if (mailbox_ == nullptr) return;
  mailbox_->post({EventKind::kIncompatible, info_.name, policy_name(status.last_policy_id), {}, Clock::now()});
}

}  // namespace hecaton::bus
