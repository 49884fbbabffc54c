// The supervisor's checkpoint.

#include "services/supervisor/replication/checkpoint.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(supervisor_checkpoint)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  const auto checkpoint = services::parse_checkpoint(fuzz::text_of({data, size}));
  if (!checkpoint) return 0;
  const auto again = services::parse_checkpoint(services::checkpoint_text(*checkpoint));
  fuzz::require(again && services::checkpoint_text(*again) == services::checkpoint_text(*checkpoint),
                "a checkpoint that was read is written and read again");
  return 0;
}
