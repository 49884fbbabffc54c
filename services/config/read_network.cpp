#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include <arpa/inet.h>

#include "services/config/readers.hpp"
#include "services/config/text.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {
namespace {

constexpr int kLastDomain = 199;
constexpr std::size_t kMostHosts = 64;
constexpr std::array<std::string_view, 2> kTransports = {"udp", "shm"};
constexpr std::array<std::string_view, 2> kDiscoveries = {"multicast", "unicast"};
constexpr std::array<std::string_view, 2> kDistributions = {"humble", "jazzy"};
constexpr std::array<std::string_view, 2> kRecoveries = {"automatic", "resume"};

constexpr std::size_t kLongestHostName = 253;  // RFC 1035, without the last dot
constexpr std::size_t kLongestLabel = 63;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

std::optional<std::uint32_t> ipv4(const std::string& text) {
  in_addr parsed{};
  if (inet_pton(AF_INET, text.c_str(), &parsed) != 1) return std::nullopt;
  return ntohl(parsed.s_addr);
}

/// A unicast address: not of "this network", a group, reserved or broadcast (RFC 1122, RFC 1112).
bool is_unicast(std::uint32_t address) {
  return address >> 24U != 0 && address >> 24U < 224;
}

/// A host name by RFC 1123, with the underscores of container names. A last label of digits alone is a mistyped
/// address: resolvers read "10.0.7" as 10.0.0.7.
bool is_host_name(std::string_view text) {
  if (text.size() > kLongestHostName) return false;
  bool only_digits = true;
  while (true) {
    const std::string_view label = text.substr(0, text.find('.'));
    const bool allowed = std::all_of(label.begin(), label.end(),
                                     [](char c) { return is_letter(c) || is_digit(c) || c == '-' || c == '_'; });
    if (label.empty() || label.size() > kLongestLabel || !allowed || label.front() == '-' || label.back() == '-') {
      return false;
    }
    only_digits = std::all_of(label.begin(), label.end(), is_digit);
    if (label.size() == text.size()) return !only_digits;
    text.remove_prefix(label.size() + 1);
  }
}

std::string read_address(const YamlView& view) {
  std::string address = view.text();
  const auto number = ipv4(address);
  if (number ? !is_unicast(*number) : !is_host_name(address)) {
    view.fail("the IPv4 address of one machine, such as 10.0.0.2, or a host name, both without a port");
  }
  return address;
}

std::string read_ipv4(const YamlView& view) {
  std::string address = view.text();
  const auto number = ipv4(address);
  if (!number || !is_unicast(*number)) {
    view.fail("an IPv4 address of one machine, such as 10.0.0.2, without a port");
  }
  return address;
}

std::string read_listen_address(const YamlView& view) {
  std::string address = view.text();
  const auto number = ipv4(address);
  if (!number || !(is_unicast(*number) || *number == 0)) {
    view.fail("an IPv4 address of the host: 127.0.0.1 for this host alone, 0.0.0.0 for all of its networks");
  }
  return address;
}

// Messages contain the name: only characters of interface names are allowed.
std::string read_interface(const YamlView& view) {
  constexpr std::size_t kLongest = 15;  // of names (IFNAMSIZ) and of IPv4 addresses
  std::string name = view.text();
  const auto allowed = [](char c) {
    return is_letter(c) || is_digit(c) || c == '.' || c == ':' || c == '-' || c == '_';
  };
  if (name.empty() || name.size() > kLongest || !std::all_of(name.begin(), name.end(), allowed)) {
    view.fail("the name or the IPv4 address of a network interface, such as eth0 or 10.0.0.2");
  }
  return name;
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

void read_time_limit(const MapView& map, std::string_view key, std::chrono::nanoseconds& out) {
  if (const auto view = map.find(key)) {
    out = std::chrono::nanoseconds(std::llround(view->seconds({0.001, 60.0, "s"}) * 1e9));
  }
}

void read_watchdog(const MapView& map, Supervision& supervision) {
  const auto view = map.find("watchdog");
  if (!view) return;
  const double seconds = view->seconds({0.0, 3600.0, "s"});
  if (seconds > 0.0 && seconds < 1.0) view->fail("0 or at least 1s: loops report progress four times a second");
  supervision.watchdog = std::chrono::nanoseconds(std::llround(seconds * 1e9));
}

void read_memory_limit(const MapView& map, Supervision& supervision) {
  const auto view = map.find("memory_limit");
  if (!view) return;
  const std::string text = view->text();
  const auto bytes = text == "0" ? 0.0 : parse_size(text);
  if (!bytes || (*bytes != 0.0 && !(*bytes >= 2e8 && *bytes <= 1e13))) {
    view->fail("0 or a number with its unit (" + std::string(kSizeUnits) + ") from 200MB to 10000GB, such as 1GB");
  }
  supervision.memory_limit = static_cast<std::uint64_t>(*bytes);
}

void read_discovery(const MapView& map, Network& network) {
  if (const auto peers = map.find("peers")) {
    for (const YamlView& peer : peers->items(0, kMostHosts, "addresses")) network.peers.push_back(read_ipv4(peer));
  }
  if (!network.peers.empty()) network.discovery = Discovery::kUnicast;
  read_choice(map, "discovery", kDiscoveries, network.discovery);
  if (network.discovery == Discovery::kMulticast && !network.peers.empty()) {
    map.at("discovery").fail("unicast where there are peers");
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

/// A namespace of ROS 2: names with letters, digits and underscores, each after a slash.
std::string read_namespace(const YamlView& view) {
  const std::string text = view.text();
  bool valid = text.front() == '/' && text.size() <= 128;
  char before = ' ';
  for (const char c : text) {
    const bool begins = before == '/' || before == ' ';
    const bool allowed = before == ' ' ? c == '/' : is_letter(c) || c == '_' || (!begins && (is_digit(c) || c == '/'));
    valid = valid && allowed;
    before = c;
  }
  if (text.find("__") != std::string::npos) {
    view.fail("a namespace without two underscores in a row, which ROS 2 does not allow in names");
  }
  if (!valid || before == '/') {
    view.fail("a namespace such as /cell1: names of letters, digits and underscores, each after a slash");
  }
  return text;
}

}  // namespace

Network read_network(const MapView& root) {
  Network network;
  const auto view = root.find("network");
  if (!view) return network;
  const MapView map = view->map(section::kNetwork);
  if (const auto domain = map.find("domain")) network.domain = domain->integer(0, kLastDomain);
  read_choice(map, "transport", kTransports, network.transport);
  if (const auto interface = map.find("interface")) network.interface = read_interface(*interface);
  read_discovery(map, network);
  if (const auto lease = map.find("lease")) {
    network.lease = std::chrono::milliseconds(std::llround(lease->seconds({0.5, 20.0, "s"}) * 1e3));
  }
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
  if (host == active) view->fail("another host than " + active + ", the host of the active service");
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
  read_time_limit(map, "heartbeat_period", supervision.heartbeat_period);
  read_time_limit(map, "heartbeat_deadline", supervision.heartbeat_deadline);
  read_time_limit(map, "host_lease", supervision.host_lease);
  read_time_limit(map, "failover_timeout", supervision.failover_timeout);
  read_watchdog(map, supervision);
  read_memory_limit(map, supervision);
  read_recovery(map, supervision);
  if (supervision.heartbeat_deadline % std::chrono::milliseconds(1) != std::chrono::nanoseconds(0)) {
    map.at("heartbeat_deadline").fail("a whole number of milliseconds, because DDS deadlines are");
  }
  const auto require_order = [&](const char* low, std::chrono::nanoseconds shorter, const char* high,
                                 std::chrono::nanoseconds longer) {
    const auto text = [](std::chrono::duration<double> time) { return milliseconds_text(time.count()); };
    if (longer <= shorter) map.fail(high, text(longer), std::string("above ") + low + " = " + text(shorter));
  };
  const auto& [period, deadline] = std::pair(supervision.heartbeat_period, supervision.heartbeat_deadline);
  require_order("heartbeat_period", period, "heartbeat_deadline", deadline);
  require_order("heartbeat_deadline", deadline, "host_lease", supervision.host_lease);
  require_order("heartbeat_period", period, "failover_timeout", supervision.failover_timeout);
  return supervision;
}

std::string read_keystore(const MapView& root) {
  const auto section = root.find("security");
  if (!section) return {};
  const YamlView keystore = section->map(section::kSecurity).at("keystore");
  return beside(keystore.file(), keystore.text());
}

bool is_reachable_by_others(const View& view) {
  return !view.listen.starts_with("127.");
}

std::string view_url(const View& view, int domain) {
  const std::string host = view.listen == "0.0.0.0" ? "localhost" : view.listen;
  return (is_reachable_by_others(view) ? "https://" : "http://") + host + ":" +
         std::to_string(view.port.value_or(view_port(domain))) + "/";
}

std::optional<View> read_view(const MapView& root, const std::vector<Host>& hosts) {
  const auto section = root.find("view");
  if (!section) return std::nullopt;
  const MapView map = section->map(section::kView);
  View view;
  view.host = read_host(map, "host", hosts);
  if (const auto listen = map.find("listen")) view.listen = read_listen_address(*listen);
  if (const auto port = map.find("port")) view.port = port->integer(1, 65535);
  read_boolean(map, "control", view.control);
  read_boolean(map, "no_stop", view.no_stop);
  const auto certificate = map.find("certificate");
  const auto key = map.find("key");
  if (certificate) view.certificate = beside(certificate->file(), certificate->text());
  if (key) view.key = beside(key->file(), key->text());
  if (certificate && !key) map.fail("key", "none", "the file of the private key of `certificate`");
  if (key && !certificate) map.fail("certificate", "none", "the file of the certificate of `key`");
  return view;
}

std::optional<Record> read_record(const MapView& root, const std::vector<Host>& hosts) {
  const auto section = root.find("record");
  if (!section) return std::nullopt;
  const MapView map = section->map(section::kRecord);
  Record record;
  const YamlView folder = map.at("folder");
  record.folder = beside(folder.file(), folder.text());
  record.host = read_host(map, "host", hosts);
  const auto read = [&](const char* key, const Bounds& bounds, std::chrono::nanoseconds& out) {
    double seconds = std::chrono::duration<double>(out).count();
    read_seconds(map, key, bounds, seconds);
    out = std::chrono::round<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
  };
  constexpr double kMonth = 2.6e6;  // [s]
  read("keep", {10.0, kMonth, "s"}, record.keep);
  read("after_fault", {0.0, kMonth, "s"}, record.after_fault);
  read("split_time", {1.0, kMonth, "s"}, record.split_time);
  const auto read_size = [&](const char* key, double least, const std::string& allowed, std::uint64_t& out) {
    const auto value = map.find(key);
    if (!value) return;
    const auto bytes = parse_size(value->text());
    if (!bytes || !(*bytes >= least && *bytes <= 1e15)) {
      value->fail("a number with its unit (" + std::string(kSizeUnits) + ") from " + allowed);
    }
    out = static_cast<std::uint64_t>(*bytes);
  };
  read_size("limit", 1e7, "10MB to 1000000GB, such as 5GB", record.limit);
  read_size("split_size", 1e5, "100kB to 1000000GB, such as 500MB", record.split_size);
  // The open file is never removed.
  if (record.split_size > record.limit / 2) map.at("split_size").fail("at most half of `limit`");
  if (const auto ros2 = map.find("ros2")) record.ros2 = ros2->boolean();
  return record;
}

std::optional<Ros2> read_ros2(const MapView& root, const std::vector<Host>& hosts) {
  const auto view = root.find("ros2");
  if (!view) return std::nullopt;
  const MapView map = view->map(section::kRos2);
  Ros2 ros2;
  if (const auto domain = map.find("domain")) ros2.domain = domain->integer(0, kLastDomain);
  if (const auto distribution = map.find("distribution")) {
    ros2.distribution = static_cast<Ros2Distribution>(distribution->choice(kDistributions));
  }
  if (const auto ns = map.find("namespace")) ros2.ns = read_namespace(*ns);
  ros2.host = read_host(map, "host", hosts);
  if (const auto interface = map.find("interface")) ros2.interface = read_interface(*interface);
  read_seconds(map, "period", {0.01, 1.0, "s"}, ros2.period);
  read_boolean(map, "control", ros2.control);
  if (const auto enclave = map.find("enclave")) ros2.enclave = beside(enclave->file(), enclave->text());
  return ros2;
}

}  // namespace hecaton::config
