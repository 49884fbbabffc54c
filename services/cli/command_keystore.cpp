/// hecaton keystore create|add|check: the keys of a secured cell.

#include <chrono>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "services/cli/commands.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/security/keystore.hpp"

namespace hecaton::services::cli {
namespace {

constexpr std::uint64_t kLongest = 36500;  // [day]
constexpr std::chrono::days kSoon{30};

struct Options {
  std::string folder;
  std::string host;
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

std::chrono::days days(const Options& options) {
  return std::chrono::days(options.days);
}

std::string date_text(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[16];
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

ExitCode create(const Settings& settings, const Options& options) {
  create_keystore(options.folder, days(options));
  print(settings, {{"keystore", options.folder}},
        "created " + options.folder + "\nnext: hecaton keystore add " + options.folder +
            " HOST, once for each host of the cell file\n");
  return ExitCode::kDone;
}

ExitCode add(const Settings& settings, const Options& options) {
  add_host(options.folder, options.host, days(options));
  const std::string enclave = (std::filesystem::path(options.folder) / "enclaves" / options.host).string();
  print(settings, {{"host", options.host}, {"folder", enclave}},
        "added the identities of " + options.host + "\ncopy " + enclave + " to that host, into the folder " +
            "enclaves of its keystore; " + options.folder + "/private stays where it is\n");
  return ExitCode::kDone;
}

ExitCode check(const Settings& settings, const Options& options) {
  const auto now = std::chrono::system_clock::now();
  Json identities = Json::array();
  Table table({{"host"}, {"role"}, {"expires"}, {"state"}});
  bool all_usable = true;
  for (const IdentityState& one : identities_in(options.folder)) {
    std::string state = one.problem.value_or("");
    if (!one.problem) state = one.expires - now < kSoon ? "expires soon" : "usable";
    all_usable = all_usable && !one.problem;
    identities.push_back({{"host", one.host},
                          {"role", one.role},
                          {"expires", date_text(one.expires)},
                          {"usable", !one.problem},
                          {"state", state}});
    table.add({one.host, one.role, date_text(one.expires), state});
  }
  print(settings, {{"identities", identities}}, table.text(Palette::for_stream(stdout)));
  return all_usable ? ExitCode::kDone : ExitCode::kNegative;
}

CLI::App* add_folder_command(CLI::App& app, const char* name, const char* description, Options& options) {
  CLI::App* command = app.add_subcommand(name, description);
  command->add_option("DIR", options.folder, "keystore")->required();
  return command;
}

void add_validity(CLI::App& command, Options& options, std::uint64_t preset) {
  options.days = preset;
  add_whole_number(
      command, "--days", [&options](std::uint64_t number) { options.days = number; },
      "how long the certificates are valid (" + std::to_string(preset) + ")", 1, kLongest);
}

}  // namespace

void add_keystore(CLI::App& app, Session& session) {
  CLI::App* keystore = app.add_subcommand("keystore", "Makes and checks the keys of a secured cell");
  keystore->require_subcommand(1);
  const auto does = [&session](CLI::App* command, std::shared_ptr<Options> options, auto action) {
    command->callback([&session, options, action] {
      session.action = [&session, options, action] {
        return guarded([&] { return action(session.settings, *options); });
      };
    });
  };
  const auto created = std::make_shared<Options>();
  CLI::App* creation = add_folder_command(*keystore, "create", "Makes the authority that signs identities", *created);
  add_validity(*creation, *created, 3650);
  does(creation, created, create);
  const auto added = std::make_shared<Options>();
  CLI::App* addition = add_folder_command(*keystore, "add", "Makes the identities of a host, or new ones", *added);
  addition->add_option("HOST", added->host, "a host of the cell file")->required();
  add_validity(*addition, *added, 365);
  does(addition, added, add);
  const auto checked = std::make_shared<Options>();
  CLI::App* checking = add_folder_command(*keystore, "check", "Lists the identities and when they expire", *checked);
  checking->footer("Exit code 1: an identity cannot be used.");
  does(checking, checked, check);
}

}  // namespace hecaton::services::cli
