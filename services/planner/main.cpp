#include "services/planner/planner_service.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_service.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(
      argc, argv, "Plans the motion of one arm of a cell, among obstacles and other planned arms",
      services::Subject::kArm, [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
        const config::CellFile file = config::load_cell_file(options.cell);
        const int arm = services::find_arm(file, options.arm);
        const services::LogScope log(services::planner_node(options.arm), options);
        services::PlannerService(file, arm, options, shutdown).run();
      });
}
