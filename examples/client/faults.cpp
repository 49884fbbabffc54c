// Prints the begin and the end of each fault of a cell, until Ctrl-C.
#include <cstdlib>
#include <iostream>

#include <hecaton/client.hpp>

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: faults CELL\n";
    return EXIT_FAILURE;
  }
  const hecaton::Cell cell = hecaton::Cell::connect(argv[1]);
  cell.on_fault([](const hecaton::Fault& fault) {
    std::cout << (fault.cleared ? "cleared: " : "fault: ") << fault.cause.subject << ": " << fault.cause.text
              << std::endl;
  });
  std::cout << "listening to cell " << cell.status().cell << std::endl;

  cell.wait_until([] { return false; }, hecaton::kForever);
  return EXIT_SUCCESS;
} catch (const hecaton::Error& error) {
  std::cerr << error.what() << '\n';
  return EXIT_FAILURE;
}
