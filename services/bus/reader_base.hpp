#pragma once
/// What all readers share, whatever their type: matching, deadlines and liveliness. Private to services/bus.

#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "services/bus/endpoint.hpp"
#include "services/bus/participant_impl.hpp"

namespace hecaton::bus {

class ReaderBase : public dds::DataReaderListener, private Watched {
 public:
  ReaderBase(std::shared_ptr<Participant::Impl> participant, const TopicInfo& info, Mailbox* mailbox);
  ~ReaderBase() override;
  ReaderBase(const ReaderBase&) = delete;
  ReaderBase& operator=(const ReaderBase&) = delete;

  [[nodiscard]] int matched() const { return matched_; }
  [[nodiscard]] int alive_writers() const;
  [[nodiscard]] bool wait_matched(int writers, Clock::duration timeout) const;
  [[nodiscard]] ReaderCounters counters() const;
  [[nodiscard]] Mailbox& mailbox() { return *mailbox_; }

 protected:
  /// For the last line of the most derived constructor and the first of its destructor: callbacks run in between.
  void open(const dds::TypeSupport& type, const ReaderOptions& options);
  void close();

  /// Takes all samples out of the middleware. Never runs twice at one time.
  virtual void drain(dds::DataReader& reader) = 0;

  /// When what is drained now arrived; not later than this process is known to have run before a stall.
  [[nodiscard]] Clock::time_point arrival() const { return participant_->arrival(); }
  /// Remembers the key of a living sample, so that later events can name it.
  void note_alive(const dds::SampleInfo& info, const std::string& key);
  /// Forgets the key of a withdrawn one; empty when it was never known.
  [[nodiscard]] std::string forget(const dds::SampleInfo& info);

  mutable std::mutex mutex_;  ///< guards counters_ and the derived class's queue; never held while calling Fast DDS
  ReaderCounters counters_;

 private:
  void on_data_available(dds::DataReader* reader) override;
  void on_subscription_matched(dds::DataReader* reader, const dds::SubscriptionMatchedStatus& status) override;
  void on_liveliness_changed(dds::DataReader* reader, const LivelinessChanged& status) override;
  void on_requested_incompatible_qos(dds::DataReader* reader,
                                     const dds::RequestedIncompatibleQosStatus& status) override;

  /// Missed deadlines. Fast DDS tells them, too, but accuses writers of the silence while this process itself was
  /// stopped, and goes on with keys whose writer has left.
  Clock::time_point look(Clock::time_point now, Clock::time_point since) override;

  /// Of the key that it wrote, "" when unknown.
  [[nodiscard]] std::string last_key_of(const EndpointId& writer) const;

  struct Key {
    std::string text;
    EndpointId writer;
    Clock::time_point heard;
    bool missing = true;  ///< its deadline has passed and this was told, or it is new
  };

  std::shared_ptr<Participant::Impl> participant_;
  const TopicInfo& info_;
  std::unique_ptr<Mailbox> own_mailbox_;
  Mailbox* mailbox_;
  dds::TypeSupport type_;
  dds::DataReader* reader_ = nullptr;
  Clock::duration deadline_{};  ///< zero: none
  std::atomic<int> matched_ = 0;
  std::atomic<int> announcements_ = 0;
  mutable std::condition_variable changed_;
  std::map<rtps::InstanceHandle_t, Key> keys_;  ///< of living keys
  std::set<EndpointId> silent_;                 ///< matched writers whose lease has run out
  int not_alive_ = 0;                           ///< as Fast DDS counted last
};

}  // namespace hecaton::bus
