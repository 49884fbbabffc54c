// Simulates a cell file, which may have obstacles of the type "cone".
//
// usage: example_obstacle_shape CELL.yaml

#include <cstdio>
#include <exception>

#include "examples/obstacle_shape/cone.hpp"
#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s CELL.yaml\n", argv[0]);
    return 2;
  }
  try {
    auto shapes = hecaton::config::shape_types();
    shapes.push_back(example::kCone);  // registers the type
    const auto file = hecaton::config::load_cell_file(argv[1], {}, hecaton::planner::built_in_methods(), shapes);
    hecaton::planner::BatchOptions options;
    options.tasks = 20;
    const hecaton::planner::BatchReport report = hecaton::planner::simulate_tasks(file.cell, options);
    std::printf("%d of %d goals reached, %llu contacts, smallest separation %.3f m\n", report.reached, report.tasks,
                static_cast<unsigned long long>(report.contacts), report.smallest.distance);
    return report.reached == options.tasks && report.contacts == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
