#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/supervisor/supervisor.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  services::ShutdownSignal shutdown;
  services::ServiceOptions options;
  std::string memory;
  CLI::App app("Watches a cell: tells its faults, holds what they affect, answers what is going on");
  app.add_option("CELL", options.cell, "cell file (YAML)")->required();
  app.add_option("--memory", memory, "file in which term and people's orders survive a restart of the supervisor");
  services::add_common_options(app, options);
  if (const auto leave = services::parse_or_explain(app, argc, argv)) return static_cast<int>(*leave);
  try {
    const config::CellFile file = config::load_cell_file(options.cell);
    const services::LogScope log(services::supervisor_node(), options);
    services::Supervisor(file, options, memory, shutdown).run();
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return static_cast<int>(services::ExitCode::kBadInput);
  }
  return static_cast<int>(services::ExitCode::kDone);
}
