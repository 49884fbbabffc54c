#include "services/runtime/join.hpp"
#include "services/runtime/life_line.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/memory_lock.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_service.hpp"
#include "services/world/world_service.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(argc, argv, "Owns the obstacles of a cell and judges contacts and separations",
                               services::Subject::kCell,
                               [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
                                 const config::CellFile file = config::load_cell_file(options.cell, options.sources);
                                 const services::LogScope log(services::world_node(), options);
                                 services::lock_memory();
                                 services::hold_life_line(options.life_fd);
                                 services::WorldService world(file, options, shutdown);
                                 services::hurry(file, services::Urgency::kWork);
                                 world.run();
                               });
}
