#include "services/planner/planner_service.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/run_service.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(
      argc, argv, "Plans the motion of one arm of a cell, among obstacles and other planned arms",
      services::Subject::kArm, [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
        const config::CellFile file = config::load_cell_file(options.cell, options.sources);
        const int arm = services::find_arm(file, options.arm);
        const auto planners = services::planners_of(file, static_cast<std::size_t>(arm));
        const services::LogScope log(planners[services::index_on(planners, options.host)].node, options);
        services::lock_memory();
        services::start_exit_notifier(options.exit_fd);
        services::PlannerService planner(file, arm, options, shutdown);
        services::raise_service_priority(file, services::ThreadPriority::kControl);
        planner.run();
      });
}
