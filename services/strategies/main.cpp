#include "services/config/link_pair_cache.hpp"
#include "services/strategies/commands.hpp"

int main(int argc, char** argv) {
  using namespace hecaton::services::cli;
  hecaton::config::use_link_pair_folder();
  return static_cast<int>(run_program(strategies_program(), argc, argv));
}
