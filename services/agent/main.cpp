#include <exception>
#include <filesystem>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "services/agent/agent.hpp"
#include "services/arm_driver/device_choice.hpp"
#include "services/config/link_pair_cache.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_service.hpp"

namespace {

using namespace hecaton;

/// Creates the folder if it does not exist. Throws std::runtime_error with a sentence when that fails.
void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error("--log-dir " + folder.string() + " cannot be created: " + error.message());
}

}  // namespace

int main(int argc, char** argv) {
  services::ShutdownSignal shutdown;
  services::ServiceOptions options;
  services::AgentOptions agent;
  bool no_restart = false;
  bool view = false;
  CLI::App app("Starts and supervises the services that a cell file places on a host (default: on all its hosts)");
  app.add_option("CELL", options.cell, "cell file (YAML)")->required();
  app.add_option("--log-dir", agent.logs, "folder for the services' logs (default: the agent's own streams)");
  app.add_flag("--no-restart", no_restart, "do not restart services that exit or hang");
  app.add_flag("--clean", agent.clean, "remove the checkpoints that a killed agent and its services have left");
  app.add_flag("--view", view, "start the view also if the cell file has no key view");
  services::add_common_options(app, options);
  if (const auto leave = services::parse_or_explain(app, argc, argv)) return static_cast<int>(*leave);
  try {
    agent.restart = !no_restart;
    agent.programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    services::keep_files_private();
    config::use_link_pair_folder();
    make_folder(agent.logs);
    config::CellFile file = config::load_cell_file(options.cell);
    if (view && !file.view) file.view.emplace().host = file.hosts.front().name;
    services::require_known_devices(file);
    if (app.count("--host") > 0) services::require_host(file, options.host);  // an empty --host, too
    const services::LogScope log(services::agent_node(options.host.empty() ? "all" : options.host), options);
    services::lock_memory();
    services::Agent service(file, options, agent, shutdown);
    services::raise_service_priority(file, services::ThreadPriority::kAgent);
    service.run();
  } catch (const std::exception& error) {
    services::complain(error.what());
    return static_cast<int>(services::ExitCode::kBadInput);
  }
  return static_cast<int>(services::ExitCode::kDone);
}
