// A cell file, as if it stood in tests/data/bad: it may name the URDFs there. The only robot by name is `tiny`, because
// models of real robots take seconds under sanitizers.

#include "services/config/cell_file.hpp"

#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(cell_file)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  static const std::string kPath = fuzz::source("tests/data/bad/fuzz.yaml");
  static const int kTiny = ::setenv("HECATON_ROBOTS", fuzz::source("tests/fuzz/robots").c_str(), 1);
  static_cast<void>(kTiny);
  try {
    const config::CellFile file = config::parse_cell_file(fuzz::text_of({data, size}), kPath);
    fuzz::require(!file.cell.arms.empty() && file.arm_hosts.size() == file.cell.arms.size() &&
                      file.devices.size() == file.cell.arms.size() && !file.hosts.empty(),
                  "a cell has arms, and a host and a device for each");
  } catch (const config::ConfigError& error) {
    fuzz::require_sentence(error.what());
  }
  return 0;
}
