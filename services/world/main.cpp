#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_service.hpp"
#include "services/world/world_service.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(argc, argv, "Simulates the obstacles of a cell and monitors contacts and separations",
                               services::Subject::kCell,
                               [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
                                 const config::CellFile file = config::load_cell_file(options.cell, options.sources);
                                 const services::LogScope log(services::world_node(), options);
                                 services::lock_memory();
                                 services::start_exit_notifier(options.exit_fd);
                                 services::WorldService world(file, options, shutdown);
                                 services::raise_service_priority(file, services::ThreadPriority::kControl);
                                 world.run();
                               });
}
