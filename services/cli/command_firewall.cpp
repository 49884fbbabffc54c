/// hecaton firewall: rules for nftables that let only the hosts of a cell send to its processes.

#include <array>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <arpa/inet.h>
#include <netdb.h>

#include "services/cli/commands.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/program.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/options.hpp"

namespace hecaton::services::cli {
namespace {

struct FirewallOptions {
  std::string cell;
  std::vector<std::string> allowed;
};

/// The UDP ports of the participants of a DDS domain (RTPS 2.3, section 9.6.1.1).
struct Ports {
  explicit Ports(int domain) : first(7400 + 250 * domain), last(first + 249) {}
  int first;
  int last;
};

/// An IPv4 address. Throws Failure (bad input) when a name has none. `key`: where it stands, "--allow".
std::string address_of(const std::string& name, const std::string& key) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* list = nullptr;
  if (const int error = getaddrinfo(name.c_str(), nullptr, &hints, &list); error != 0) {
    throw Failure(ExitCode::kBadInput, key + " = " + name + " has no IPv4 address (" + gai_strerror(error) +
                                           "); give the address, or run this where the name is known");
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(list, freeaddrinfo);
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(list->ai_addr)->sin_addr, text.data(), text.size());
  return text.data();
}

/// Of the cell's hosts, of the machines that its file names as peers, and of those that the user allows. Those of the
/// loopback interface need no rule.
std::set<std::string> senders(const config::CellFile& file, const std::vector<std::string>& allowed) {
  std::set<std::string> addresses;
  for (const config::Host& host : file.hosts) {
    addresses.insert(address_of(host.address, file.path + ": hosts." + host.name));
  }
  addresses.insert(file.network.peers.begin(), file.network.peers.end());
  for (const std::string& name : allowed) addresses.insert(address_of(name, "--allow"));
  std::erase_if(addresses, [](const std::string& address) { return address.starts_with("127."); });
  return addresses;
}

std::string rules_text(const config::CellFile& file, int domain, const std::set<std::string>& addresses) {
  const Ports ports(domain);
  const std::string table = "table inet hecaton_" + std::to_string(domain);
  const std::string range = "udp dport " + std::to_string(ports.first) + "-" + std::to_string(ports.last);
  std::string text = "# Cell " + file.cell.name + ": only its hosts reach its processes (DDS domain " +
                     std::to_string(domain) + ").\n# Load it on each host with: nft -f FILE\n" + table +
                     " {}\ndelete " + table + "\n" + table + " {\n";
  if (!addresses.empty()) {
    text += "  set senders {\n    type ipv4_addr\n    elements = { ";
    for (const std::string& address : addresses) text += (address == *addresses.begin() ? "" : ", ") + address;
    text += " }\n  }\n";
  }
  text += "  chain input {\n    type filter hook input priority filter; policy accept;\n    iif lo accept\n";
  if (!addresses.empty()) text += "    ip saddr @senders " + range + " accept\n";
  return text + "    " + range + " counter drop\n  }\n}\n";
}

ExitCode run_firewall(const Settings& settings, const FirewallOptions& options) {
  const config::CellFile file = config::load_cell_file(options.cell);
  ServiceOptions wanted;
  wanted.domain = settings.domain;
  const int domain = choose_domain(wanted, file.network.domain);
  const std::set<std::string> addresses = senders(file, options.allowed);
  const std::string rules = rules_text(file, domain, addresses);
  const Ports ports(domain);
  print(settings,
        {{"cell", file.cell.name},
         {"domain", domain},
         {"ports", {{"first", ports.first}, {"last", ports.last}}},
         {"senders", addresses},
         {"rules", rules}},
        rules);
  return ExitCode::kDone;
}

}  // namespace

void add_firewall(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("firewall", "Prints rules for nftables: only the hosts of a cell reach its processes");
  auto options = std::make_shared<FirewallOptions>();
  command->add_option("CELL", options->cell, "cell file (YAML)")->required();
  command
      ->add_option("--allow", options->allowed,
                   "another machine that may reach them, such as one from which people command the cell")
      ->type_name("ADDRESS");
  command->footer(
      "Load them on each host: hecaton firewall CELL | sudo nft -f -. They replace those of an earlier call for the "
      "same DDS domain. Ports of the page, of ROS 2 and of robots stay as they are. A sender can forge its address "
      "unless the network prevents it.");
  command->callback([&session, options] {
    session.action = [&session, options] { return run_firewall(session.settings, *options); };
  });
}

}  // namespace hecaton::services::cli
