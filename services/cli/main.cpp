#include "services/cli/application.hpp"

int main(int argc, char** argv) {
  return static_cast<int>(hecaton::services::cli::run_application(argc, argv));
}
