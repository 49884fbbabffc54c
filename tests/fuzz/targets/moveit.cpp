// A planning scene and a motion plan request of MoveIt's benchmarks.

#include "services/config/moveit_files.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

template <class Read>
void read(const Read& function) {
  try {
    function();
  } catch (const hecaton::config::ConfigError& error) {
    hecaton::fuzz::require_sentence(error.what());
  }
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(moveit)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  const std::string path = fuzz::folder().write("moveit.yaml", fuzz::text_of({data, size}));
  read([&] {
    for (const world::Obstacle& obstacle : config::read_moveit_scene(path).obstacles) {
      fuzz::require(!obstacle.shapes.empty() && obstacle.X_WO.matrix().allFinite(),
                    "an obstacle has shapes and a pose");
    }
  });
  read([&] { static_cast<void>(config::read_moveit_request(path)); });
  return 0;
}
