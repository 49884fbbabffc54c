// Follows a goal: prints its progress, holds and resumes the arm, and prints the outcome.
#include <cstdlib>
#include <iostream>
#include <syncstream>

#include <hecaton/client.hpp>

int main(int argc, char** argv) try {
  using namespace std::chrono_literals;
  if (argc != 4) {
    std::cerr << "usage: progress CELL ARM POSE\n";
    return EXIT_FAILURE;
  }
  const hecaton::Cell cell = hecaton::Cell::connect(argv[1]);
  const hecaton::Arm arm = cell.arm(argv[2]);

  const hecaton::ArmState before = arm.state();
  std::cout << arm.name() << " is " << name_of(before.mode) << "; its state is " << before.age.count() << " s old\n";

  const hecaton::Goal goal = arm.go_to(argv[3], {.time_limit = 60s});
  goal.on_progress([](const hecaton::Progress& progress) {  // in a thread of the library
    std::osyncstream line(std::cout);
    line << name_of(progress.state) << ", " << progress.distance << " rad to go";
    if (progress.cause) line << ": " << progress.cause.text;
    line << std::endl;
  });

  arm.hold();  // keeps the goal
  std::osyncstream(std::cout) << "held: the outcome is still " << goal.wait(1s).text() << std::endl;
  arm.resume();

  const hecaton::Outcome outcome = goal.wait(90s);
  std::osyncstream(std::cout) << outcome.text() << '\n';
  return outcome ? EXIT_SUCCESS : EXIT_FAILURE;
} catch (const hecaton::Error& error) {
  std::cerr << error.what() << '\n';
  return EXIT_FAILURE;
}
