#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "services/cli/application.hpp"

int main(int argc, char** argv) {
  using namespace hecaton::services::cli;
  const auto code = static_cast<int>(run_program(hecaton_program(), argc, argv));
  // The last static destructor of Fast DDS sleeps for 100 ms, longer than a whole question and its answer take. All
  // participants have said goodbye by now, so it has nothing to wait for.
  std::cout.flush();
  std::fflush(nullptr);
  std::_Exit(code);
}
