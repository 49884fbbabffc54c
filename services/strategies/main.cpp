#include "services/strategies/commands.hpp"

int main(int argc, char** argv) {
  using namespace hecaton::services::cli;
  return static_cast<int>(run_program(strategies_program(), argc, argv));
}
