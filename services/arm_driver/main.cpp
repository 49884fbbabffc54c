#include "services/arm_driver/arm_driver.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/life_line.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/memory_lock.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_service.hpp"

int main(int argc, char** argv) {
  using namespace hecaton;
  return services::run_service(
      argc, argv, "Drives one arm of a cell: follows its planner's commands, stops by itself when they cease",
      services::Subject::kArm, [](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
        const config::CellFile file = config::load_cell_file(options.cell, options.sources);
        const int arm = services::find_arm(file, options.arm);
        const services::LogScope log(services::driver_node(options.arm), options);
        services::lock_memory();
        services::hold_life_line(options.life_fd);
        services::ArmDriver driver(file, arm, options, shutdown);
        services::hurry(file, services::Urgency::kSafety);
        driver.run();
      });
}
