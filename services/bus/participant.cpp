#include "services/bus/participant.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "services/bus/participant_impl.hpp"
#include "services/bus/permission_log.hpp"
#include "services/bus/qos.hpp"

namespace hecaton::bus {
namespace {

/// The port on which all participants of a domain receive announcements (RTPS 2.2, section 9.6.1.1).
int announcement_port(int domain) {
  return 7400 + 250 * domain;
}

/// True when a program holds that port without sharing it. Fast DDS would go on without the port and discover no peer.
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
/// is the smallest free one. A GUID must never return. When a participant leaves unannounced, its peers keep the
/// sequence numbers of its writers. They would take the samples of a successor with the same GUID for old ones.
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

/// Looking for newly revoked participants reads the state of a file.
constexpr std::chrono::seconds kRevocationPeriod{1};

/// The endpoints of a participant are found within this time after the participant itself.
constexpr std::chrono::milliseconds kMatching{50};

/// The plugins of DDS Security that Fast DDS has, with the files of a keystore's enclave.
void set_identity_of_security(dds::DomainParticipantQos& qos, const ParticipantOptions& options) {
  const std::filesystem::path& folder = options.identity;
  const auto set = [&](const std::string& key, const std::string& value) {
    qos.properties().properties().emplace_back("dds.sec." + key, value);
  };
  const auto file = [&](const char* name) { return "file://" + (folder / name).string(); };
  set("auth.plugin", "builtin.PKI-DH");
  set("auth.builtin.PKI-DH.identity_ca", file("identity_ca.cert.pem"));
  set("auth.builtin.PKI-DH.identity_certificate", file("cert.pem"));
  set("auth.builtin.PKI-DH.private_key", file("key.pem"));
  if (!options.revocations.empty()) set("auth.builtin.PKI-DH.identity_crl", "file://" + options.revocations.string());
  set("access.plugin", "builtin.Access-Permissions");
  set("access.builtin.Access-Permissions.permissions_ca", file("permissions_ca.cert.pem"));
  set("access.builtin.Access-Permissions.governance", file("governance.p7s"));
  set("access.builtin.Access-Permissions.permissions", file("permissions.p7s"));
  set("crypto.plugin", "builtin.AES-GCM-GMAC");
}

dds::DomainParticipantQos participant_qos(const std::string& name, const ParticipantOptions& options) {
  dds::DomainParticipantQos qos;
  qos.name(name);
  qos.user_data().assign(options.user_data.begin(), options.user_data.end());
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  discovery.leaseDuration = duration(options.lease);
  discovery.leaseDuration_announcementperiod = duration(announcement_period(options.lease));
  if (!options.identity.empty()) set_identity_of_security(qos, options);
  discovery.initial_announcements.count = 8;
  discovery.initial_announcements.period = duration(std::chrono::milliseconds(5));
  return qos;
}

}  // namespace

namespace {

PeerQuarantine::Prefix prefix_of(const rtps::GUID_t& guid) {
  PeerQuarantine::Prefix prefix{};
  std::copy_n(guid.guidPrefix.value, prefix.size(), prefix.begin());
  return prefix;
}

PeerQuarantine::Prefix prefix_of(const EndpointId& id) {
  PeerQuarantine::Prefix prefix{};
  std::copy_n(id.bytes.begin(), prefix.size(), prefix.begin());
  return prefix;
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
    : identity_expires(options.identity_expires),
      mailbox_(options.mailbox),
      partition_(options.partition),
      announce_departure_(options.announce_departure && options.identity.empty()),
      secured_(!options.identity.empty()),
      owners_(options.nodes,
              [this](const EndpointId& peer) { return filter_->quarantine.last_heard(prefix_of(peer)); }),
      revoked_(options.revoked) {
  constexpr int kLastDomain = 232;  // the ports of the next one are above 65535
  const std::string prefix = "bus: participant \"" + name + "\": ";
  if (domain < 0 || domain > kLastDomain) {
    throw std::runtime_error(prefix + "domain = " + std::to_string(domain) + " must be between 0 and 232");
  }
  if (options.lease < std::chrono::milliseconds(20)) throw std::runtime_error(prefix + "lease must be at least 20 ms");
  if (announcements_are_blocked(domain)) {
    throw std::runtime_error(
        prefix + "UDP port " + std::to_string(announcement_port(domain)) + " of domain " + std::to_string(domain) +
        " is taken by another program; choose another domain, preferably below 101: the system gives the ports "
        "of higher domains to any program");
  }
  ignore_discovery_servers();  // before Fast DDS reads the environment
  use_network_inside_process();
  auto qos = participant_qos(name, options);
  filter_ = add_transports(qos, domain, options);
  if (secured_) note_refused_permissions(std::shared_ptr<RefusalLog>(filter_, &filter_->refusals));
  // After a stall, peers are found with their next announcements. A peer that is not found by then is gone.
  rediscovery_ = quarantine(options.lease) + options.lease / 2;
  const auto identity = identities().take();
  port_number_ = identity.port_number;
  if (!set_identity(qos, domain, identity)) {
    identities().give_back(port_number_);
    throw std::runtime_error(
        prefix + "this process has joined domain " + std::to_string(domain) + " " +
        std::to_string(identity.identifier) +
        " times, and its identifiers are used up; keep one participant, or start the process again");
  }
  auto* factory = dds::DomainParticipantFactory::get_instance();
  // StatusMask::none(): this listener receives discovery only and leaves the readers their own callbacks.
  participant = factory->create_participant(static_cast<dds::DomainId_t>(domain), qos, this, dds::StatusMask::none());
  if (participant == nullptr) {
    identities().give_back(port_number_);
    throw std::runtime_error(prefix + "cannot join domain " + std::to_string(domain) +
                             (options.identity.empty() ? ""
                                                       : " with the keys in " + options.identity.string() +
                                                             "; its governance.p7s and permissions.p7s must allow it"));
  }
  owners_.own(endpoint_id(participant->guid()), name);
  filter_->open();
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
    throw std::runtime_error(prefix + "cannot create its publisher and subscriber");
  }
  receiving_since_ = next_check_ = Clock::now();
  monitor_thread_ = std::thread([this] { run_monitor(); });
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
  if (monitor_thread_.joinable()) monitor_thread_.join();
  if (!announce_departure_) filter_->close();
  participant->set_listener(nullptr, dds::StatusMask::none());
  remove([self = participant] {
    self->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(self);
  });
  if (!deadlocked_) identities().give_back(port_number_);
}

void Participant::Impl::remove(std::function<void()> removal) {
  if (deadlocked_ || finishes_within(kRemovalLimit, std::move(removal))) return;
  deadlocked_ = true;
  std::fprintf(
      stderr,
      "bus: Fast DDS has deadlocked during the removal of an endpoint or participant, which is left in place\n");
}

void Participant::Impl::remove_endpoint(std::function<void()> removal) {
  constexpr std::chrono::milliseconds kLongestWait{200};  // rather than a deadlock, a small risk
  const ReceptionGate::Closure closure(filter_->gate, kLongestWait);
  remove(std::move(removal));
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

std::string Participant::Impl::partition_of(const std::string& key) const {
  return partition_ + "/" + (key.empty() ? "*" : key);
}

dds::Publisher* Participant::Impl::publisher_of(const std::string& key) {
  dds::Publisher*& known = publishers_[partition_of(key)];
  if (known) return known;
  dds::PublisherQos qos;
  qos.partition().push_back(partition_of(key).c_str());
  known = participant->create_publisher(qos, nullptr, dds::StatusMask::none());
  if (!known) throw std::runtime_error("bus: cannot create a publisher in partition " + partition_of(key));
  return known;
}

dds::Subscriber* Participant::Impl::subscriber_of(const std::vector<std::string>& keys) {
  std::vector<std::string> partitions;
  for (const std::string& key : keys) partitions.push_back(partition_of(key));
  if (partitions.empty()) partitions.push_back(partition_of({}));
  dds::Subscriber*& known = subscribers_[partitions];
  if (known) return known;
  dds::SubscriberQos qos;
  for (const std::string& partition : partitions) qos.partition().push_back(partition.c_str());
  known = participant->create_subscriber(qos, nullptr, dds::StatusMask::none());
  if (!known) throw std::runtime_error("bus: cannot create a subscriber in partition " + partitions.front());
  return known;
}

dds::TypeSupport Participant::Impl::raw_type(const std::string& name, std::uint32_t largest) {
  const std::scoped_lock lock(mutex_);
  const auto known = raw_types_.find(name);
  if (known != raw_types_.end()) return known->second;
  return raw_types_.emplace(name, dds::TypeSupport(new RawSupport(name, largest))).first->second;
}

void Participant::Impl::run_monitor() {
  std::unique_lock lock(alarm_mutex_);
  while (!ending_) {
    const auto now = Clock::now();
    // Woken late, this process did not receive either: data in its sockets may have come in time.
    if (now - next_check_ > LocalStallGuard::kBacklog) receiving_since_ = now;
    next_check_ = now + LocalStallGuard::kPeriod;
    lock.unlock();
    check_stall(now);
    check_revocations(now);
    filter_->quarantine.update(now, receiving_since_);
    if (secured_) {
      for (const auto& peer : handshakes_.take_overdue(now)) filter_->quarantine.dropped(peer, now);
    }
    abort_if_deadlocked(now);
    const auto next = check_monitored(now);
    lock.lock();
    next_check_ = std::min(next_check_, next);
    while (!ending_ && Clock::now() < next_check_) alarm_.wait_until(lock, next_check_);
  }
}

void Participant::Impl::check_stall(Clock::time_point now) {
  const std::scoped_lock lock(peers_mutex_);
  if (!filter_->stall_guard.update(now)) return;
  missing_.insert(peers_.begin(), peers_.end());
  recovered_ = now + rediscovery_;
}

void Participant::Impl::check_revocations(Clock::time_point now) {
  if (!revoked_ || now < next_revocations_) return;
  next_revocations_ = now + kRevocationPeriod;
  filter_->quarantine.revoke(revoked_(), now);
}

void Participant::Impl::abort_if_deadlocked(Clock::time_point now) const {
  if (filter_->receivers.longest(now, receiving_since_) < ReceiverWatchdog::kLimit) return;
  std::fprintf(stderr,
               "bus: Fast DDS has deadlocked: a receiving thread has not returned for 20 s; the process aborts\n");
  std::abort();
}

Clock::time_point Participant::Impl::check_monitored(Clock::time_point now) {
  const std::scoped_lock lock(monitored_mutex_);
  auto next = Clock::time_point::max();
  for (auto* monitored : monitored_) next = std::min(next, monitored->check(now, receiving_since_));
  return next;
}

void Participant::Impl::monitor(Monitored& monitored) {
  const std::scoped_lock lock(monitored_mutex_);
  monitored_.insert(&monitored);
}

void Participant::Impl::unmonitor(Monitored& monitored) {
  const std::scoped_lock lock(monitored_mutex_);
  monitored_.erase(&monitored);
}

void Participant::Impl::check_by(Clock::time_point at) {
  {
    const std::scoped_lock lock(alarm_mutex_);
    if (next_check_ <= at) return;
    next_check_ = at;
  }
  alarm_.notify_one();
}

bool Participant::Impl::recovering() const {
  const auto now = Clock::now();
  const std::scoped_lock lock(peers_mutex_);
  return filter_->stall_guard.long_stall(now) || now < recovered_;
}

void Participant::Impl::note_peer(const EndpointId& peer, bool found) {
  const auto now = Clock::now();
  const std::scoped_lock lock(peers_mutex_);
  if (!found) {
    peers_.erase(peer);
    if (filter_->stall_guard.isolated(now)) missing_.insert(peer);  // also before the monitor thread has seen the stall
    return;
  }
  peers_.insert(peer);
  missing_.erase(peer);
  if (missing_.empty()) recovered_ = std::min(recovered_, now + kMatching);
}

void Participant::Impl::on_authentication(const rtps::GUID_t& peer, bool authorized) {
  const auto prefix = prefix_of(peer);
  handshakes_.ended(prefix, authorized, Clock::now());
  if (authorized) return;
  filter_->quarantine.dropped(prefix, Clock::now());
  Refused refused;
  std::copy(prefix.begin(), prefix.end(), refused.sender.bytes.begin());
  refused.text = "its keys are missing, expired, revoked or of another authority";
  refused.last = Clock::now();
  filter_->refusals.note(std::move(refused));
}

void Participant::Impl::note_handshake(const PeerEvent& event) {
  if (event.kind == PeerEvent::Kind::kFound) {
    handshakes_.found(prefix_of(event.guid), printable(event.name, kLongestName), Clock::now());
  } else {
    handshakes_.forget(prefix_of(event.guid));
  }
}

void Participant::Impl::note_match(const EndpointId& peer) {
  handshakes_.forget(prefix_of(peer));
  owners_.matched(peer);
}

void Participant::Impl::report_challengers() {
  for (const NodeOwners::Challenger& one : owners_.take_challengers()) {
    refusals().note({.kind = RefusalKind::kSecondWriter,
                     .topic = one.topic,
                     .sender = one.writer,
                     .key = one.key,
                     .text = "a second participant writes it",
                     .last = Clock::now()});
  }
}

void Participant::Impl::note_addresses(const PeerEvent& event) {
  const auto prefix = prefix_of(event.guid);
  std::vector<PeerQuarantine::Address> addresses;
  for (const auto& locator : event.unicast) addresses.push_back(address_of(locator));
  filter_->datagrams.forget(prefix);
  filter_->announcements.restart(addresses);
  if (event.kind == PeerEvent::Kind::kFound) {
    filter_->datagrams.found(prefix);
  } else {
    filter_->datagrams.unbind(prefix);
  }
  if (event.kind == PeerEvent::Kind::kDropped) return filter_->quarantine.dropped(prefix, Clock::now());
  if (event.kind == PeerEvent::Kind::kLeft) return filter_->quarantine.left(prefix, Clock::now());
  filter_->refusals.found(endpoint_id(event.guid), event.name,
                          addresses.empty() ? std::string() : address_text(event.unicast.front()));
  filter_->quarantine.found(prefix, std::move(addresses), event.lease, Clock::now());
}

void Participant::Impl::on_endpoint(const rtps::GUID_t& endpoint) {
  filter_->quarantine.endpoint_found(prefix_of(endpoint));
}

void Participant::Impl::on_peer(const PeerEvent& event) {
  if (event.kind == PeerEvent::Kind::kChanged) return;
  const bool found = event.kind == PeerEvent::Kind::kFound;
  const EndpointId peer = endpoint_id(event.guid);
  note_addresses(event);
  note_handshake(event);
  note_peer(peer, found);
  if (found) {
    owners_.found(peer, event.name);
  } else {
    owners_.lost(peer);
  }
  if (mailbox_ == nullptr) return;
  mailbox_->post(
      {found ? EventKind::kParticipantFound : EventKind::kParticipantLost, {}, event.name, peer, Clock::now()});
}

Participant::Participant(int domain, const std::string& name, const ParticipantOptions& options)
    : impl_(std::make_shared<Impl>(domain, name, options)) {}
Participant::~Participant() = default;
Participant::Participant(Participant&&) noexcept = default;
Participant& Participant::operator=(Participant&&) noexcept = default;

bool Participant::recovering() const {
  return impl_->recovering();
}

std::vector<std::string> Participant::joining() const {
  return impl_->joining();
}

std::optional<std::chrono::system_clock::time_point> Participant::identity_expires() const {
  return impl_->identity_expires;
}

void Participant::know_term(std::uint64_t term) {
  impl_->terms().know(term);
}

std::vector<Refused> Participant::refused(Clock::duration window, std::size_t most) const {
  impl_->report_challengers();
  return impl_->refusals().recent(Clock::now() - window, most);
}

void Participant::refuse(Refused refused) {
  refused.last = Clock::now();
  impl_->refusals().note(std::move(refused));
}

std::vector<NetworkInterface> network_interfaces() {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(list, &::freeifaddrs);
  std::vector<NetworkInterface> interfaces;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = {};
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    if (::inet_ntop(AF_INET, &address->sin_addr, text, sizeof text) != nullptr) {
      interfaces.push_back({entry->ifa_name, text});
    }
  }
  return interfaces;
}

std::vector<std::string> ignore_discovery_servers() {
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  std::vector<std::string> ignored;
  for (const char* name : {"ROS_DISCOVERY_SERVER", "FASTDDS_ENVIRONMENT_FILE"}) {
    const char* value = std::getenv(name);
    if (value == nullptr) continue;
    ignored.push_back(std::string(name) + "=" + value);
    ::unsetenv(name);
  }
  return ignored;
}

}  // namespace hecaton::bus

#ifdef __SANITIZE_ADDRESS__
// Debian's Fast DDS frees its statistics objects with another size than it allocated them with. This is a default,
// which ASAN_OPTIONS overrides.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "new_delete_type_mismatch=0";
}
#endif

#ifdef __SANITIZE_THREAD__
// Suppressed inside Fast DDS only: its timed locks (pthread_mutex_clocklock, which this sanitizer does not know), and
// an order of its locks that Impl::endpoints_mutex keeps from becoming a deadlock. Data races are not suppressed.
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "mutex:libfastrtps\ndeadlock:libfastrtps\nmutex:libfastdds\ndeadlock:libfastdds\n";
}
#endif
