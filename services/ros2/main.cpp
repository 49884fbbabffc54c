#include <stdexcept>

#include "services/ros2/ros2_service.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_service.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(
      argc, argv, "Shows a cell to the nodes of a ROS 2 domain", services::Subject::kCell,
      [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
        const config::CellFile file = config::load_cell_file(options.cell, options.sources);
        if (!file.ros2) throw std::runtime_error(file.path + ": ros2 is missing, but must be a map for this program");
        const services::LogScope log(services::ros2_node(), options);
        services::start_exit_notifier(options.exit_fd);
        ros2::Ros2Service service(file, options, shutdown);
        service.run();
      });
}
