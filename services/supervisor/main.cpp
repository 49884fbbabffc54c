#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/run_service.hpp"
#include "services/supervisor/supervisor.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(
      argc, argv, "Supervises a cell: detects faults, holds the arms that they affect, answers requests",
      services::Subject::kCell, [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
        const config::CellFile file = config::load_cell_file(options.cell, options.sources);
        const auto supervisors = services::supervisors_of(file);
        const services::LogScope log(supervisors[services::index_on(supervisors, options.host)].node, options);
        services::lock_memory();
        services::start_exit_notifier(options.exit_fd);
        services::Supervisor supervisor(file, options, shutdown);
        services::raise_service_priority(file, services::ThreadPriority::kSafety);
        supervisor.run();
      });
}
