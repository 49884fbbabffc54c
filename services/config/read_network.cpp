#include "services/config/read_network.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <arpa/inet.h>

#include "services/config/fields.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

constexpr int kLastDomain = 199;
constexpr std::size_t kMostHosts = 64;
constexpr std::array<std::string_view, 2> kTransports = {"udp", "shm"};
constexpr std::array<std::string_view, 2> kDiscoveries = {"multicast", "unicast"};
constexpr std::array<std::string_view, 2> kRecoveries = {"automatic", "resume"};

// Addresses reach resolvers and messages: let nothing else through.
std::string read_address(const YamlView& view) {
  constexpr std::string_view kRule = "an IP address or a host name";
  std::string address = view.text();
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == ':' ||
           c == '-' || c == '_' || c == '%';
  };
  if (address.size() > 253 || !std::all_of(address.begin(), address.end(), allowed)) view.fail(std::string(kRule));
  return address;
}

std::string read_ipv4(const YamlView& view) {
  std::string address = view.text();
  in_addr parsed{};
  if (inet_pton(AF_INET, address.c_str(), &parsed) != 1) view.fail("an IPv4 address, such as 10.0.0.2");
  return address;
}

std::string host_rule(const std::vector<Host>& hosts) {
  std::vector<std::string_view> names;
  names.reserve(hosts.size());
  for (const Host& host : hosts) names.push_back(host.name);
  return "a host that `hosts` declares: " + alternatives(names);
}

std::string declared_host(const YamlView& view, const std::vector<Host>& hosts) {
  std::string name = view.name();
  const bool declared = std::any_of(hosts.begin(), hosts.end(), [&](const Host& host) { return host.name == name; });
  if (!declared) view.fail(host_rule(hosts));
  return name;
}

std::chrono::nanoseconds read_silence(const MapView& map, std::string_view key, std::chrono::nanoseconds fallback) {
  const auto view = map.find(key);
  if (!view) return fallback;
  const double seconds = view->seconds({0.001, 60.0, "s"});
  return std::chrono::nanoseconds(std::llround(seconds * 1e9));
}

void read_watchdog(const MapView& map, Supervision& supervision) {
  const auto view = map.find("watchdog");
  if (!view) return;
  const double seconds = view->seconds({0.0, 3600.0, "s"});
  if (seconds > 0.0 && seconds < 1.0) view->fail("0 or at least 1s: loops tell four times a second that they turn");
  supervision.watchdog = std::chrono::nanoseconds(std::llround(seconds * 1e9));
}

std::string milliseconds_text(std::chrono::nanoseconds time) {
  return number_text(std::chrono::duration<double, std::milli>(time).count()) + "ms";
}

// One sentence about two durations of a section, each given or by default.
void require_above(const MapView& map, std::string_view key, std::chrono::nanoseconds value, std::string_view other_key,
                   std::chrono::nanoseconds other) {
  if (value > other) return;
  map.fail(key, milliseconds_text(value), "above " + std::string(other_key) + " = " + milliseconds_text(other));
}

void read_discovery(const MapView& map, Network& network) {
  if (const auto peers = map.find("peers")) {
    for (const YamlView& peer : peers->items(0, kMostHosts, "addresses")) network.peers.push_back(read_ipv4(peer));
  }
  if (!network.peers.empty()) network.discovery = Discovery::kUnicast;
  const auto discovery = map.find("discovery");
  if (!discovery) return;
  network.discovery = discovery->choice(kDiscoveries) == 0 ? Discovery::kMulticast : Discovery::kUnicast;
  if (network.discovery == Discovery::kMulticast && !network.peers.empty()) {
    discovery->fail("unicast where there are peers");
  }
}

void read_recovery(const MapView& map, Supervision& supervision) {
  const auto view = map.find("recovery");
  if (!view) return;
  const MapView recovery = view->map(section::kRecovery);
  for (const std::string_view kind : section::kRecovery.keys) {
    const auto how = recovery.find(kind);
    if (!how) continue;
    supervision.waits_for_resume.erase(std::string(kind));
    if (how->choice(kRecoveries) == 1) supervision.waits_for_resume.emplace(kind);
  }
}

}  // namespace

Network read_network(const MapView& root) {
  Network network;
  const auto view = root.find("network");
  if (!view) return network;
  const MapView map = view->map(section::kNetwork);
  if (const auto domain = map.find("domain")) network.domain = domain->integer(0, kLastDomain);
  if (const auto transport = map.find("transport")) {
    network.transport = transport->choice(kTransports) == 0 ? Transport::kUdp : Transport::kSharedMemory;
  }
  if (const auto interface = map.find("interface")) network.interface = read_address(*interface);
  read_discovery(map, network);
  return network;
}

std::vector<Host> read_hosts(const MapView& root) {
  const auto view = root.find("hosts");
  if (!view) return {{"localhost", "127.0.0.1"}};
  std::vector<Host> hosts;
  for (const auto& [name, address] : view->named_items(kMostHosts)) hosts.push_back({name, read_address(address)});
  if (hosts.empty()) view->fail("a map of at least one host name to its address");
  return hosts;
}

std::string read_host(const MapView& map, std::string_view key, const std::vector<Host>& hosts) {
  if (const auto view = map.find(key)) return declared_host(*view, hosts);
  if (hosts.size() == 1) return hosts.front().name;
  map.fail_missing(key, host_rule(hosts));
}

std::string read_standby_host(const MapView& map, std::string_view key, const std::vector<Host>& hosts,
                              const std::string& active) {
  const auto view = map.find(key);
  if (!view) return {};
  std::string host = declared_host(*view, hosts);
  if (host == active) view->fail("another host than the one that it stands by for");
  return host;
}

Supervision read_supervision(const MapView& root, const std::vector<Host>& hosts) {
  Supervision supervision;
  const auto view = root.find("supervision");
  if (!view) {
    if (hosts.size() > 1) static_cast<void>(root.at("supervision"));
    supervision.host = hosts.front().name;
    return supervision;
  }
  const MapView map = view->map(section::kSupervision);
  supervision.host = read_host(map, "host", hosts);
  supervision.standby_host = read_standby_host(map, "standby_host", hosts, supervision.host);
  supervision.heartbeat_period = read_silence(map, "heartbeat_period", supervision.heartbeat_period);
  supervision.heartbeat_deadline = read_silence(map, "heartbeat_deadline", supervision.heartbeat_deadline);
  supervision.host_lease = read_silence(map, "host_lease", supervision.host_lease);
  supervision.takeover_lease = read_silence(map, "takeover_lease", supervision.takeover_lease);
  read_watchdog(map, supervision);
  read_recovery(map, supervision);
  if (supervision.heartbeat_deadline % std::chrono::milliseconds(1) != std::chrono::nanoseconds(0)) {
    map.at("heartbeat_deadline").fail("a whole number of milliseconds, because DDS deadlines are");
  }
  require_above(map, "heartbeat_deadline", supervision.heartbeat_deadline, "heartbeat_period",
                supervision.heartbeat_period);
  require_above(map, "host_lease", supervision.host_lease, "heartbeat_deadline", supervision.heartbeat_deadline);
  require_above(map, "takeover_lease", supervision.takeover_lease, "heartbeat_period", supervision.heartbeat_period);
  return supervision;
}

}  // namespace hecaton::config
