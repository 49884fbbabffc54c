/// hecaton render: a picture of a cell, or a picture or film of a recording.

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "services/cli/commands.hpp"
#include "services/cli/opened_recording.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"
#include "services/picture/picture_service.hpp"

namespace hecaton::services::cli {
namespace {

constexpr double kLatest = 1e9;         // [s]
constexpr double kLongestFilm = 600.0;  // [s]

struct RenderOptions {
  std::vector<std::string> inputs;
  std::string file;
  std::optional<double> at;        ///< [s]
  std::optional<double> duration;  ///< [s]
  std::string theme = "light";
  picture::PictureOptions picture;
};

bool is_recording(const std::string& path) {
  return path.ends_with(".mcap");
}

/// Throws Failure (bad input).
void require_fitting(const RenderOptions& options) {
  const bool png = options.file.ends_with(".png");
  if (!png && !options.file.ends_with(".webm")) {
    throw Failure(ExitCode::kBadInput, "-o '" + config::printable_path(options.file) +
                                           "' must end in .png for a picture or in .webm for a film");
  }
  const bool recorded = is_recording(options.inputs.front());
  if (!recorded && options.inputs.size() > 1) {
    throw Failure(ExitCode::kBadInput, "render takes one cell file, or the files of one recording (.mcap)");
  }
  if (recorded && (png ? !options.duration : true)) return;
  if (png && !options.at && !options.duration) return;
  throw Failure(ExitCode::kBadInput,
                png && recorded ? "--duration is for films: -o FILE.webm"
                                : "a cell file has no time: record the cell, and render the recording (.mcap)");
}

/// The former file stays until the new one is whole.
void write_file(const std::string& path, const std::string& content) {
  const std::string part = path + ".part";
  std::ofstream stream(part, std::ios::binary | std::ios::trunc);
  stream << content;
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(part, path, error);
  if (stream && !error) return;
  const std::string reason = error ? error.message() : std::string(std::strerror(errno));
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  throw Failure(ExitCode::kBadInput, "-o '" + config::printable_path(path) + "' cannot be written: " + reason);
}

/// Drawing takes minutes, so a file that cannot be written is refused before.
void require_writable(const std::string& path) {
  const std::string part = path + ".part";
  const bool writable = std::ofstream(part, std::ios::binary | std::ios::trunc).is_open();
  const std::string reason = std::strerror(errno);
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  if (writable && !std::filesystem::is_directory(path, ignored)) return;
  throw Failure(ExitCode::kBadInput, "-o '" + config::printable_path(path) + "' cannot be written: " +
                                         (writable ? "it is a folder" : reason) + "; name another file");
}

std::optional<std::string> draw(const RenderOptions& options,
                                const std::function<void(std::size_t, std::size_t)>& progress,
                                const std::function<bool()>& interrupted) {
  if (!is_recording(options.inputs.front())) {
    const config::CellFile file = config::load_cell_file(options.inputs.front());
    const view::Drawings drawings(file);
    return picture::take_picture(file, drawings, std::nullopt, options.picture, progress, interrupted);
  }
  const std::unique_ptr<OpenedRecording> recording = open_recording(options.inputs);
  const std::string& drawn = recording->files.note;
  if (!drawn.empty()) std::fprintf(stderr, "hecaton: %s\n", drawn.c_str());
  const double from = options.at.value_or(0.0);
  static_cast<void>(time_in(*recording, from, "--at"));
  const double until = options.duration ? from + *options.duration : std::min(recording->length(), from + kLongestFilm);
  static_cast<void>(time_in(*recording, until, "--at plus --duration"));
  replay::Replay replay(recording->cell);
  const picture::Recorded recorded{replay, from, until};
  return picture::take_picture(recording->files.cell, recording->files.drawings, recorded, options.picture, progress,
                               interrupted);
}

ExitCode run_render(const Settings& settings, RenderOptions& options) {
  require_fitting(options);
  require_writable(options.file);
  options.picture.film = options.file.ends_with(".webm");
  options.picture.dark = options.theme == "dark";
  const Interruption interruption;
  Progress progress;
  std::size_t frame = 0;
  std::size_t frames = options.picture.film ? 0 : 1;
  std::optional<std::string> content;
  try {
    static_cast<void>(picture::find_browser());
    content = draw(
        options,
        [&](std::size_t done, std::size_t all) {
          frame = done;
          frames = all;
          progress.show("drawing " + options.file, static_cast<double>(done), static_cast<double>(all), "frames");
        },
        [&] { return interruption.requested(); });
  } catch (const Failure&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Failure(ExitCode::kBadInput, error.what());
  }
  progress.clear();
  const auto interrupted = content ? std::nullopt : interruption.after(frame, frames, "frames");
  if (interrupted) throw Failure(interrupted->exit_code(), interrupted->text() + "; no file was written");
  const auto size = static_cast<double>(content->size());
  write_file(options.file, *content);
  print(settings, {{"file", options.file}, {"bytes", size}, {"frames", options.picture.film ? frames : 1}},
        options.file + ": " + bytes_text(size) + "\n");
  return ExitCode::kDone;
}

}  // namespace

void add_render(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("render", "Draws a picture of a cell, or a picture or film of a recording");
  auto options = std::make_shared<RenderOptions>();
  command
      ->add_option("FILE", options->inputs,
                   "cell file (YAML); or recording (.mcap), the files of a split recording in their order")
      ->required()
      ->expected(1, 10000);
  command
      ->add_option("-o,--file", options->file, "picture (.png) or film (.webm) to write; an existing file is replaced")
      ->required()
      ->type_name("FILE");
  add_number(
      *command, "--at", [options](double at) { options->at = at; },
      "time of the recording, since its begin [s]; of a film the first one (0)", config::Bounds{0.0, kLatest, "s"});
  add_number(
      *command, "--duration", [options](double duration) { options->duration = duration; },
      "time of the recording that a film shows [s] (to its end, 600 at most)", config::Bounds{0.0, kLongestFilm, "s"});
  add_number(
      *command, "--speed", [options](double speed) { options->picture.speed = speed; },
      "speed of a film: 2 shows 2 s of the recording in a second (1)", config::Bounds{0.01, 100.0, ""});
  add_whole_number(
      *command, "--fps", [options](std::uint64_t rate) { options->picture.frame_rate = static_cast<double>(rate); },
      "frames per second of a film (25)", 1, 120);
  add_whole_number(
      *command, "--width", [options](std::uint64_t width) { options->picture.width = static_cast<int>(width); },
      "in pixels (1280)", 64, 7680);
  add_whole_number(
      *command, "--height", [options](std::uint64_t height) { options->picture.height = static_cast<int>(height); },
      "in pixels (720)", 64, 4320);
  add_choice(*command, "--view", options->picture.view, {"free", "left", "top", "front", "side"},
             "from where the cell is seen (free: from above the front right; left: from above the front left)");
  add_choice(*command, "--theme", options->theme, {"light", "dark"}, "background (light)");
  options->picture.layers = {"goals", "ways", "binding"};
  add_choices(*command, "--layers", options->picture.layers,
              {"goals", "ways", "binding", "halos", "planning", "trails", "names"},
              "what is drawn beside arms and obstacles (goals,ways,binding)");
  command->footer(
      "It needs chromium, which opens the page of the view without a window. A cell file is drawn as it starts. Of a "
      "recording, --layers trails draws the ways of the tools from 2 s earlier on.");
  command->callback(
      [&session, options] { session.action = [&session, options] { return run_render(session.settings, *options); }; });
}

}  // namespace hecaton::services::cli
