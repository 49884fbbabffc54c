// A recording (MCAP). The first byte 1: the bytes are the records of one chunk, which gets its CRC here; otherwise they
// are the whole file.

#include "services/recorder/bag.hpp"
#include "services/replay/replay.hpp"
#include "services/view/state_json.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace hecaton;
using namespace hecaton::services;

std::string chunk_file(fuzz::View records) {
  recorder::Bytes body;
  recorder::ByteWriter(body)
      .number(std::uint64_t{0})
      .number(std::uint64_t{0})
      .number(std::uint64_t{records.size()})
      .number(recorder::crc32_of(records))
      .text("")
      .number(std::uint64_t{records.size()})
      .bytes(records);
  recorder::Bytes file;
  recorder::ByteWriter(file)
      .bytes(recorder::kMagic)
      .number(static_cast<std::uint8_t>(recorder::Opcode::kChunk))
      .number(std::uint64_t{body.size()})
      .bytes(body);
  return fuzz::text_of(file);
}

template <class Read>
void read_recording(const Read& function) {
  try {
    function();
  } catch (const recorder::RecordingError& error) {
    fuzz::require_sentence(error.what());
  }
}

void replay_all(const std::string& path) {
  static const config::CellFile kCell = config::load_cell_file(fuzz::source("deploy/cells/three_puma.yaml"));
  const replay::RecordingIndex index = replay::index_recording({path}, kCell);
  replay::RecordedCell cell(index);
  replay::Replay play(cell);
  play.command(R"({"op":"seek","at":5})");
  play.command(R"({"op":"step","by":1})");
  play.command(R"({"op":"play"})");
  play.advance(std::chrono::seconds(1));
  play.seek(index.end);
  play.command(R"({"op":"step","by":-1,"arm":"north"})");
  for (const auto& json : {play.playback_json(), play.recording_json(), view::frame_json(play, {}),
                           view::status_json(play, {}), view::obstacles_json(play.state())}) {
    fuzz::require(!json.dump().empty(), "the page shows each state");
  }
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(recording)(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const bool is_chunk = input.byte() == 1;
  const fuzz::View bytes = input.rest();
  const std::string path = fuzz::folder().write("run.mcap", is_chunk ? chunk_file(bytes) : fuzz::text_of(bytes));
  read_recording([&] { static_cast<void>(recorder::bag_info(path)); });
  read_recording([&] {
    const std::string tables = fuzz::folder().path("csv");
    std::filesystem::remove_all(tables);
    static_cast<void>(recorder::export_csv({path}, tables));
  });
  read_recording([&] { replay_all(path); });
  return 0;
}
