#include "services/runtime/join.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <future>
#include <map>
#include <memory>
#include <stdexcept>
#include <system_error>

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>

#include "services/bus/participant.hpp"
#include "services/bus/topics.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/thread_priority.hpp"
#include "services/security/expiry.hpp"

namespace hecaton::services {
namespace {

/// Participants of clients on each machine, beside the cell's own processes.
constexpr int kClients = 8;

/// The host's IPv4 address; empty, with a warning, when its name cannot be resolved.
std::string resolved(const config::Host& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* list = nullptr;
  const int error = getaddrinfo(host.address.c_str(), nullptr, &hints, &list);
  if (error != 0) {
    log_warning("host name cannot be resolved: this process waits for the announcements of that host",
                {{"key", "hosts." + host.name}, {"name", host.address}, {"reason", gai_strerror(error)}});
    return {};
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(list, freeaddrinfo);
  std::array<char, INET_ADDRSTRLEN> text{};
  const auto* address = reinterpret_cast<const sockaddr_in*>(list->ai_addr);
  inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
  return text.data();
}

/// The number of participants that the cell file places on each host, by the host's name.
std::map<std::string, int> placed(const config::CellFile& file) {
  std::map<std::string, int> count;
  for (const config::Host& host : file.hosts) count[host.name] = 1;  // its agent
  ++count[file.world_host];
  ++count[file.supervision.host];
  if (!file.supervision.standby_host.empty()) ++count[file.supervision.standby_host];
  if (file.view) ++count[file.view->host];
  if (file.record) count[file.record->host] += 2;  // one for raw samples, one for all else
  if (file.ros2) count[file.ros2->host] += 2;      // its own participant and its client
  for (const config::ArmHosts& arm : file.arm_hosts) {
    count[arm.host] += 2;  // driver and planner
    if (!arm.standby_host.empty()) ++count[arm.standby_host];
  }
  return count;
}

std::vector<std::string> wanted_interfaces(const config::CellFile& file) {
  return interface_addresses(file, "network.interface", file.network.interface);
}

}  // namespace

std::vector<std::string> interface_addresses(const config::CellFile& file, const std::string& key,
                                             const std::string& wanted) {
  if (wanted.empty()) return {};
  std::vector<std::string> addresses;
  std::string all;
  for (const bus::NetworkInterface& one : bus::network_interfaces()) {
    if (one.name == wanted || one.address == wanted) addresses.push_back(one.address);
    all.append(all.empty() ? "" : ", ").append(one.name).append(" (").append(one.address).append(")");
  }
  if (addresses.empty()) {
    throw std::runtime_error(file.path + ": " + key + " = " + wanted +
                             " must be the name or the address of a network interface of this machine: " + all);
  }
  return addresses;
}

void require_interface(const config::CellFile& file) {
  static_cast<void>(wanted_interfaces(file));
}

std::vector<bus::Peer> peers_of(const config::CellFile& file, const std::vector<std::string>& interfaces) {
  if (file.network.discovery == config::Discovery::kMulticast) return {};
  const auto count = placed(file);
  std::map<std::string, int> participants;  // by address
  int all = 0;
  for (const config::Host& host : file.hosts) {
    const std::string address = resolved(host);
    if (!address.empty()) participants[address] += count.at(host.name);
    all += count.at(host.name);
  }
  const auto at_least_all = [&](const std::vector<std::string>& addresses) {
    for (const std::string& address : addresses) participants[address] = std::max(participants[address], all);
  };
  // For a trial the whole cell may run on this machine, whatever the addresses say.
  at_least_all(interfaces.empty() ? std::vector<std::string>{"127.0.0.1"} : interfaces);
  at_least_all(file.network.peers);
  std::vector<bus::Peer> peers;
  for (const auto& [address, number] : participants) {
    peers.push_back({address, std::min(number + kClients, bus::kMostParticipants)});
  }
  return peers;
}

namespace {

[[noreturn]] void fail_without_identity(const config::CellFile& file, const std::string& host, Role role) {
  const bool of_people = role == Role::kOperator || role == Role::kViewer;
  const std::string owner = !host.empty() ? host : of_people ? kPeople : "HOST";
  throw std::runtime_error(file.path + ": security.keystore = " + file.keystore + " has no identity of the role " +
                           std::string(role_name(role)) + (host.empty() ? "" : " for host " + host) +
                           "; make it with `hecaton keystore add DIR " + owner + " --for " + file.path +
                           "` where the private key of the authority is, and copy DIR/enclaves/" + owner +
                           " to this machine");
}

}  // namespace

std::filesystem::path identity_of(const config::CellFile& file, const std::string& host, Role role) {
  if (file.keystore.empty()) return {};
  std::filesystem::path enclave = enclave_folder(file.keystore, host, role);
  std::error_code unreadable;  // require_identity() says why
  if (host.empty()) {
    const auto all = identities_in(file.keystore);
    const auto first =
        std::find_if(all.begin(), all.end(), [&](const IdentityState& one) { return one.role == role_name(role); });
    if (first == all.end()) fail_without_identity(file, host, role);
    enclave = enclave_folder(file.keystore, first->host, role);
  } else if (!std::filesystem::exists(enclave, unreadable) && !unreadable) {
    fail_without_identity(file, host, role);
  }
  require_identity(enclave);
  return std::filesystem::absolute(enclave);
}

namespace {

/// Keys, and what ends them.
void set_identity(bus::ParticipantOptions& participant, const std::filesystem::path& enclave) {
  participant.identity = enclave;
  if (enclave.empty()) return;
  const auto expires = expiry_of(enclave);
  participant.identity_expires = expires;
  // Supervisors report the keys of running nodes only, not those of a person.
  if (expires - std::chrono::system_clock::now() < kExpiryLead) {
    log_warning("identity expires soon", {{"folder", enclave.string()},
                                          {"expires", date_text(expires)},
                                          {"reason", "`hecaton keystore renew` makes new keys"}});
  }
  if (const auto outdated = outdated_permissions(enclave)) {
    log_warning("identity is outdated", {{"folder", enclave.string()}, {"reason", *outdated}});
  }
  const std::filesystem::path revocations = revocations_file(keystore_of(enclave));
  if (std::filesystem::exists(revocations)) participant.revocations = revocations;
  participant.revoked = [watch = RevocationWatch(enclave), logged = std::string()]() mutable {
    const std::vector<GuidBeginning>& revoked = watch.update();
    if (watch.problem() != logged) {
      logged = watch.problem();
      if (!logged.empty()) log_warning("list of revoked certificates not used", {{"reason", logged}});
    }
    return revoked;
  };
}

/// The nodes whose messages only they may write, see bus::ParticipantOptions::nodes.
std::vector<std::string> owning_nodes(const config::CellFile& file) {
  std::vector<std::string> nodes;
  const auto add = [&](const std::vector<PlacedNode>& placed) {
    for (const PlacedNode& one : placed) nodes.push_back(one.node);
  };
  add(supervisors_of(file));
  for (std::size_t arm = 0; arm < file.cell.arms.size(); ++arm) add(planners_of(file, arm));
  return nodes;
}

}  // namespace

bus::ParticipantOptions participant_options(const config::CellFile& file, const std::string& host, Role role) {
  bus::ParticipantOptions participant;
  set_identity(participant, identity_of(file, host, role));
  participant.interfaces = wanted_interfaces(file);
  participant.peers = peers_of(file, participant.interfaces);
  participant.shared_memory = file.network.transport == config::Transport::kSharedMemory;
  participant.partition = file.cell.name;
  participant.nodes = owning_nodes(file);
  participant.lease = file.network.lease;
  return participant;
}

namespace {

/// Below the period after which reliable writers ask for acknowledgements again (Qos::heartbeat).
constexpr std::chrono::milliseconds kReceptionPause{4};

bus::Participant join(const config::CellFile& file, const ServiceOptions& options, const std::string& node,
                      const bus::ParticipantOptions& participant) {
  for (const std::string& server : bus::ignore_discovery_servers()) {
    log_warning("environment variable ignored: a cell uses no Discovery Server", {{"variable", server}});
  }
  return {choose_domain(options, file.network.domain), node, participant};
}

}  // namespace

bus::Participant make_participant(const config::CellFile& file, const ServiceOptions& options, Role role,
                                  const std::string& node, bus::Mailbox* mailbox) {
  bus::ParticipantOptions participant = participant_options(file, options.host, role);
  participant.mailbox = mailbox;
  return join(file, options, node, participant);
}

bus::Participant make_watching_participant(const config::CellFile& file, const ServiceOptions& options, Role role,
                                           const std::string& node, bus::Mailbox* mailbox) {
  bus::ParticipantOptions participant = participant_options(file, options.host, role);
  participant.mailbox = mailbox;
  participant.reception_pause = kReceptionPause;
  // The threads of the participant inherit the priority of the thread that makes it.
  return std::async(std::launch::async,
                    [&] {
                      give_way();
                      return join(file, options, node, participant);
                    })
      .get();
}

HeartbeatTiming heartbeat_timing(const config::CellFile& file, const ServiceOptions& options) {
  return {file.supervision.heartbeat_period, options.heartbeat_fd};
}

int find_arm(const config::CellFile& file, const std::string& name) {
  std::string names;
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const std::string& candidate = file.cell.arms[i].arm.name;
    if (candidate == name) return static_cast<int>(i);
    names += (i == 0 ? "" : ", ") + candidate;
  }
  throw std::runtime_error(file.path + ": --arm " + name + " must be one of " + names);
}

}  // namespace hecaton::services
