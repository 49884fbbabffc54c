// A message of a page to a replay (WebSocket, JSON).

#include "services/recorder/mcap_writer.hpp"
#include "services/replay/replay.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/support/cdr.hpp"

namespace {

using namespace hecaton;
using namespace hecaton::services;

/// A recording of four states of an arm.
std::string recording() {
  const std::string path = fuzz::folder().path("commands.mcap");
  recorder::McapWriter file(path, "hecaton");
  const auto schema = file.add_schema("hecaton::msg::ArmState", "omgidl", "");
  const auto channel = file.add_channel(schema, "hecaton/ArmState", "cdr", {});
  for (std::uint64_t i = 1; i < 5; ++i) {
    msg::ArmState state;
    state.arm("north");
    state.sequence_number(i);
    state.q(std::vector<double>(6, 0.1));
    state.qd(std::vector<double>(6, 0.0));
    const auto bytes = test::cdr_of(state);
    file.write({channel, 0, i * 1'000'000'000U, i * 1'000'000'000U, bytes});
  }
  file.close();
  return path;
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(replay_command)(const std::uint8_t* data, std::size_t size) {
  static const config::CellFile kCell = config::load_cell_file(fuzz::source("deploy/cells/three_puma.yaml"));
  static const replay::RecordingIndex kIndex = replay::index_recording({recording()}, kCell);
  static replay::RecordedCell cell(kIndex);
  replay::Replay play(cell);
  const std::string text = fuzz::text_of({data, size});
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    play.command(std::string_view(text).substr(begin, end - begin));
    play.advance(std::chrono::milliseconds(20));
    fuzz::require(play.now() >= kIndex.begin && play.now() <= kIndex.end, "a replay stays within its recording");
    begin = end + 1;
  }
  fuzz::require(!play.playback_json().dump().empty(), "the page shows where the replay is");
  return 0;
}
