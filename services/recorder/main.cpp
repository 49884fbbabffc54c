#include <stdexcept>

#include "services/recorder/recorder_service.hpp"
#include "services/recorder/save_signal.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_service.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(
      argc, argv, "Records the last minutes of a cell, and saves them after faults", services::Subject::kCell,
      [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
        const services::recorder::SaveSignal save;
        const config::CellFile file = config::load_cell_file(options.cell, options.sources);
        if (!file.record)
          throw std::runtime_error(file.path + ": record is missing, but must be a map for this program");
        const services::LogScope log(services::recorder_node(), options);
        services::start_exit_notifier(options.exit_fd);
        services::recorder::RecorderService(file, options, shutdown).run();
      });
}
