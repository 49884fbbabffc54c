#pragma once
/// The Fast DDS side of Participant. Private to services/bus.

#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "services/bus/authentication_watch.hpp"
#include "services/bus/fastdds.hpp"
#include "services/bus/filtering_transport.hpp"
#include "services/bus/node_owners.hpp"
#include "services/bus/participant.hpp"
#include "services/bus/term_limit.hpp"
#include "services/bus/topics.hpp"

namespace hecaton::bus {

/// Something whose deadlines the participant's monitor thread checks.
class Monitored {
 public:
  /// Reports missed deadlines and returns when to check again. Silence before `since` does not count, because this
  /// process did not receive then.
  virtual Clock::time_point check(Clock::time_point now, Clock::time_point since) = 0;

 protected:
  ~Monitored() = default;
};

struct Participant::Impl : PeerListener {
  Impl(int domain, const std::string& name, const ParticipantOptions& options);
  ~Impl() override;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// The topic of a row, created on first use. Throws std::runtime_error.
  dds::Topic* topic(const TopicInfo& info, const dds::TypeSupport& type);
  /// The publisher in the partition of one key, the subscriber in those of some; empty: of all keys. Hold
  /// endpoints_mutex.
  [[nodiscard]] dds::Publisher* publisher_of(const std::string& key);
  [[nodiscard]] dds::Subscriber* subscriber_of(const std::vector<std::string>& keys);
  /// The support of a type whose samples are exchanged as bytes, with the size of the largest. Fast DDS allows one
  /// support of each name: the first call decides on the size.
  dds::TypeSupport raw_type(const std::string& name, std::uint32_t largest);
  void on_peer(const PeerEvent& event) override;
  void on_endpoint(const rtps::GUID_t& endpoint) override;
  void on_authentication(const rtps::GUID_t& peer, bool authorized) override;

  /// Runs `removal`, which removes an entity of this participant from Fast DDS. After Fast DDS has deadlocked in a
  /// removal (deadlock_guard.hpp) it does nothing.
  void remove(std::function<void()> removal);
  /// The same of an endpoint. Meanwhile the participant receives nothing: a thread of Fast DDS 2.9.1 that pairs an
  /// endpoint with a remote one reads its listener twice, and crashes when the removal clears it in between.
  void remove_endpoint(std::function<void()> removal);

  /// The monitor thread calls check() from now on; after unmonitor() it does not, nor is a call under way.
  void monitor(Monitored& monitored);
  void unmonitor(Monitored& monitored);
  /// Makes the monitor thread check no later than `at`. May be called while a lock of the monitored object is held.
  void check_by(Clock::time_point at);

  [[nodiscard]] bool recovering() const;
  [[nodiscard]] std::vector<std::string> joining() const { return handshakes_.joining(Clock::now()); }
  /// An endpoint of this participant was matched with `peer`, an endpoint of another one.
  void note_match(const EndpointId& peer);
  /// Arrival time of a sample that a reader takes now, see LocalStallGuard.
  [[nodiscard]] Clock::time_point arrival() const { return filter_->stall_guard.arrival(Clock::now()); }

  [[nodiscard]] TermLimit& terms() { return terms_; }
  [[nodiscard]] RefusalLog& refusals() { return filter_->refusals; }
  [[nodiscard]] NodeOwners& owners() { return owners_; }
  /// Adds the second writers of planners' and supervisors' messages to refusals().
  void report_challengers();
  [[nodiscard]] bool secured() const { return secured_; }  ///< it has keys

  const std::optional<std::chrono::system_clock::time_point> identity_expires;

  dds::DomainParticipant* participant = nullptr;
  dds::Publisher* publisher = nullptr;
  dds::Subscriber* subscriber = nullptr;
  /// Hold it while a type, topic or endpoint of any participant is created or destroyed. With two threads at once, Fast
  /// DDS 2.9.1 may lock its discovery and its list of endpoints in both orders. Its registry of types is shared by all
  /// participants and not guarded.
  inline static std::mutex endpoints_mutex;

 private:
  void leave();
  void run_monitor();
  void check_stall(Clock::time_point now);
  void check_revocations(Clock::time_point now);
  /// Aborts the process, which the agent then restarts, when a receiving thread will never return.
  void abort_if_deadlocked(Clock::time_point now) const;
  [[nodiscard]] Clock::time_point check_monitored(Clock::time_point now);
  void note_peer(const EndpointId& peer, bool found);
  void note_addresses(const PeerEvent& event);
  void note_handshake(const PeerEvent& event);

  [[nodiscard]] std::string partition_of(const std::string& key) const;

  Mailbox* mailbox_;
  const std::string partition_;
  std::map<std::string, dds::Publisher*> publishers_;                 ///< by partition
  std::map<std::vector<std::string>, dds::Subscriber*> subscribers_;  ///< by partitions
  std::shared_ptr<DatagramFilter> filter_;
  bool announce_departure_;
  const bool secured_;
  AuthenticationWatch handshakes_;
  NodeOwners owners_;
  TermLimit terms_{Clock::now()};
  std::atomic<bool> deadlocked_ = false;
  const std::function<std::vector<GuidBeginning>()> revoked_;
  Clock::time_point next_revocations_{};  ///< of the monitor thread alone
  Clock::duration rediscovery_{};         ///< after a stall, peers are found again within this or gone
  int port_number_ = 0;                   ///< decides the ports; unique among the open participants of this process
  std::mutex mutex_;
  std::map<std::string, dds::Topic*, std::less<>> topics_;
  std::map<std::string, dds::TypeSupport> raw_types_;

  std::mutex monitored_mutex_;
  std::set<Monitored*> monitored_;
  Clock::time_point receiving_since_{};  ///< of the monitor thread alone

  mutable std::mutex peers_mutex_;
  std::set<EndpointId> peers_;     ///< known participants
  std::set<EndpointId> missing_;   ///< known before the stall and not found again yet
  Clock::time_point recovered_{};  ///< when recovering() ends

  std::mutex alarm_mutex_;  ///< no other lock is taken while it is held
  std::condition_variable alarm_;
  Clock::time_point next_check_{};
  bool ending_ = false;
  std::thread monitor_thread_;
};

[[nodiscard]] EndpointId endpoint_id(const rtps::GUID_t& guid);
[[nodiscard]] EndpointId endpoint_id(const rtps::InstanceHandle_t& handle);

}  // namespace hecaton::bus
