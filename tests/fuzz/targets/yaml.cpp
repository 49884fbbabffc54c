// A YAML document as a tree, without what a cell makes of it.

#include "services/config/yaml_tree.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(yaml)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  try {
    static_cast<void>(config::read_yaml_text(fuzz::text_of({data, size}), "fuzz.yaml"));
  } catch (const config::ConfigError& error) {
    fuzz::require_sentence(error.what());
  }
  return 0;
}
