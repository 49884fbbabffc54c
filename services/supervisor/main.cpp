#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_service.hpp"
#include "services/supervisor/supervisor.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(
      argc, argv, "Watches a cell: tells its faults, holds what they affect, answers what is going on",
      services::Subject::kCell, [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
        const config::CellFile file = config::load_cell_file(options.cell);
        const services::LogScope log(services::supervisor_node(), options);
        services::Supervisor(file, options, shutdown).run();
      });
}
