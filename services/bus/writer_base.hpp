#pragma once
/// What all writers share, whatever their type. Private to services/bus.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "services/bus/endpoint.hpp"
#include "services/bus/participant_impl.hpp"

namespace hecaton::bus {

class WriterBase : public dds::DataWriterListener {
 public:
  WriterBase(std::shared_ptr<Participant::Impl> participant, const TopicInfo& info, const dds::TypeSupport& type,
             const WriterOptions& options);
  ~WriterBase() override;
  WriterBase(const WriterBase&) = delete;
  WriterBase& operator=(const WriterBase&) = delete;

  enum class Action : std::uint8_t { kWrite, kRetire };
  /// `data` points to a sample of the writer's type whose key is `key`.
  WriteResult send(Action action, void* data, const std::string& key);

  void forget();

  [[nodiscard]] int matched() const { return matched_; }
  [[nodiscard]] bool wait_matched(int readers, Clock::duration timeout) const;
  [[nodiscard]] bool wait_acknowledged(Clock::duration timeout) const;
  void set_strength(int strength);
  [[nodiscard]] EndpointId id() const;
  [[nodiscard]] bool keyed() const { return keyed_; }
  [[nodiscard]] const TopicInfo& info() const { return info_; }

 private:
  void on_publication_matched(dds::DataWriter* writer, const dds::PublicationMatchedStatus& status) override;
  void on_offered_incompatible_qos(dds::DataWriter* writer, const dds::OfferedIncompatibleQosStatus& status) override;
  WriteResult refuse(Action action, const std::string& key, const std::string& why);

  std::shared_ptr<Participant::Impl> participant_;
  const TopicInfo& info_;
  dds::TypeSupport type_;
  bool keyed_;
  Mailbox* mailbox_;
  std::mutex order_;  ///< held while a sample gets its time and its number
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::atomic<int> matched_ = 0;
  std::atomic<bool> refused_before_ = false;
  dds::DataWriter* writer_ = nullptr;
};

}  // namespace hecaton::bus
