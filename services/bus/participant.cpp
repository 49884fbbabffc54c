#include "services/bus/participant.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <set>
#include <stdexcept>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/bus/discovery_server.hpp"
#include "services/bus/participant_impl.hpp"
#include "services/bus/quality.hpp"
#include "services/bus/removal.hpp"
#include "services/bus/transport.hpp"

namespace hecaton::bus {
namespace {

/// On which all participants of a domain hear announcements (RTPS 2.2, section 9.6.1.1).
int announcement_port(int domain) {
  return 7400 + 250 * domain;
}

/// Whether a program that shares it with nobody has that port: Fast DDS would go on without, and hear nobody.
bool announcements_are_blocked(int domain) {
  const int probe = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return false;
  const int shared = 1;
  static_cast<void>(::setsockopt(probe, SOL_SOCKET, SO_REUSEADDR, &shared, sizeof(shared)));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(announcement_port(domain)));
  const bool blocked =
      ::bind(probe, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 && errno == EADDRINUSE;
  ::close(probe);
  return blocked;
}

/// What tells the participants of this process apart.
///
/// Fast DDS derives ports and GUID from one identifier. Ports must stay within those that peers try, so the port number
/// is the smallest free one. A GUID must never return: after a participant has left without a farewell, its peers keep
/// the sequence numbers of its writers, and take the samples of a successor with the same GUID for old ones.
class Identities {
 public:
  struct Identity {
    int port_number;
    int identifier;
  };

  Identity take() {
    const std::scoped_lock lock(mutex_);
    int number = 0;
    while (!taken_.insert(number).second) ++number;
    return {number, used_.insert(number).second ? number : next_++};
  }
  void give_back(int port_number) {
    const std::scoped_lock lock(mutex_);
    taken_.erase(port_number);
  }

 private:
  std::mutex mutex_;
  std::set<int> taken_;           ///< port numbers
  std::set<int> used_;            ///< identifiers that are also a port number
  int next_ = kMostParticipants;  ///< identifier
};

Identities& identities() {
  static Identities all;
  return all;
}

/// Gives the participant the ports of its port number whatever its identifier is. False: the identifier is too large.
bool set_identity(dds::DomainParticipantQos& qos, int domain, const Identities::Identity& identity) {
  auto& ports = qos.wire_protocol().port;
  qos.wire_protocol().participant_id = identity.identifier;
  const int shift = ports.participantIDGain * (identity.identifier - identity.port_number);
  const int base = ports.portBase + ports.domainIDGain * domain;
  if (shift > base) return false;
  ports.domainIDGain = 0;
  ports.portBase = static_cast<std::uint16_t>(base - shift);
  ports.offsetd0 = static_cast<std::uint16_t>(ports.offsetd0 + shift);
  ports.offsetd2 = static_cast<std::uint16_t>(ports.offsetd2 + shift);
  return true;
}

/// Once a participant is found its endpoints are within this.
constexpr std::chrono::milliseconds kMatching{50};

dds::DomainParticipantQos participant_qos(const std::string& name, const ParticipantOptions& options) {
  dds::DomainParticipantQos qos;
  qos.name(name);
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.leaseDuration = duration(options.lease);
  discovery.leaseDuration_announcementperiod = duration(announcement_period(options.lease));
  discovery.initial_announcements.count = 8;
  discovery.initial_announcements.period = duration(std::chrono::milliseconds(5));
  return qos;
}

}  // namespace

EndpointId endpoint_id(const rtps::GUID_t& guid) {
  EndpointId id;
  std::copy_n(guid.guidPrefix.value, 12, id.bytes.begin());
  std::copy_n(guid.entityId.value, 4, id.bytes.begin() + 12);
  return id;
}

EndpointId endpoint_id(const rtps::InstanceHandle_t& handle) {
  rtps::GUID_t guid;
  rtps::iHandle2GUID(guid, handle);
  return endpoint_id(guid);
}

Participant::Impl::Impl(int domain, const std::string& name, const ParticipantOptions& options)
    : mailbox_(options.mailbox), farewell_(options.farewell) {
  constexpr int kLastDomain = 232;  // the ports of the next one are above 65535
  const std::string who = "bus: participant \"" + name + "\": ";
  if (domain < 0 || domain > kLastDomain) {
    throw std::runtime_error(who + "domain = " + std::to_string(domain) + " must be between 0 and 232");
  }
  if (options.lease < std::chrono::milliseconds(20)) throw std::runtime_error(who + "lease must be at least 20 ms");
  if (announcements_are_blocked(domain)) {
    throw std::runtime_error(
        who + "UDP port " + std::to_string(announcement_port(domain)) + " of domain " + std::to_string(domain) +
        " is taken by another program; choose another domain, below 101 at best: the ports of later "
        "ones are given to anybody");
  }
  ignore_discovery_servers();  // before Fast DDS first looks for them
  use_network_inside_process();
  auto qos = participant_qos(name, options);
  gate_ = add_transports(qos, domain, options);
  // After an absence others are found with their next announcements; who is not found so long is gone.
  back_after_ = quarantine(options.lease) + options.lease / 2;
  const auto identity = identities().take();
  port_number_ = identity.port_number;
  if (!set_identity(qos, domain, identity)) {
    identities().give_back(port_number_);
    throw std::runtime_error(
        who + "this process has joined domain " + std::to_string(domain) + " " + std::to_string(identity.identifier) +
        " times, and its identifiers are used up; keep one participant, or start the process again");
  }
  auto* factory = dds::DomainParticipantFactory::get_instance();
  // StatusMask::none(): this listener hears of participants only and leaves readers their own callbacks.
  participant = factory->create_participant(static_cast<dds::DomainId_t>(domain), qos, this, dds::StatusMask::none());
  if (participant == nullptr) {
    identities().give_back(port_number_);
    throw std::runtime_error(who + "cannot join domain " + std::to_string(domain));
  }
  gate_->open();
  dds::PublisherQos publisher_qos;
  dds::SubscriberQos subscriber_qos;
  if (!options.partition.empty()) {
    publisher_qos.partition().push_back(options.partition.c_str());
    subscriber_qos.partition().push_back(options.partition.c_str());
  }
  publisher = participant->create_publisher(publisher_qos, nullptr, dds::StatusMask::none());
  subscriber = participant->create_subscriber(subscriber_qos, nullptr, dds::StatusMask::none());
  if (publisher == nullptr || subscriber == nullptr) {
    leave();
    throw std::runtime_error(who + "cannot create its publisher and subscriber");
  }
  listening_since_ = next_look_ = Clock::now();
  watcher_ = std::thread([this] { look_around(); });
}

Participant::Impl::~Impl() {
  leave();
}

void Participant::Impl::leave() {
  {
    const std::scoped_lock lock(alarm_mutex_);
    ending_ = true;
  }
  alarm_.notify_all();
  if (watcher_.joinable()) watcher_.join();
  if (!farewell_) gate_->close();
  participant->set_listener(nullptr, dds::StatusMask::none());
  remove([self = participant] {
    self->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(self);
  });
  if (!locked_up_) identities().give_back(port_number_);
}

void Participant::Impl::remove(std::function<void()> removal) {
  if (locked_up_ || done_within(kRemoval, std::move(removal))) return;
  locked_up_ = true;
  std::fprintf(stderr, "bus: Fast DDS has locked itself up while something of it was removed, which is left behind\n");
}

dds::Topic* Participant::Impl::topic(const TopicInfo& info, const dds::TypeSupport& type) {
  const std::scoped_lock lock(mutex_);
  const auto known = topics_.find(info.name);
  if (known != topics_.end()) return known->second;
  const std::string name(info.name);
  dds::Topic* topic = nullptr;
  if (outcome(type.register_type(participant)) == Outcome::kOk) {
    topic = participant->create_topic(name, type.get_type_name(), dds::TopicQos(), nullptr, dds::StatusMask::none());
  }
  if (topic == nullptr) throw std::runtime_error("bus: cannot create topic " + name);
  topics_.emplace(name, topic);
  return topic;
}

void Participant::Impl::look_around() {
  std::unique_lock lock(alarm_mutex_);
  while (!ending_) {
    const auto now = Clock::now();
    // Woken late, this process did not listen either: what its sockets hold may have come in time.
    if (now - next_look_ > Absence::kBacklog) listening_since_ = now;
    next_look_ = now + Absence::kLook;
    lock.unlock();
    look_for_stalls(now);
    gate_->hearing.look(now, listening_since_);
    end_if_locked_up(now);
    const auto next = look_for_silence(now);
    lock.lock();
    next_look_ = std::min(next_look_, next);
    while (!ending_ && Clock::now() < next_look_) alarm_.wait_until(lock, next_look_);
  }
}

void Participant::Impl::look_for_stalls(Clock::time_point now) {
  const std::scoped_lock lock(peers_mutex_);
  if (!gate_->absence.look(now)) return;
  missed_.insert(peers_.begin(), peers_.end());
  settled_ = now + back_after_;
}

void Participant::Impl::end_if_locked_up(Clock::time_point now) const {
  if (gate_->receivers.longest(now, listening_since_) < Receivers::kHung) return;
  std::fprintf(stderr, "bus: a receiving thread has not come back; Fast DDS has locked itself up, the process ends\n");
  std::abort();
}

Clock::time_point Participant::Impl::look_for_silence(Clock::time_point now) {
  const std::scoped_lock lock(watched_mutex_);
  auto next = Clock::time_point::max();
  for (auto* watched : watched_) next = std::min(next, watched->look(now, listening_since_));
  return next;
}

void Participant::Impl::watch(Watched& watched) {
  const std::scoped_lock lock(watched_mutex_);
  watched_.insert(&watched);
}

void Participant::Impl::unwatch(Watched& watched) {
  const std::scoped_lock lock(watched_mutex_);
  watched_.erase(&watched);
}

void Participant::Impl::look_by(Clock::time_point at) {
  {
    const std::scoped_lock lock(alarm_mutex_);
    if (next_look_ <= at) return;
    next_look_ = at;
  }
  alarm_.notify_one();
}

bool Participant::Impl::away() const {
  const auto now = Clock::now();
  const std::scoped_lock lock(peers_mutex_);
  return gate_->absence.overslept(now) || now < settled_;
}

void Participant::Impl::note_peer(const EndpointId& peer, bool found) {
  const auto now = Clock::now();
  const std::scoped_lock lock(peers_mutex_);
  if (!found) {
    peers_.erase(peer);
    if (gate_->absence.away(now)) missed_.insert(peer);  // also before the watcher has seen the stall
    return;
  }
  peers_.insert(peer);
  missed_.erase(peer);
  if (missed_.empty()) settled_ = std::min(settled_, now + kMatching);
}

void Participant::Impl::note_addresses(const PeerNews& news) {
  Hearing::Prefix prefix{};
  std::copy_n(news.guid.guidPrefix.value, prefix.size(), prefix.begin());
  if (news.kind == PeerNews::Kind::kDropped) return gate_->hearing.dropped(prefix, Clock::now());
  if (news.kind == PeerNews::Kind::kLeft) return gate_->hearing.left(prefix, Clock::now());
  std::vector<Hearing::Address> addresses;
  for (const auto& locator : news.unicast) addresses.push_back(address_of(locator));
  gate_->hearing.found(prefix, std::move(addresses), Clock::now());
}

void Participant::Impl::on_peer(const PeerNews& news) {
  if (news.kind == PeerNews::Kind::kChanged) return;
  const bool found = news.kind == PeerNews::Kind::kFound;
  const EndpointId peer = endpoint_id(news.guid);
  note_addresses(news);
  note_peer(peer, found);
  if (mailbox_ == nullptr) return;
  mailbox_->post(
      {found ? EventKind::kParticipantFound : EventKind::kParticipantLost, {}, news.name, peer, Clock::now()});
}

Participant::Participant(int domain, const std::string& name, const ParticipantOptions& options)
    : impl_(std::make_shared<Impl>(domain, name, options)) {}
Participant::~Participant() = default;
Participant::Participant(Participant&&) noexcept = default;
Participant& Participant::operator=(Participant&&) noexcept = default;

bool Participant::away() const {
  return impl_->away();
}

}  // namespace hecaton::bus

#ifdef __SANITIZE_ADDRESS__
// Debian's Fast DDS frees its statistics objects with another size than it made them with. Defaults, so that services
// and tests run under the sanitizer as they are; ASAN_OPTIONS still overrides them.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "new_delete_type_mismatch=0";
}
#endif

#ifdef __SANITIZE_THREAD__
// Seen inside Fast DDS and nowhere else: its timed locks (pthread_mutex_clocklock, which this sanitizer does not know),
// and an order of its locks that Impl::endpoints_mutex keeps from becoming a deadlock. Data races are not suppressed.
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "mutex:libfastrtps\ndeadlock:libfastrtps\nmutex:libfastdds\ndeadlock:libfastdds\n";
}
#endif
