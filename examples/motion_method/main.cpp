// Simulates a cell file, which may use the method "spring".
//
// usage: example_motion_method CELL.yaml

#include <cstdio>
#include <exception>

#include "examples/motion_method/spring_method.hpp"
#include "planner/methods/registry.hpp"
#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s CELL.yaml\n", argv[0]);
    return 2;
  }
  try {
    hecaton::planner::MethodRegistry methods = hecaton::planner::built_in_methods();
    methods.add<example::SpringMethod>();
    const hecaton::config::CellFile file = hecaton::config::load_cell_file(argv[1], {}, methods);
    hecaton::planner::BatchOptions options;
    options.tasks = 20;
    const hecaton::planner::BatchReport report = hecaton::planner::simulate_tasks(file.cell, options);
    std::printf("%d of %d goals reached, %llu contacts\n", report.reached, report.tasks,
                static_cast<unsigned long long>(report.contacts));
    return report.tasks == options.tasks && report.reached == report.tasks && report.contacts == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
