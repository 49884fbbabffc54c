// Adds an obstacle, moves two arms to named poses at the same time, and waits for both.
#include <iostream>

#include <hecaton/client.hpp>

int main(int argc, char** argv) try {
  using namespace std::chrono_literals;
  if (argc != 2) throw hecaton::InvalidArgument("usage: ten_lines CELL_FILE");
  const auto cell = hecaton::Cell::connect(argv[1]);
  cell.world().add("crate", hecaton::Box{0.2, 0.2, 0.2}, hecaton::Pose::xyz(1.5, 1.5, 0.1));
  const auto north = cell.arm("north").go_to("ready");
  const auto west = cell.arm("west").go_to("ready", {.time_limit = 60s});
  cell.wait_all({north, west}, 90s);
  std::cout << "north: " << north.wait().text() << "\nwest: " << west.wait().text() << '\n';
  cell.world().remove("crate");
} catch (const hecaton::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
