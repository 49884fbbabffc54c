#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/life_line.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/memory_lock.hpp"
#include "services/runtime/run_service.hpp"
#include "services/supervisor/supervisor.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(
      argc, argv, "Watches a cell: tells its faults, holds what they affect, answers what is going on",
      services::Subject::kCell, [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
        const config::CellFile file = config::load_cell_file(options.cell, options.sources);
        const auto supervisors = services::supervisors_of(file);
        const services::LogScope log(supervisors[services::index_on(supervisors, options.host)].node, options);
        services::lock_memory();
        services::hold_life_line(options.life_fd);
        services::Supervisor supervisor(file, options, shutdown);
        services::hurry(file, services::Urgency::kSafety);
        supervisor.run();
      });
}
