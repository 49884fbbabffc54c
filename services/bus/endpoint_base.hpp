#pragma once
/// The parts of writers and readers that do not depend on the message type. Private to services/bus.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/endpoint.hpp"
#include "services/bus/key_table.hpp"
#include "services/bus/participant_impl.hpp"
#include "services/bus/stream_holder.hpp"

namespace hecaton::bus {

class WriterBase : public dds::DataWriterListener {
 public:
  WriterBase(std::shared_ptr<Participant::Impl> participant, const TopicInfo& info, const dds::TypeSupport& type,
             const WriterOptions& options);
  ~WriterBase() override;
  WriterBase(const WriterBase&) = delete;
  WriterBase& operator=(const WriterBase&) = delete;

  enum class Action : std::uint8_t { kWrite, kRetire };
  /// `data` points to a sample of the writer's type, whose key is `key`.
  WriteResult send(Action action, void* data, const std::string& key);

  void clear_history();

  [[nodiscard]] int matched() const { return matched_; }
  [[nodiscard]] bool wait_matched(int readers, Clock::duration timeout) const;
  [[nodiscard]] bool wait_acknowledged(Clock::duration timeout) const;
  [[nodiscard]] EndpointId id() const;

 private:
  void on_publication_matched(dds::DataWriter* writer, const dds::PublicationMatchedStatus& status) override;
  void on_offered_incompatible_qos(dds::DataWriter* writer, const dds::OfferedIncompatibleQosStatus& status) override;
  WriteResult refuse(Action action, const std::string& key, const std::string& why);

  std::shared_ptr<Participant::Impl> participant_;
  const TopicInfo& info_;
  dds::TypeSupport type_;
  bool keyed_;
  Mailbox* mailbox_;
  std::mutex order_;  ///< held while a sample gets its source time and its number
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::atomic<int> matched_ = 0;
  std::atomic<bool> refused_before_ = false;
  dds::Publisher* publisher_ = nullptr;  ///< of writer_
  dds::DataWriter* writer_ = nullptr;
};

class ReaderBase : public dds::DataReaderListener, private Monitored {
 public:
  ReaderBase(std::shared_ptr<Participant::Impl> participant, const TopicInfo& info, Mailbox* mailbox);
  ~ReaderBase() override;
  ReaderBase(const ReaderBase&) = delete;
  ReaderBase& operator=(const ReaderBase&) = delete;

  [[nodiscard]] int matched() const { return matched_; }
  [[nodiscard]] bool wait_matched(int writers, Clock::duration timeout) const;
  [[nodiscard]] ReaderCounters counters() const;
  [[nodiscard]] Mailbox& mailbox() { return *mailbox_; }

 protected:
  /// For the last line of the most derived constructor and the first of its destructor: callbacks run in between.
  void open(const dds::TypeSupport& type, const ReaderOptions& options);
  void close();

  /// Takes all samples out of the middleware. Never runs twice at a time.
  virtual void drain(dds::DataReader& reader) = 0;

  /// Arrival time of samples that are drained now, see LocalStallGuard.
  [[nodiscard]] Clock::time_point arrival() const { return participant_->arrival(); }
  /// Notes the key of a living sample, so that later events can name it.
  void note_alive(const dds::SampleInfo& info, const std::string& key);
  /// What of a sample decides whether a reader takes it.
  struct Arrival {
    std::uint64_t largest_term = 0;
    std::size_t bytes = 0;
  };
  /// True when a sample may reach the service. Otherwise the refusal is counted for its writer: too many samples of
  /// one writer, a leap of the term, a key that another participant holds, or too many keys. Call take_displaced()
  /// then.
  [[nodiscard]] bool admit(const dds::SampleInfo& info, const std::string& key, const Arrival& arrival,
                           std::uint32_t most_a_second);
  /// The participant that writes for `node` instead of the sample's writer, see NodeOwners; nothing: the writer may.
  [[nodiscard]] std::optional<EndpointId> other_owner(const dds::SampleInfo& info, const std::string& node,
                                                      Clock::time_point now);
  /// Counts a sample that has another owner. Its writer is reported if that owner goes on.
  void note_challenge(const dds::SampleInfo& info, const std::string& key, const EndpointId& owner,
                      Clock::time_point now);
  /// Keys that have lost their places to the admitted sample: for the service they are withdrawn.
  [[nodiscard]] std::vector<KeyTable::Key> take_displaced() { return std::exchange(displaced_, {}); }
  /// Reports a second writer of an admitted sample's key, see WriterChanges.
  void note_writer(const dds::SampleInfo& info, const std::string& key, std::uint64_t term);
  /// Counts a refused sample for its writer. `key`: of a stream with two writers.
  void refuse(const dds::SampleInfo& info, RefusalKind kind, const std::string& text, const std::string& key = {});
  /// Forgets the key of a withdrawn sample and returns it; empty when it is unknown, or when another participant wrote
  /// it last.
  [[nodiscard]] std::string forget(const dds::SampleInfo& info);

  mutable std::mutex mutex_;  ///< guards counters_ and the derived class's queue; never held while calling Fast DDS
  ReaderCounters counters_;

 private:
  void on_data_available(dds::DataReader* reader) override;
  void on_subscription_matched(dds::DataReader* reader, const dds::SubscriptionMatchedStatus& status) override;
  void on_requested_incompatible_qos(dds::DataReader* reader,
                                     const dds::RequestedIncompatibleQosStatus& status) override;

  /// Reports missed deadlines. Those of Fast DDS cost a timer for each sample. They also count the time in which this
  /// process was stopped, and keys of writers that have left.
  Clock::time_point check(Clock::time_point now, Clock::time_point since) override;

  /// A key that the writer wrote; empty when unknown.
  [[nodiscard]] std::string last_key_of(const EndpointId& writer) const;

  void forget_key(const std::string& text);

  /// What admit() knows. By the key's text: a sender chooses its handle. Keys are those of the table.
  struct Admission {
    explicit Admission(const KeyTable::Limits& limits) : table(limits) {}
    KeyTable table;
    std::map<std::string, StreamHolder, std::less<>> holders;
    std::map<std::string, WriterChanges, std::less<>> changes;
    std::map<EndpointId, SampleRate> rates;  ///< by matched writer
  };
  /// True when no other participant holds the key.
  [[nodiscard]] bool is_free(const dds::SampleInfo& info, const std::string& key, Clock::time_point now);
  void hold(const dds::SampleInfo& info, const std::string& key, Clock::time_point now);
  void report_second_writer(const EndpointId& second, const std::string& key, Clock::time_point now);

  struct Key {
    std::string text;
    EndpointId writer;
    Clock::time_point heard;
    bool missing = true;  ///< its missed deadline has been reported, or it is new
  };

  std::shared_ptr<Participant::Impl> participant_;
  const TopicInfo& info_;
  std::unique_ptr<Mailbox> own_mailbox_;
  Mailbox* mailbox_;
  dds::TypeSupport type_;
  dds::Subscriber* subscriber_ = nullptr;  ///< of reader_
  dds::DataReader* reader_ = nullptr;
  Clock::duration deadline_{};  ///< zero: none
  std::atomic<int> matched_ = 0;
  std::atomic<int> announcements_ = 0;  ///< of data, not drained yet
  mutable std::condition_variable changed_;
  std::map<rtps::InstanceHandle_t, Key> keys_;                          ///< the living ones
  std::map<std::string, rtps::InstanceHandle_t, std::less<>> handles_;  ///< of keys_: one for each text
  Admission admission_;
  std::vector<KeyTable::Key> displaced_;
};

}  // namespace hecaton::bus
