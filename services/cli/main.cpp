#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "services/cli/commands.hpp"
#include "services/config/link_pair_cache.hpp"

int main(int argc, char** argv) {
  using namespace hecaton::services::cli;
  hecaton::config::use_link_pair_folder();
  const auto code = static_cast<int>(run_program(hecaton_program(), argc, argv));
  // Skips the static destructors: the last one of Fast DDS sleeps for 100 ms, longer than a request and its reply take.
  // All participants have left the domain by now.
  std::cout.flush();
  std::fflush(nullptr);
  std::_Exit(code);
}
