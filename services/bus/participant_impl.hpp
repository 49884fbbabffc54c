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

#include "services/bus/fastdds.hpp"
#include "services/bus/gate_transport.hpp"
#include "services/bus/participant.hpp"
#include "services/bus/topics.hpp"

namespace hecaton::bus {

/// Something that may fall silent, and is looked at when that could have happened.
class Watched {
 public:
  /// Tells what has fallen silent, and returns when to look again. `since`: silence before this is not held against
  /// anybody, because this process did not listen itself.
  virtual Clock::time_point look(Clock::time_point now, Clock::time_point since) = 0;

 protected:
  ~Watched() = default;
};

struct Participant::Impl : PeerListener {
  Impl(int domain, const std::string& name, const ParticipantOptions& options);
  ~Impl() override;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// The topic of a row, made on first use.
  dds::Topic* topic(const TopicInfo& info, const dds::TypeSupport& type);
  void on_peer(const PeerNews& news) override;

  /// Does what removes something of this participant from Fast DDS; nothing any more once that has locked itself up
  /// (removal.hpp).
  void remove(std::function<void()> removal);

  /// From now on it is looked at; after unwatch() it is not being looked at either.
  void watch(Watched& watched);
  void unwatch(Watched& watched);
  /// The watched are to be looked at no later than `at`. May be called while a watched one's lock is held.
  void look_by(Clock::time_point at);

  [[nodiscard]] bool away() const;
  /// When what a reader takes now arrived, see Absence.
  [[nodiscard]] Clock::time_point arrival() const { return gate_->absence.arrival(Clock::now()); }

  dds::DomainParticipant* participant = nullptr;
  dds::Publisher* publisher = nullptr;
  dds::Subscriber* subscriber = nullptr;
  /// Held while a type, topic or endpoint is made or destroyed, of whatever participant: with two threads at it, Fast
  /// DDS 2.9.1 may lock its discovery and its list of endpoints in both orders, and its registry of types is one for
  /// all participants and not guarded.
  inline static std::mutex endpoints_mutex;

 private:
  void leave();
  void look_around();
  void look_for_stalls(Clock::time_point now);
  /// Ends the process when it can never hear anything again, so that its agent starts it anew.
  void end_if_locked_up(Clock::time_point now) const;
  [[nodiscard]] Clock::time_point look_for_silence(Clock::time_point now);
  void note_peer(const EndpointId& peer, bool found);
  void note_addresses(const PeerNews& news);

  Mailbox* mailbox_;
  std::shared_ptr<Gate> gate_;
  bool farewell_;
  std::atomic<bool> locked_up_ = false;
  Clock::duration back_after_{};  ///< an absence: others are found again, or gone
  int port_number_ = 0;           ///< that its ports follow from; unique among the participants that this process has
  std::mutex mutex_;
  std::map<std::string, dds::Topic*, std::less<>> topics_;

  std::mutex watched_mutex_;
  std::set<Watched*> watched_;
  Clock::time_point listening_since_{};  ///< of the watcher alone

  mutable std::mutex peers_mutex_;
  std::set<EndpointId> peers_;   ///< participants that are known
  std::set<EndpointId> missed_;  ///< known before the absence and not found again yet
  Clock::time_point settled_{};  ///< an absence ends, for services

  std::mutex alarm_mutex_;  ///< nothing else is locked while it is held
  std::condition_variable alarm_;
  Clock::time_point next_look_{};
  bool ending_ = false;
  std::thread watcher_;
};

[[nodiscard]] EndpointId endpoint_id(const rtps::GUID_t& guid);
[[nodiscard]] EndpointId endpoint_id(const rtps::InstanceHandle_t& handle);

}  // namespace hecaton::bus
