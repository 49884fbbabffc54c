// The world's checkpoint file.

#include "services/world/world_checkpoint.hpp"

#include "services/bus/message_file.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(world_checkpoint)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  const std::string path = fuzz::folder().write("world", fuzz::text_of({data, size}));
  const auto read = bus::read_message(path);
  fuzz::require(read.message.has_value() != read.error.has_value(), "a file gives a message or a sentence");
  if (!read.message) return 0;
  const auto world = services::restored(*read.message, {});
  fuzz::require(world || !world.error.empty(), "a checkpoint gives a world or a sentence");
  return 0;
}
