/// hecaton keystore create|add|renew|revoke|check: the keys of a secured cell.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "services/cli/commands.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/text.hpp"
#include "services/runtime/cell_duties.hpp"
#include "services/security/expiry.hpp"
#include "services/security/keystore.hpp"

namespace hecaton::services::cli {
namespace {

constexpr std::uint64_t kLongestValidity = 36500;  // [day]

struct KeystoreOptions {
  std::string folder;
  std::string host;
  std::vector<std::string> hosts;
  std::vector<std::string> arms;
  std::string cell;
  std::uint64_t days = 0;
};

template <class Action>
ExitCode guarded(Action action) {
  try {
    return action();
  } catch (const KeystoreError& error) {
    throw Failure(ExitCode::kBadInput, error.what());
  }
}

std::chrono::days days(const KeystoreOptions& options) {
  return std::chrono::days(options.days);
}

std::string enclave(const KeystoreOptions& options, const std::string& host) {
  return (std::filesystem::path(options.folder) / "enclaves" / host).string();
}

ExitCode create(const Settings& settings, const KeystoreOptions& options) {
  create_keystore(options.folder, days(options));
  print(settings, {{"keystore", options.folder}},
        "created " + options.folder + "\nnext: hecaton keystore add " + options.folder + " --for CELL\n");
  return ExitCode::kDone;
}

/// "driver (north), planner (north, west)"
std::string duties_text(const std::vector<Duty>& duties) {
  std::string text;
  for (const Duty& duty : duties) {
    text += (text.empty() ? "" : ", ") + std::string(role_name(duty.role));
    if (duty.arms.empty()) continue;
    text += " (" + config::listed(std::vector<std::string_view>(duty.arms.begin(), duty.arms.end())) + ")";
  }
  return text;
}

/// What the cell file places on the host that the options name, or on each. Throws Failure (bad input) for another
/// host, and for a cell whose host has the name of the identities of persons.
std::vector<HostDuties> wanted_duties(const KeystoreOptions& options) {
  const config::CellFile file = config::load_cell_file(options.cell);
  for (const config::Host& host : file.hosts) {
    if (host.name != kPeople) continue;
    throw Failure(ExitCode::kBadInput, options.cell + ": hosts: '" + host.name +
                                           "' must have another name; that one is of the identities of persons");
  }
  std::vector<HostDuties> all = duties_of(file);
  if (options.host.empty()) return all;
  std::vector<std::string_view> hosts;
  for (const HostDuties& one : all) hosts.emplace_back(one.host);
  if (std::find(hosts.begin(), hosts.end(), options.host) == hosts.end()) {
    throw Failure(ExitCode::kBadInput, options.cell + ": HOST '" + config::printable(options.host) +
                                           "' must be one of " + config::listed(hosts));
  }
  std::erase_if(all, [&](const HostDuties& one) { return one.host != options.host; });
  return all;
}

ExitCode add_for_cell(const Settings& settings, const KeystoreOptions& options) {
  const std::vector<HostDuties> wanted = wanted_duties(options);
  for (const HostDuties& one : wanted) require_addable(options.folder, one.host, one.duties);
  Json added = Json::array();
  Table table({{"host"}, {"roles (arms)"}});
  for (const HostDuties& one : wanted) {
    add_identities(options.folder, one.host, days(options), one.duties);
    Json roles = Json::array();
    for (const Duty& duty : one.duties) roles.push_back({{"role", role_name(duty.role)}, {"arms", duty.arms}});
    added.push_back({{"host", one.host}, {"folder", enclave(options, one.host)}, {"roles", roles}});
    table.add({one.host, duties_text(one.duties)});
  }
  const std::string revoked = revocations_file(options.folder).string();
  const std::string too = std::filesystem::exists(revoked) ? ", and " + revoked + " to each" : "";
  print(settings, {{"added", added}},
        table.text(Palette::for_stream(stdout)) + "copy " + enclave(options, "HOST") + " to each host" + too +
            ", into the folder enclaves of its keystore; " + enclave(options, kPeople) +
            " is for those who use hecaton; " + options.folder + "/private stays where it is\n");
  return ExitCode::kDone;
}

ExitCode add(const Settings& settings, const KeystoreOptions& options) {
  if (!options.cell.empty()) return add_for_cell(settings, options);
  if (options.host.empty()) {
    throw Failure(ExitCode::kUsage, "name a HOST, or with --for the cell file whose hosts get identities");
  }
  add_host(options.folder, options.host, days(options), options.arms);
  const std::string folder = enclave(options, options.host);
  const std::string revoked = revocations_file(options.folder).string();
  const std::string too = std::filesystem::exists(revoked) ? ", and " + revoked : "";
  print(settings, {{"host", options.host}, {"folder", folder}},
        "added the identities of " + options.host + "\ncopy " + folder + too + " to that host, into the folder " +
            "enclaves of its keystore; " + options.folder + "/private stays where it is\n");
  return ExitCode::kDone;
}

ExitCode renew(const Settings& settings, const KeystoreOptions& options) {
  const std::vector<std::string> hosts = options.hosts.empty() ? hosts_in(options.folder) : options.hosts;
  Json renewed = Json::array();
  std::string text;
  for (const std::string& host : hosts) {
    renew_host(options.folder, host, days(options));
    renewed.push_back({{"host", host}, {"folder", enclave(options, host)}});
    text += "renewed the identities of " + host + ": copy " + enclave(options, host) +
            " to that host, into the folder enclaves of its keystore\n";
  }
  text += hosts.empty() ? options.folder + " has no identities; `hecaton keystore add` makes them\n"
                        : "next: on each of these hosts restart all services of the cell, which use the old keys until "
                          "then; old and new keys work together\n";
  print(settings, {{"renewed", renewed}}, text);
  return ExitCode::kDone;
}

ExitCode revoke(const Settings& settings, const KeystoreOptions& options) {
  revoke_host(options.folder, options.host);
  const std::string list = revocations_file(options.folder).string();
  print(settings, {{"host", options.host}, {"list", list}},
        "revoked the identities of " + options.host + "\ncopy " + list + " to each other host, into the folder " +
            "enclaves of its keystore; its services end the connections within seconds\n"
            "then restart all services of the cell: the revoked host knows the keys of their sessions\n");
  return ExitCode::kDone;
}

/// "north, west"; "all"; empty for a role that concerns no arm.
std::string arm_list_text(const IdentityState& identity) {
  if (!identity.arms.empty())
    return config::listed(std::vector<std::string_view>(identity.arms.begin(), identity.arms.end()));
  const bool of_arms = identity.role == role_name(Role::kPlanner) || identity.role == role_name(Role::kDriver);
  return of_arms ? "all" : "";
}

ExitCode check(const Settings& settings, const KeystoreOptions& options) {
  const auto now = std::chrono::system_clock::now();
  Json identities = Json::array();
  Table table({{"host"}, {"role"}, {"arms"}, {"expires"}, {"days left", Align::kRight}, {"state"}});
  bool all_current = true;
  for (const IdentityState& one : identities_in(options.folder)) {
    std::string state = one.problem ? *one.problem : one.outdated.value_or("");
    if (state.empty()) state = one.expires - now < kExpiryLead ? "expires soon" : "usable";
    const auto left = std::chrono::floor<std::chrono::days>(one.expires - now).count();
    all_current = all_current && !one.problem && !one.outdated;
    identities.push_back({{"host", one.host},
                          {"role", one.role},
                          {"arms", one.arms.empty() ? Json() : Json(one.arms)},
                          {"expires", date_text(one.expires)},
                          {"days_left", left},
                          {"usable", !one.problem},
                          {"outdated", one.outdated.has_value()},
                          {"state", state}});
    table.add({one.host, one.role, arm_list_text(one), date_text(one.expires), std::to_string(left), state});
  }
  print(settings, {{"identities", identities}}, table.text(Palette::for_stream(stdout)));
  return all_current ? ExitCode::kDone : ExitCode::kNegative;
}

CLI::App* add_folder_command(CLI::App& app, const char* name, const char* description, KeystoreOptions& options) {
  CLI::App* command = app.add_subcommand(name, description);
  command->add_option("DIR", options.folder, "keystore")->required();
  return command;
}

void add_validity(CLI::App& command, KeystoreOptions& options, std::uint64_t preset) {
  options.days = preset;
  add_whole_number(
      command, "--days", [&options](std::uint64_t number) { options.days = number; },
      "how long the certificates are valid (" + std::to_string(preset) + ")", 1, kLongestValidity);
}

}  // namespace

void add_keystore(CLI::App& app, Session& session) {
  CLI::App* keystore = app.add_subcommand("keystore", "Makes and checks the keys of a secured cell");
  keystore->require_subcommand(1);
  const auto does = [&session](CLI::App* command, std::shared_ptr<KeystoreOptions> options, auto action) {
    command->callback([&session, options, action] {
      session.action = [&session, options, action] {
        return guarded([&] { return action(session.settings, *options); });
      };
    });
  };
  const auto created = std::make_shared<KeystoreOptions>();
  CLI::App* creation = add_folder_command(*keystore, "create", "Makes the authority that signs identities", *created);
  add_validity(*creation, *created, 3650);
  does(creation, created, create);
  const auto added = std::make_shared<KeystoreOptions>();
  CLI::App* addition = add_folder_command(*keystore, "add", "Makes the identities of a host, or new ones", *added);
  addition->add_option("HOST", added->host, "a host of the cell file; with --for: only this one");
  CLI::Option* arms =
      addition
          ->add_option("--arms", added->arms,
                       "the only arms that planners of this host may command, such as north,west (all arms)")
          ->delimiter(',');
  addition
      ->add_option("--for", added->cell,
                   "cell file: each host gets the roles and arms that it places there, persons get `people`; none of "
                   "these identities may exist")
      ->excludes(arms);
  add_validity(*addition, *added, 365);
  does(addition, added, add);
  const auto renewed = std::make_shared<KeystoreOptions>();
  CLI::App* renewal =
      add_folder_command(*keystore, "renew", "Makes new keys for identities before they expire", *renewed);
  renewal->add_option("HOST", renewed->hosts, "hosts of the keystore; without any: all");
  add_validity(*renewal, *renewed, 365);
  does(renewal, renewed, renew);
  const auto revoked = std::make_shared<KeystoreOptions>();
  CLI::App* revocation =
      add_folder_command(*keystore, "revoke", "Ends the identities of a host, also where they are connected", *revoked);
  revocation->add_option("HOST", revoked->host, "a host of the keystore")->required();
  does(revocation, revoked, revoke);
  const auto checked = std::make_shared<KeystoreOptions>();
  CLI::App* checking = add_folder_command(*keystore, "check", "Lists the identities and when they expire", *checked);
  checking->footer("Exit code 1: an identity cannot be used, or its permissions are older than this program.");
  does(checking, checked, check);
}

}  // namespace hecaton::services::cli
